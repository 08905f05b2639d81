#include "host/studio/studio.h"

#include <chrono>
#include <thread>

#include "host/studio/access.h"

namespace fascicle::studio {

namespace {
constexpr auto moment = std::chrono::milliseconds(50);
}

void run_studio(Session& session, const StudioOptions& options, const std::atomic<bool>& interrupted,
                const std::function<void(const std::string& address)>& ready) {
  const std::string token = new_token();
  Server server({.port = options.port, .token = token, .files = options.page},
                {.opened = [&](PageId page) { session.page_opened(page); },
                 .received = [&](PageId page, bool is_text,
                                 const std::string& bytes) { session.page_said(page, is_text, bytes); },
                 .closed = [&](PageId page) { session.page_closed(page); }});
  // Detaches the session before the server is destroyed, also on exceptions.
  const struct Serving {
    Session& session;
    ~Serving() { session.leave(); }
  } serving{session};
  session.serve(server);
  ready("http://127.0.0.1:" + std::to_string(server.port()) + "/#" + token);
  while (!interrupted) std::this_thread::sleep_for(moment);
}

}  // namespace fascicle::studio
