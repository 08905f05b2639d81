// The server alone: access, refusals, and the cost of a page that does not read.
#include "host/studio/server.h"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/studio/client.h"

namespace fascicle::tests {
namespace {

using studio::PageId;
using studio::ServedFile;
using studio::Server;

class ServerTest : public testing::Test {
 protected:
  ServerTest()
      : server_(
            {.token = "0123456789abcdef0123456789abcdef",
             .files = {{"", "text/html; charset=utf-8", "<p>page"}, {"studio.js", "text/javascript", "1;"}},
             .longest_message = 1000,
             .most_pages = 2,
             .most_waiting = 1 << 20},
            {.opened =
                 [this](PageId page) {
                   ++opened_;
                   page_ = page;
                 },
             .received =
                 [this](PageId, bool is_text, std::string bytes) {
                   const std::lock_guard lock(mutex_);
                   received_.push_back((is_text ? "text:" : "binary:") + bytes);
                 },
             .closed = [this](PageId) { ++closed_; }}) {}

  std::string get(const std::string& target, const std::string& headers = "",
                  const std::string& method = "GET", const std::string& host = "") const {
    return raw_request(server_.port(),
                       method + " " + target + " HTTP/1.1\r\nHost: " +
                           (host.empty() ? "127.0.0.1:" + std::to_string(server_.port()) : host) +
                           "\r\nConnection: close\r\n" + headers + "\r\n");
  }
  // The status of a hand-written upgrade request; 101: accepted.
  int upgrade(const std::string& token, const std::string& origin, const std::string& host = "") const {
    const std::string own = "127.0.0.1:" + std::to_string(server_.port());
    return status_of(raw_request(
        server_.port(),
        "GET /live?token=" + token + " HTTP/1.1\r\nHost: " + (host.empty() ? own : host) + "\r\n" +
            (origin == "none" ? "" : "Origin: " + (origin.empty() ? "http://" + own : origin) + "\r\n") +
            "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"));
  }
  template <class Holds>
  static bool soon(Holds holds) {
    for (int k = 0; k < 1000 && !holds(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return holds();
  }

  const std::string token_ = "0123456789abcdef0123456789abcdef";
  std::atomic<int> opened_ = 0, closed_ = 0;
  std::atomic<PageId> page_ = 0;
  std::mutex mutex_;
  std::vector<std::string> received_;
  Server server_;
};

TEST_F(ServerTest, ServesItsPageWithItsHeaders) {
  const std::string answer = get("/");
  EXPECT_EQ(status_of(answer), 200);
  EXPECT_NE(answer.find("<p>page"), std::string::npos);
  for (const char* header :
       {"Content-Security-Policy: default-src 'none'; script-src 'self'", "X-Frame-Options: DENY",
        "X-Content-Type-Options: nosniff", "Referrer-Policy: no-referrer",
        "Cross-Origin-Opener-Policy: same-origin", "Cross-Origin-Resource-Policy: same-origin",
        "Cache-Control: no-store", "Content-Type: text/html; charset=utf-8"})
    EXPECT_NE(answer.find(header), std::string::npos) << header << "\n" << answer;
  EXPECT_EQ(status_of(get("/studio.js")), 200);
  const std::string head = get("/", "", "HEAD");
  EXPECT_EQ(status_of(head), 200);
  EXPECT_NE(head.find("Content-Length: 7"), std::string::npos);
  EXPECT_EQ(head.find("<p>page"), std::string::npos);
}

TEST_F(ServerTest, ServesNothingElse) {
  for (const char* target :
       {"/etc/passwd", "/../../etc/passwd", "/..%2f..%2fetc/passwd", "/%2e%2e/%2e%2e/etc/passwd",
        "//etc/passwd", "/studio.js/", "/session.json", "/.", "/..", "/studio.js%00"})
    EXPECT_EQ(status_of(get(target)), 404) << target;
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "PATCH"})
    EXPECT_EQ(status_of(get("/", "", method)), 405) << method;
}

TEST_F(ServerTest, AnotherNameOrOriginIsRefused) {
  const std::string port = std::to_string(server_.port());
  EXPECT_EQ(status_of(get("/", "", "GET", "evil.example:" + port)), 421);
  EXPECT_EQ(status_of(get("/", "", "GET", "127.0.0.1")), 421);
  EXPECT_EQ(status_of(get("/", "", "GET", "localhost:" + port)), 200);
  // No Host header, and two of them.
  EXPECT_EQ(status_of(raw_request(server_.port(), "GET / HTTP/1.1\r\nConnection: close\r\n\r\n")), 421);
  EXPECT_EQ(status_of(get("/", "Host: evil.example\r\n")), 421);
  EXPECT_EQ(status_of(get("/", "Origin: http://evil.example\r\n")), 403);
  EXPECT_EQ(status_of(get("/", "Origin: null\r\n")), 403);
  EXPECT_EQ(status_of(get("/", "Origin: http://127.0.0.1:" + port + "\r\n")), 200);
}

TEST_F(ServerTest, AWebSocketNeedsTokenHostAndOrigin) {
  EXPECT_EQ(upgrade(token_, ""), 101);
  EXPECT_EQ(upgrade("0123456789abcdef0123456789abcdee", ""), 403);
  EXPECT_EQ(upgrade("", ""), 403);
  EXPECT_EQ(upgrade(token_, "http://evil.example"), 403);
  EXPECT_EQ(upgrade(token_, "null"), 403);
  EXPECT_EQ(upgrade(token_, "none"), 403);
  EXPECT_EQ(upgrade(token_, "", "evil.example:" + std::to_string(server_.port())), 421);
  EXPECT_EQ(status_of(get("/live?token=" + token_)), 426);
}

TEST_F(ServerTest, WhatIsNoRequestOrTooLongEndsTheConnectionAlone) {
  EXPECT_EQ(status_of(raw_request(server_.port(), "nonsense\r\n\r\n")), 400);
  EXPECT_EQ(status_of(raw_request(server_.port(), std::string(300, '\xff') + "\r\n\r\n")), 400);
  EXPECT_EQ(status_of(get("/", "X: " + std::string(40000, 'x') + "\r\n")), 431);
  EXPECT_EQ(status_of(get("/", "Content-Length: 1000000000\r\n")), 413);
  EXPECT_EQ(status_of(get("/")), 200);
}

TEST_F(ServerTest, MessagesComeAndGo) {
  Client client(server_.port(), token_);
  ASSERT_TRUE(soon([&] { return opened_ == 1; }));
  client.say_text("hello");
  client.say_binary(std::string("\0\1", 2));
  ASSERT_TRUE(soon([&] {
    const std::lock_guard lock(mutex_);
    return received_.size() == 2;
  }));
  EXPECT_EQ(received_[0], "text:hello");
  EXPECT_EQ(received_[1], std::string("binary:\0\1", 9));
  server_.send_text(page_, std::make_shared<const std::string>("one"));
  server_.send_binary(page_, std::make_shared<const std::string>("two"));
  server_.close(page_, "enough");
  EXPECT_EQ(client.next()->bytes, "one");
  const auto second = client.next();
  EXPECT_EQ(second->bytes, "two");
  EXPECT_FALSE(second->is_text);
  EXPECT_FALSE(client.next());
  EXPECT_EQ(client.close_reason(), "enough");
  EXPECT_TRUE(soon([&] { return closed_ == 1; }));
}

// A browser that the program starts must not keep its port.
TEST_F(ServerTest, NoOtherProgramInheritsItsSockets) {
  const Client client(server_.port(), token_);
  ASSERT_TRUE(soon([&] { return opened_ == 1; }));
  int sockets = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int number = std::stoi(entry.path().filename().string());
    sockaddr_in own{};
    socklen_t length = sizeof own;
    if (::getsockname(number, reinterpret_cast<sockaddr*>(&own), &length) != 0 || own.sin_family != AF_INET ||
        ntohs(own.sin_port) != server_.port())
      continue;
    ++sockets;
    EXPECT_EQ(::fcntl(number, F_GETFD), FD_CLOEXEC);
  }
  EXPECT_EQ(sockets, 2) << "the one that listens, and the page's";
}

TEST_F(ServerTest, AMessageThatIsTooLongEndsThePageAlone) {
  Client client(server_.port(), token_), other(server_.port(), token_);
  client.say_text(std::string(1001, 'x'));
  EXPECT_FALSE(client.next());
  EXPECT_TRUE(client.is_closed());
  other.say_text(std::string(1000, 'x'));
  EXPECT_TRUE(soon([&] {
    const std::lock_guard lock(mutex_);
    return received_.size() == 1;
  }));
}

TEST_F(ServerTest, TextThatIsNotUtf8EndsThePage) {
  Client client(server_.port(), token_);
  client.say_text("\xff\xfe");
  EXPECT_FALSE(client.next());
  EXPECT_TRUE(received_.empty());
}

TEST_F(ServerTest, TooManyPagesAreRefused) {
  Client one(server_.port(), token_), two(server_.port(), token_);
  ASSERT_TRUE(soon([&] { return opened_ == 2; }));
  EXPECT_EQ(upgrade(token_, ""), 503);
}

// Connections that say nothing.
class Idle {
 public:
  Idle(std::uint16_t port, int count) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    for (int k = 0; k < count; ++k) {
      sockets_.push_back(::socket(AF_INET, SOCK_STREAM, 0));
      EXPECT_EQ(::connect(sockets_.back(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    }
  }
  ~Idle() {
    for (const int socket : sockets_) ::close(socket);
  }
  Idle(const Idle&) = delete;
  Idle& operator=(const Idle&) = delete;
  // Whether the server ends the first one within this time.
  bool is_first_ended_in(std::chrono::milliseconds time) const {
    pollfd first{sockets_.front(), POLLIN, 0};
    char byte = 0;
    return ::poll(&first, 1, static_cast<int>(time.count())) == 1 &&
           ::recv(sockets_.front(), &byte, 1, 0) <= 0;
  }

 private:
  std::vector<int> sockets_;
};

// Idle connections need no token, and as many as there may be came first.
TEST_F(ServerTest, IdleConnectionsKeepNoPageOut) {
  Client early(server_.port(), token_);
  ASSERT_TRUE(soon([&] { return opened_ == 1; }));
  const Idle idle(server_.port(), 100);
  EXPECT_EQ(status_of(get("/")), 200);
  Client late(server_.port(), token_);
  ASSERT_TRUE(soon([&] { return opened_ == 2; }));
  EXPECT_TRUE(idle.is_first_ended_in(std::chrono::milliseconds(500))) << "the oldest makes room";
  early.say_text("still here");
  EXPECT_TRUE(soon([&] {
    const std::lock_guard lock(mutex_);
    return received_.size() == 1;
  }));
}

TEST_F(ServerTest, AConnectionThatSaysNothingEnds) {
  const Idle idle(server_.port(), 1);
  EXPECT_FALSE(idle.is_first_ended_in(std::chrono::milliseconds(1000))) << "a header may take a moment";
  EXPECT_TRUE(idle.is_first_ended_in(std::chrono::milliseconds(9000)));
}

TEST_F(ServerTest, APageThatDoesNotReadLosesFramesAndKeepsNone) {
  Client client(server_.port(), token_, {.receive_buffer = 4096});
  ASSERT_TRUE(soon([&] { return opened_ == 1; }));
  // 1000 frames of 64 KiB. The sockets buffer some; only one waits.
  std::vector<std::weak_ptr<const std::string>> frames;
  for (int k = 0; k < 1000; ++k) {
    const auto frame = std::make_shared<const std::string>(std::string(1, static_cast<char>(k % 100)) +
                                                           std::string(65535, 'x'));
    frames.push_back(frame);
    server_.offer(page_, frame);
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  const auto alive = [&] {
    std::size_t count = 0;
    for (const auto& frame : frames) count += frame.expired() ? 0u : 1u;
    return count;
  };
  // One being sent and one waiting.
  EXPECT_TRUE(soon([&] { return alive() <= 2; })) << alive();
  EXPECT_FALSE(server_.is_free(page_));
  // When it reads again, it gets the frames in transit and then the newest.
  std::string last;
  while (const auto message = client.next(std::chrono::seconds(2))) last = message->bytes;
  EXPECT_EQ(last[0], static_cast<char>(999 % 100));
  EXPECT_TRUE(server_.is_free(page_));
}

TEST_F(ServerTest, APageThatDoesNotReadIsCutOffWhereItMustHaveAll) {
  Client client(server_.port(), token_, {.receive_buffer = 4096});
  ASSERT_TRUE(soon([&] { return opened_ == 1; }));
  const auto message = std::make_shared<const std::string>(65536, 'x');
  for (int k = 0; k < 200; ++k) server_.send_text(page_, message);
  EXPECT_TRUE(soon([&] { return closed_ == 1; }));
  EXPECT_TRUE(soon([&] { return message.use_count() == 1; })) << message.use_count();
}

// It is sent away while a message that it does not read is on its way, and is not listened to any more.
TEST_F(ServerTest, APageThatDoesNotReadCannotStay) {
  Client client(server_.port(), token_, {.receive_buffer = 4096});
  ASSERT_TRUE(soon([&] { return opened_ == 1; }));
  for (int k = 0; k < 12; ++k) server_.send_text(page_, std::make_shared<const std::string>(65536, 'x'));
  server_.close(page_, "enough");
  client.say_text("unheard");
  EXPECT_TRUE(soon([&] { return closed_ == 1; }));
  const std::lock_guard lock(mutex_);
  EXPECT_TRUE(received_.empty());
}

TEST(Server, APortThatIsTakenIsSaid) {
  const Server one({.token = "a"}, {});
  try {
    const Server two({.port = one.port(), .token = "b"}, {});
    FAIL() << "both listen on one port";
  } catch (const std::system_error& error) {
    EXPECT_NE(std::string(error.what()).find("listen"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace fascicle::tests
