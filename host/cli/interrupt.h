// Turns SIGINT and SIGTERM into a request to stop after the current frame.
#pragma once

#include <atomic>

namespace fascicle::cli {

// Installs the handlers and unblocks the signals. The first signal sets a flag; a second one kills the
// process at once, as without handlers.
void catch_interrupts();
// The flag. Calling this undoes end_at_once_until_asked(): the caller must then check the flag and stop in
// order.
const std::atomic<bool>& interrupts();

// From now on SIGHUP sets the flag too, unless it was ignored (nohup). A terminal that closes may send
// several, so a second one does nothing more.
void catch_hangups();

// Until the next call of interrupts(), a signal ends the process at once with ExitCode::interrupted, because
// nothing has begun yet. Reading a character can take a minute.
void end_at_once_until_asked();

// For commands that do not check the flag: removes the handlers, and ends the process if a signal has already
// arrived.
void let_interrupts_end_the_process();

}  // namespace fascicle::cli
