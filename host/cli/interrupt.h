// SIGINT and SIGTERM as a wish to stop after the current frame.
#pragma once

#include <atomic>

namespace fascicle::cli {

// Installs the handlers and unblocks the signals. The first signal sets a flag; a second one ends the process
// at once, as it would have without handlers.
void catch_interrupts();
// That flag.
const std::atomic<bool>& interrupts();

// For commands that do not ask for the flag: takes the handlers away, and ends the process if a signal has
// come meanwhile.
void let_interrupts_end_the_process();

}  // namespace fascicle::cli
