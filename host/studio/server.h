// The studio's server: the page over HTTP and one WebSocket per page, on loopback. It knows nothing about
// scenes; messages are bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fascicle::studio {

// A file of the page.
struct ServedFile {
  std::string_view name;  // "": the page itself
  std::string_view type;  // content type
  std::string_view text;
};

// An open page; numbers are never reused.
using PageId = std::uint64_t;

// Bytes shared between pages.
using SharedBytes = std::shared_ptr<const std::string>;

struct ServerOptions {
  std::uint16_t port = 0;  // 0: any free port
  std::string token = {};
  std::vector<ServedFile> files = {};
  std::size_t longest_message = 256 << 10;  // from a page, bytes
  std::size_t most_pages = 8;               // open at a time
  // Of all kinds. One more ends the oldest that is not an open page.
  std::size_t most_connections = 64;
  std::size_t most_waiting = std::size_t{256} << 20;  // bytes queued for a page before it is disconnected
};

// Called on the server's own thread, one at a time. Must not throw.
struct ServerEvents {
  std::function<void(PageId)> opened;
  std::function<void(PageId, bool is_text, std::string bytes)> received;
  std::function<void(PageId)> closed;
};

// Thread-safe.
class Server {
 public:
  // Is listening on return. Throws std::system_error if the port is taken.
  Server(ServerOptions options, ServerEvents events);
  // Closes all pages.
  ~Server();

  std::uint16_t port() const;

  // All of these arrive, in order, or the page is disconnected. Pages that are gone are ignored.
  void send_text(PageId page, SharedBytes text);
  void send_binary(PageId page, SharedBytes bytes);
  // Arrives if the page keeps up: a new offer replaces one that is still waiting.
  void offer(PageId page, SharedBytes bytes);
  // Whether no offer is waiting.
  bool is_free(PageId page) const;
  // Disconnects a page and tells it the reason, after what is already queued.
  void close(PageId page, std::string reason);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fascicle::studio
