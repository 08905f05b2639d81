#include "host/studio/server.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <fcntl.h>

#include "host/studio/access.h"

namespace fascicle::studio {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using beast::error_code;

namespace {

constexpr auto request_patience = std::chrono::seconds(5);  // to receive a request
constexpr auto answer_patience = std::chrono::seconds(30);  // to send an answer
constexpr auto parting_patience = std::chrono::seconds(5);  // for a page that is sent away to say goodbye
constexpr std::uint32_t longest_header = 16 << 10;
constexpr std::uint64_t longest_body = 1 << 10;
// The kernel's send buffer per page: small, so that for slow pages frames are dropped here instead of queued
// there.
constexpr int socket_buffer = 256 << 10;

// Asio leaves this out. A browser started by this program would keep the port after the program's end.
void close_on_exec(int socket) {
  ::fcntl(socket, F_SETFD, FD_CLOEXEC);
}

}  // namespace

struct Server::Impl {
  class Page;
  class Request;
  struct Outgoing {
    bool is_text = false;
    SharedBytes bytes;
  };

  Impl(ServerOptions given, ServerEvents given_events);
  ~Impl();

  void accept();
  bool makes_room();
  std::shared_ptr<Page> page(PageId id) const;
  void add(const std::shared_ptr<Page>& page);
  void remove(PageId id);

  const ServerOptions options;
  const ServerEvents events;
  std::atomic<std::size_t> connections = 0;  // atomic, because another thread may destroy a page
  asio::io_context context{1};
  tcp::acceptor acceptor{context};
  asio::steady_timer pause{context};
  std::uint16_t port = 0;
  std::deque<std::weak_ptr<Request>> requests;  // oldest first; for the server's thread
  mutable std::mutex mutex;                     // guards the members below
  std::map<PageId, std::shared_ptr<Page>> pages;
  PageId last_page = 0;
  std::thread thread;
};

// An open WebSocket. Members not guarded by its mutex belong to the server's thread.
class Server::Impl::Page : public std::enable_shared_from_this<Page> {
 public:
  Page(Impl& server, beast::tcp_stream&& stream, PageId number)
      : server_(server), stream_(std::move(stream)), number_(number) {
    ++server_.connections;
  }
  ~Page() { --server_.connections; }

  PageId number() const { return number_; }

  void open(const http::request<http::string_body>& request) {
    beast::get_lowest_layer(stream_).expires_never();
    auto timeout = websocket::stream_base::timeout::suggested(beast::role_type::server);
    timeout.keep_alive_pings = true;
    stream_.set_option(timeout);
    stream_.read_message_max(server_.options.longest_message);
    stream_.auto_fragment(false);
    stream_.async_accept(request, [self = shared_from_this()](error_code error) {
      if (error) return;
      self->server_.add(self);
      if (self->server_.events.opened) self->server_.events.opened(self->number_);
      self->read();
    });
  }

  void put(Outgoing message) {
    {
      const std::lock_guard lock(mutex_);
      if (is_over_) return;
      waiting_bytes_ += message.bytes->size();
      if (waiting_bytes_ > server_.options.most_waiting) {
        is_over_ = true;
        waiting_.clear();
        offered_.reset();
      } else {
        waiting_.push_back(std::move(message));
      }
    }
    wake();
  }
  void offer(SharedBytes bytes) {
    {
      const std::lock_guard lock(mutex_);
      if (is_over_) return;
      offered_ = std::move(bytes);
    }
    wake();
  }
  bool is_free() const {
    const std::lock_guard lock(mutex_);
    return !offered_;
  }
  void end(std::string reason) {
    {
      const std::lock_guard lock(mutex_);
      if (is_over_ || reason_) return;
      reason_ = std::move(reason);
    }
    wake();
  }
  // Closes without sending what is queued.
  void drop() {
    error_code ignored;
    beast::get_lowest_layer(stream_).socket().close(ignored);
  }

 private:
  void read() {
    stream_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return self->is_gone();
      std::string bytes = beast::buffers_to_string(self->buffer_.data());
      self->buffer_.consume(self->buffer_.size());
      if (self->server_.events.received && !self->is_sent_away())
        self->server_.events.received(self->number_, self->stream_.got_text(), std::move(bytes));
      self->read();
    });
  }

  void wake() {
    asio::post(server_.context, [self = shared_from_this()] { self->write(); });
  }

  bool is_sent_away() const {
    const std::lock_guard lock(mutex_);
    return reason_ || is_over_;
  }

  // A page that does not read ends no write and reads no close message.
  void drop_after_a_while() {
    parting_.emplace(server_.context, parting_patience);
    parting_->async_wait([self = shared_from_this()](error_code error) {
      if (!error) self->drop();
    });
  }

  void write() {
    if (is_closed_) return;
    {
      const std::lock_guard lock(mutex_);
      if (is_over_) {
        is_closed_ = true;
        drop();
        return;
      }
      if (reason_ && !parting_) drop_after_a_while();
      if (is_writing_) return;
      if (!waiting_.empty()) {
        current_ = std::move(waiting_.front());
        waiting_.pop_front();
        waiting_bytes_ -= current_.bytes->size();
      } else if (offered_ && !reason_) {
        current_ = {false, std::move(offered_)};
        offered_.reset();
      } else if (reason_) {
        is_closed_ = true;
      } else {
        return;
      }
    }
    if (is_closed_) {
      stream_.async_close({websocket::close_code::policy_error, reason_->substr(0, 120)},
                          [self = shared_from_this()](error_code) {});
      return;
    }
    is_writing_ = true;
    stream_.text(current_.is_text);
    stream_.async_write(asio::buffer(*current_.bytes),
                        [self = shared_from_this()](error_code error, std::size_t) {
                          self->is_writing_ = false;
                          self->current_ = {};
                          if (!error) self->write();
                        });
  }

  void is_gone() {
    is_closed_ = true;
    if (parting_) parting_->cancel();
    {
      const std::lock_guard lock(mutex_);
      is_over_ = true;
      waiting_.clear();
      offered_.reset();
    }
    server_.remove(number_);
    if (server_.events.closed) server_.events.closed(number_);
  }

  Impl& server_;
  websocket::stream<beast::tcp_stream> stream_;
  const PageId number_;
  beast::flat_buffer buffer_;
  bool is_writing_ = false, is_closed_ = false;
  std::optional<asio::steady_timer> parting_;
  Outgoing current_;

  mutable std::mutex mutex_;  // guards the members below
  std::deque<Outgoing> waiting_;
  std::size_t waiting_bytes_ = 0;
  SharedBytes offered_;
  std::optional<std::string> reason_;
  bool is_over_ = false;
};

// A connection that is not a WebSocket yet.
class Server::Impl::Request : public std::enable_shared_from_this<Request> {
 public:
  Request(Impl& server, tcp::socket&& socket) : server_(server), stream_(std::move(socket)) {
    ++server_.connections;
  }
  ~Request() { --server_.connections; }

  void read() {
    parser_.emplace();
    parser_->header_limit(longest_header);
    parser_->body_limit(longest_body);
    stream_.expires_after(request_patience);
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error == http::error::end_of_stream) return self->end();
      if (error == http::error::header_limit)
        return self->answer_text(http::status{431}, "the header is too long");
      if (error == http::error::body_limit)
        return self->answer_text(http::status::payload_too_large, "the body is too long");
      if (error && error.category() == http::make_error_code(http::error::bad_method).category())
        return self->answer_text(http::status::bad_request, "not a valid request");
      if (error) return;
      self->take(self->parser_->release());
    });
  }
  // Ends what is under way, without an answer.
  void drop() { stream_.close(); }

 private:
  // A header's value if it occurs exactly once.
  static std::optional<std::string_view> only(const http::request<http::string_body>& request,
                                              http::field field) {
    const auto [first, last] = request.equal_range(field);
    if (first == last || std::next(first) != last) return std::nullopt;
    return std::string_view(first->value().data(), first->value().size());
  }

  void take(http::request<http::string_body> request) {
    keeps_alive_ = request.keep_alive();
    is_head_ = request.method() == http::verb::head;
    const auto host = only(request, http::field::host);
    if (!host || !is_own_host(*host, server_.port))
      return answer_text(http::status{421}, "this server's address is " + address() + "; use it");
    const auto origin = only(request, http::field::origin);
    if ((origin && !is_own_origin(*origin, server_.port)) ||
        (!origin && request.count(http::field::origin) > 0))
      return answer_text(http::status::forbidden, "only requests from the studio's own page are accepted");
    if (request.method() != http::verb::get && request.method() != http::verb::head)
      return answer_text(http::status::method_not_allowed, "only GET and HEAD are allowed");
    const std::string_view text(request.target().data(), request.target().size());
    const std::optional<Target> target = parse_target(text);
    if (!target) return answer_text(http::status::not_found, "not found");
    if (target->path == "live") return take_page(std::move(request), *target, origin.has_value());
    for (const ServedFile& file : server_.options.files)
      if (file.name == target->path) return answer_file(file);
    // Browsers request it unasked; the page has none.
    if (target->path == "favicon.ico") return answer_nothing();
    answer_text(http::status::not_found, "not found");
  }

  void take_page(http::request<http::string_body> request, const Target& target, bool has_origin) {
    if (!websocket::is_upgrade(request))
      return answer_text(http::status::upgrade_required, "this address is for the page's WebSocket");
    if (!has_origin)
      return answer_text(http::status::forbidden, "a WebSocket request must have an Origin header");
    if (!target.token || !is_token(*target.token, server_.options.token))
      return answer_text(http::status::forbidden,
                         "wrong token; open the address that fascicle studio printed");
    PageId number = 0;
    {
      const std::lock_guard lock(server_.mutex);
      if (server_.pages.size() < server_.options.most_pages) number = ++server_.last_page;
    }
    if (number == 0)
      return answer_text(http::status::service_unavailable, "too many pages are open; close one");
    const auto page = std::make_shared<Page>(server_, std::move(stream_), number);
    page->open(request);
  }

  std::string address() const { return "http://127.0.0.1:" + std::to_string(server_.port); }

  void answer_file(const ServedFile& file) {
    http::response<http::string_body> response{http::status::ok, 11};
    response.set(http::field::content_type, boost::string_view(file.type.data(), file.type.size()));
    response.body().assign(file.text);
    answer(std::move(response));
  }

  void answer_nothing() { answer(http::response<http::string_body>{http::status::no_content, 11}); }

  void answer_text(http::status status, const std::string& text) {
    http::response<http::string_body> response{status, 11};
    response.set(http::field::content_type, "text/plain; charset=utf-8");
    if (status == http::status::method_not_allowed) response.set(http::field::allow, "GET, HEAD");
    response.body() = text + "\n";
    if (status != http::status::not_found) keeps_alive_ = false;
    answer(std::move(response));
  }

  void answer(http::response<http::string_body> response) {
    response.set("Content-Security-Policy", content_security_policy(server_.port));
    response.set("X-Content-Type-Options", "nosniff");
    response.set("X-Frame-Options", "DENY");
    response.set("Referrer-Policy", "no-referrer");
    response.set("Cross-Origin-Opener-Policy", "same-origin");
    response.set("Cross-Origin-Resource-Policy", "same-origin");
    response.set("Cross-Origin-Embedder-Policy", "require-corp");
    response.set(http::field::cache_control, "no-store");
    response.keep_alive(keeps_alive_);
    response.prepare_payload();
    if (is_head_) response.body().clear();
    response_ = std::move(response);
    stream_.expires_after(answer_patience);
    const auto then = [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return;
      self->keeps_alive_ ? self->read() : self->end();
    };
    if (is_head_) {
      head_.emplace(*response_);
      http::async_write_header(stream_, *head_, then);
    } else {
      http::async_write(stream_, *response_, then);
    }
  }

  void end() {
    error_code ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
  }

  Impl& server_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{longest_header + longest_body};
  std::optional<http::request_parser<http::string_body>> parser_;
  std::optional<http::response<http::string_body>> response_;
  std::optional<http::response_serializer<http::string_body>> head_;
  bool keeps_alive_ = false, is_head_ = false;
};

Server::Impl::Impl(ServerOptions given, ServerEvents given_events)
    : options(std::move(given)), events(std::move(given_events)) {
  const tcp::endpoint loopback(asio::ip::address_v4::loopback(), options.port);
  acceptor.open(loopback.protocol());
  close_on_exec(acceptor.native_handle());
  acceptor.set_option(tcp::acceptor::reuse_address(true));
  acceptor.bind(loopback);
  acceptor.listen();
  port = acceptor.local_endpoint().port();
  accept();
  thread = std::thread([this] { context.run(); });
}

Server::Impl::~Impl() {
  asio::post(context, [this] {
    error_code ignored;
    acceptor.close(ignored);
    context.stop();
  });
  thread.join();
}

// Whether there is room for one more connection. Drops the oldest request if need be: it needed no token, so
// it must not keep the user's page out.
bool Server::Impl::makes_room() {
  std::erase_if(requests, [](const auto& request) { return request.expired(); });
  if (connections < options.most_connections) return true;
  if (requests.empty()) return false;
  if (const auto oldest = requests.front().lock()) oldest->drop();
  requests.pop_front();
  return true;
}

void Server::Impl::accept() {
  acceptor.async_accept([this](error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (error) {
      // For example, no file descriptors are left. Retrying at once would be a busy loop.
      pause.expires_after(std::chrono::milliseconds(100));
      pause.async_wait([this](error_code stopped) {
        if (!stopped) accept();
      });
      return;
    }
    if (makes_room()) {
      close_on_exec(socket.native_handle());
      error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      socket.set_option(asio::socket_base::send_buffer_size(socket_buffer), ignored);
      const auto request = std::make_shared<Request>(*this, std::move(socket));
      requests.push_back(request);
      request->read();
    }
    accept();
  });
}

std::shared_ptr<Server::Impl::Page> Server::Impl::page(PageId id) const {
  const std::lock_guard lock(mutex);
  const auto found = pages.find(id);
  return found == pages.end() ? nullptr : found->second;
}

void Server::Impl::add(const std::shared_ptr<Page>& page) {
  const std::lock_guard lock(mutex);
  pages.emplace(page->number(), page);
}

void Server::Impl::remove(PageId id) {
  const std::lock_guard lock(mutex);
  pages.erase(id);
}

Server::Server(ServerOptions options, ServerEvents events) {
  try {
    impl_ = std::make_unique<Impl>(std::move(options), std::move(events));
  } catch (const boost::system::system_error& error) {
    throw std::system_error(error.code().value(), std::generic_category(), "the studio cannot listen");
  }
}

Server::~Server() = default;

std::uint16_t Server::port() const {
  return impl_->port;
}

void Server::send_text(PageId page, SharedBytes text) {
  if (const auto open = impl_->page(page)) open->put({true, std::move(text)});
}

void Server::send_binary(PageId page, SharedBytes bytes) {
  if (const auto open = impl_->page(page)) open->put({false, std::move(bytes)});
}

void Server::offer(PageId page, SharedBytes bytes) {
  if (const auto open = impl_->page(page)) open->offer(std::move(bytes));
}

bool Server::is_free(PageId page) const {
  const auto open = impl_->page(page);
  return !open || open->is_free();
}

void Server::close(PageId page, std::string reason) {
  if (const auto open = impl_->page(page)) open->end(std::move(reason));
}

}  // namespace fascicle::studio
