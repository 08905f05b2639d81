// A page of the studio, as a program: what a browser would send and receive.
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
  int receive_buffer = 0;  // of the socket, bytes; 0: the system's
};

class Client {
 public:
  // Opens the WebSocket. Throws std::runtime_error where it is refused.
  Client(std::uint16_t port, const std::string& token, const ClientOptions& options = {});
  ~Client();

  void say(const Json& message);
  void say_text(const std::string& text);
  void say_binary(const std::string& bytes);
  // Nothing where none comes in that time, or the server closed.
  std::optional<Message> next(std::chrono::milliseconds patience = std::chrono::seconds(20));
  bool is_closed() const;
  std::string close_reason() const;

  // The next JSON message of a type; others, and binary ones, are passed over. Fails the test where none
  // comes.
  Json wait_for(const std::string& type, std::chrono::milliseconds patience = std::chrono::seconds(60));
  // The next binary frame that is as wanted; messages are passed over. `seen`: each JSON message on the way.
  std::string wait_for_frame(const std::function<bool(const std::string&)>& is_wanted,
                             std::chrono::milliseconds patience = std::chrono::seconds(60));

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A plain HTTP request, as it stands; returns all that comes back until the server closes, or for a second.
std::string raw_request(std::uint16_t port, const std::string& request);
// The status of such an answer; 0 where there is none.
int status_of(const std::string& answer);

}  // namespace fascicle::tests
