#include "host/cli/shown_output.h"

#include "host/base/text.h"

namespace fascicle::cli {

ShownOutput::ShownOutput(std::ostream& stream) : stream_(stream), below_(stream.rdbuf(this)) {
  // rdbuf() has cleared the state.
  if (below_ == nullptr) stream_.setstate(std::ios::badbit);
}

ShownOutput::~ShownOutput() {
  stream_.flush();
  const std::ios::iostate state = stream_.rdstate();
  stream_.rdbuf(below_);
  stream_.setstate(state);
}

bool ShownOutput::put_out(std::size_t count) {
  const std::string text = base::shown_lines(std::string_view(waiting_).substr(0, count));
  waiting_.erase(0, count);
  const auto size = static_cast<std::streamsize>(text.size());
  return below_->sputn(text.data(), size) == size;
}

std::streambuf::int_type ShownOutput::overflow(int_type c) {
  if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
  const char one = traits_type::to_char_type(c);
  return xsputn(&one, 1) == 1 ? c : traits_type::eof();
}

std::streamsize ShownOutput::xsputn(const char* text, std::streamsize count) {
  waiting_.append(text, static_cast<std::size_t>(count));
  const std::size_t end = waiting_.rfind('\n');
  return end == std::string::npos || put_out(end + 1) ? count : 0;
}

int ShownOutput::sync() {
  const bool is_out = waiting_.empty() || put_out(waiting_.size());
  return is_out && below_->pubsync() == 0 ? 0 : -1;
}

}  // namespace fascicle::cli
