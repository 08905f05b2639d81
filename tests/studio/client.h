// A test client that sends and receives what a browser would.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace fascicle::tests {

using Json = nlohmann::ordered_json;

struct Message {
  bool is_text = false;
  std::string bytes;
};

struct ClientOptions {
  int receive_buffer = 0;  // socket buffer in bytes; 0: the system's default
};

class Client {
 public:
  // Opens the WebSocket. Throws std::runtime_error if refused.
  Client(std::uint16_t port, const std::string& token, const ClientOptions& options = {});
  ~Client();

  void say(const Json& message);
  void say_text(const std::string& text);
  void say_binary(const std::string& bytes);
  // Empty if no message arrives in time, or if the server closed.
  std::optional<Message> next(std::chrono::milliseconds patience = std::chrono::seconds(20));
  bool is_closed() const;
  std::string close_reason() const;

  // The next JSON message of a type; skips other and binary messages. Fails the test if none arrives.
  Json wait_for(const std::string& type, std::chrono::milliseconds patience = std::chrono::seconds(60));
  // The next binary frame that satisfies `is_wanted`; skips messages.
  std::string wait_for_frame(const std::function<bool(const std::string&)>& is_wanted,
                             std::chrono::milliseconds patience = std::chrono::seconds(60));

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Sends a raw HTTP request; returns everything received until the server closes or a second passes.
std::string raw_request(std::uint16_t port, const std::string& request);
// The HTTP status of an answer; 0 if there is none.
int status_of(const std::string& answer);

}  // namespace fascicle::tests
