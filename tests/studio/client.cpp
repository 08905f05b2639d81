#include "tests/studio/client.h"

#include <cstdlib>
#include <stdexcept>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <gtest/gtest.h>

namespace fascicle::tests {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;

struct Client::Impl {
  asio::io_context context;
  websocket::stream<beast::tcp_stream> stream{context};
  beast::flat_buffer buffer;
  bool is_reading = false, is_closed = false;
  std::optional<Message> received;

  void read() {
    is_reading = true;
    stream.async_read(buffer, [this](beast::error_code error, std::size_t) {
      is_reading = false;
      if (error) {
        is_closed = true;
        return;
      }
      received = Message{stream.got_text(), beast::buffers_to_string(buffer.data())};
      buffer.consume(buffer.size());
    });
  }
};

Client::Client(std::uint16_t port, const std::string& token, const ClientOptions& options)
    : impl_(std::make_unique<Impl>()) {
  const std::string own = "127.0.0.1:" + std::to_string(port);
  auto& socket = beast::get_lowest_layer(impl_->stream).socket();
  socket.open(tcp::v4());
  if (options.receive_buffer > 0)
    socket.set_option(asio::socket_base::receive_buffer_size(options.receive_buffer));
  socket.connect({asio::ip::address_v4::loopback(), port});
  impl_->stream.read_message_max(0);
  impl_->stream.set_option(websocket::stream_base::decorator(
      [&](websocket::request_type& request) { request.set(beast::http::field::origin, "http://" + own); }));
  websocket::response_type response;
  beast::error_code error;
  impl_->stream.handshake(response, own, "/live?token=" + token, error);
  if (error) throw std::runtime_error(error.message());
}

Client::~Client() {
  beast::error_code ignored;
  beast::get_lowest_layer(impl_->stream).socket().close(ignored);
  impl_->context.run_for(std::chrono::milliseconds(100));
}

void Client::say_text(const std::string& text) {
  impl_->stream.text(true);
  beast::error_code error;
  impl_->stream.write(asio::buffer(text), error);
}

void Client::say_binary(const std::string& bytes) {
  impl_->stream.binary(true);
  beast::error_code error;
  impl_->stream.write(asio::buffer(bytes), error);
}

void Client::say(const Json& message) {
  say_text(message.dump());
}

std::optional<Message> Client::next(std::chrono::milliseconds patience) {
  const auto latest = std::chrono::steady_clock::now() + patience;
  impl_->received.reset();
  if (!impl_->is_reading && !impl_->is_closed) impl_->read();
  while (!impl_->received && !impl_->is_closed && std::chrono::steady_clock::now() < latest) {
    impl_->context.restart();
    impl_->context.run_one_until(latest);
  }
  return std::move(impl_->received);
}

bool Client::is_closed() const {
  return impl_->is_closed;
}

std::string Client::close_reason() const {
  const auto& reason = impl_->stream.reason().reason;
  return std::string(reason.data(), reason.size());
}

Json Client::wait_for(const std::string& type, std::chrono::milliseconds patience) {
  const auto latest = std::chrono::steady_clock::now() + patience;
  while (std::chrono::steady_clock::now() < latest) {
    const std::optional<Message> message = next(patience);
    if (!message) break;
    if (!message->is_text) continue;
    Json said = Json::parse(message->bytes);
    if (said.at("type") == type) return said;
  }
  ADD_FAILURE() << "no message \"" << type << "\" came"
                << (is_closed() ? "; the server closed: " + close_reason() : "");
  return {};
}

std::string Client::wait_for_frame(const std::function<bool(const std::string&)>& is_wanted,
                                   std::chrono::milliseconds patience) {
  const auto latest = std::chrono::steady_clock::now() + patience;
  while (std::chrono::steady_clock::now() < latest) {
    const std::optional<Message> message = next(patience);
    if (!message) break;
    if (!message->is_text && !message->bytes.empty() && message->bytes[0] == 1 && is_wanted(message->bytes))
      return message->bytes;
  }
  ADD_FAILURE() << "no such frame arrived";
  return {};
}

namespace {

// The server may keep a connection open after an answer.
bool is_whole(const std::string& answer) {
  const std::size_t body = answer.find("\r\n\r\n"), length = answer.find("\r\nContent-Length: ");
  if (body == std::string::npos) return false;
  if (answer.starts_with("HTTP/1.1 101")) return true;
  return length < body && answer.size() >= body + 4 + std::strtoul(&answer[length + 18], nullptr, 10);
}

}  // namespace

std::string raw_request(std::uint16_t port, const std::string& request) {
  asio::io_context context;
  beast::tcp_stream stream(context);
  stream.socket().open(tcp::v4());
  stream.socket().connect({asio::ip::address_v4::loopback(), port});
  std::string answer;
  beast::error_code ignored;
  asio::write(stream.socket(), asio::buffer(request), ignored);
  std::string chunk(4096, '\0');
  stream.expires_after(std::chrono::seconds(30));
  std::function<void()> read = [&] {
    stream.async_read_some(asio::buffer(chunk), [&](beast::error_code error, std::size_t count) {
      answer.append(chunk, 0, count);
      if (!error && !is_whole(answer)) read();
    });
  };
  read();
  context.run();
  return answer;
}

int status_of(const std::string& answer) {
  return answer.starts_with("HTTP/1.1 ") && answer.size() > 12 ? std::atoi(answer.substr(9, 3).c_str()) : 0;
}

}  // namespace fascicle::tests
