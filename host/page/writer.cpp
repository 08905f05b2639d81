#include "host/page/writer.h"

#include <cassert>
#include <utility>

#include "host/base/text.h"

namespace fascicle::page {

namespace {

// Removes two code points that Unicode has and XML does not.
std::string without_noncharacters(std::string text) {
  for (const auto& [code_point, shown] :
       {std::pair("\xef\xbf\xbe", "\\ufffe"), std::pair("\xef\xbf\xbf", "\\uffff")})
    for (std::size_t at = text.find(code_point); at != std::string::npos; at = text.find(code_point, at))
      text.replace(at, 3, shown);
  return text;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : without_noncharacters(base::shown_text(text))) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

void Writer::tag(std::string_view name, const Attributes& attributes, std::string_view end) {
  out_ += '<';
  out_ += name;
  for (const auto& [key, value] : attributes) {
    out_ += ' ';
    out_ += key;
    out_ += "=\"" + escaped(value) + '"';
  }
  out_ += end;
}

Writer& Writer::start(std::string_view name, const Attributes& attributes) {
  tag(name, attributes, ">");
  open_.emplace_back(name);
  return *this;
}

Writer& Writer::empty(std::string_view name, const Attributes& attributes) {
  tag(name, attributes, "/>");
  return *this;
}

Writer& Writer::text(std::string_view text) {
  out_ += escaped(text);
  return *this;
}

Writer& Writer::line_end() {
  out_ += '\n';
  return *this;
}

Writer& Writer::close() {
  assert(!open_.empty());
  out_ += "</" + open_.back() + ">";
  open_.pop_back();
  // One element per line at the outer levels, for easier reading and comparing.
  if (open_.size() <= 3) out_ += '\n';
  return *this;
}

Writer& Writer::element(std::string_view name, std::string_view text, const Attributes& attributes) {
  return start(name, attributes).text(text).close();
}

Writer& Writer::style(std::string_view css) {
  assert(css.find_first_of("<&") == std::string_view::npos);
  start("style");
  out_ += css;
  return close();
}

std::string Writer::finish() && {
  assert(open_.empty());
  return std::move(out_);
}

}  // namespace fascicle::page
