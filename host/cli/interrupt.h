// SIGINT and SIGTERM as a wish to stop after the current frame.
#pragma once

#include <atomic>

namespace fascicle::cli {

// Installs the handlers and unblocks the signals. The first signal sets a flag; a second one ends the process
// at once, as it would have without handlers.
void catch_interrupts();
// That flag. From the first call on, whoever asked for it brings what has begun to its end.
const std::atomic<bool>& interrupts();

// Until interrupts() is asked for again nothing has begun: a signal ends the process at once, with
// ExitCode::interrupted. Reading a character can take a minute.
void end_at_once_until_asked();

// For commands that do not ask for the flag: takes the handlers away, and ends the process if a signal has
// come meanwhile.
void let_interrupts_end_the_process();

}  // namespace fascicle::cli
