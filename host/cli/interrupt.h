// SIGINT and SIGTERM as a wish to stop after the current frame.
#pragma once

#include <atomic>

namespace fascicle::cli {

// Installs the handlers and returns the flag that the first signal sets; a second signal ends the process at
// once, as it would have without handlers.
const std::atomic<bool>& catch_interrupts();

}  // namespace fascicle::cli
