// The whole studio: a session and its server, and their lifetimes.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/studio/server.h"
#include "host/studio/session.h"

namespace fascicle::studio {

struct StudioOptions {
  std::uint16_t port = 0;  // 0: any free port
  std::vector<ServedFile> page;
};

// Serves the session until `interrupted` is true. Calls `ready` once the page can be opened, with its
// address: "http://127.0.0.1:PORT/#TOKEN". Throws std::system_error if the port is taken.
void run_studio(Session& session, const StudioOptions& options, const std::atomic<bool>& interrupted,
                const std::function<void(const std::string& address)>& ready);

}  // namespace fascicle::studio
