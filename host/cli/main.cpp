#include "host/base/process_start.h"
#include "host/cli/command.h"
#include "host/cli/driver_files.h"
#include "host/cli/interrupt.h"
#include "host/cli/memory.h"

int main(int argc, char** argv) {
  // Must come first: an earlier signal kills the process, without an exit status that says it can be resumed.
  fascicle::cli::catch_interrupts();
  fascicle::base::open_standard_streams();
  fascicle::base::outlive_the_limit_on_files();
  fascicle::cli::give_freed_arrays_back();
  fascicle::cli::keep_drivers_from_writing();
  return fascicle::cli::run(argc, argv);
}
