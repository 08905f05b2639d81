// The studio's server: the page over HTTP and one WebSocket a page, on loopback. It knows nothing of scenes:
// messages come and go as bytes.
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
  std::string_view name;  // "" is the page itself
  std::string_view type;  // its content type
  std::string_view text;
};

// A page that is open, by a number that is never given twice.
using PageId = std::uint64_t;

// Bytes that several pages may share.
using SharedBytes = std::shared_ptr<const std::string>;

struct ServerOptions {
  std::uint16_t port = 0;  // 0: one that is free
  std::string token = {};
  std::vector<ServedFile> files = {};
  std::size_t longest_message = 256 << 10;            // from a page, bytes
  std::size_t most_pages = 8;                         // open at a time
  std::size_t most_connections = 64;                  // of all kinds
  std::size_t most_waiting = std::size_t{256} << 20;  // bytes to one page before it is cut off
};

// Called on the server's own thread, one at a time. Must not throw.
struct ServerEvents {
  std::function<void(PageId)> opened;
  std::function<void(PageId, bool is_text, std::string bytes)> received;
  std::function<void(PageId)> closed;
};

// Any thread may call any function.
class Server {
 public:
  // Listens when it returns. Throws std::system_error where the port is taken.
  Server(ServerOptions options, ServerEvents events);
  // Closes all pages.
  ~Server();

  std::uint16_t port() const;

  // All of these arrive, in order, or the page is cut off. Pages that are gone are no error.
  void send_text(PageId page, SharedBytes text);
  void send_binary(PageId page, SharedBytes bytes);
  // Arrives where the page keeps up: what is offered takes the place of what was offered before and waits.
  void offer(PageId page, SharedBytes bytes);
  // Whether nothing that was offered waits.
  bool is_free(PageId page) const;
  // Ends a page, which is told why once what it was sent has gone.
  void close(PageId page, std::string reason);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fascicle::studio
