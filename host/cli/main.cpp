#include "host/base/process_start.h"
#include "host/cli/command.h"
#include "host/cli/interrupt.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

// glibc takes ever larger arrays from its heap once some were freed, and keeps what lies between: a tenth of
// the peak of a body of 100,000 vertices.
static void give_freed_arrays_back() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 128 * 1024);
#endif
}

int main(int argc, char** argv) {
  // First of all: a signal that comes before ends the process, and no exit status says that it goes on.
  fascicle::cli::catch_interrupts();
  fascicle::base::open_standard_streams();
  fascicle::base::outlive_the_limit_on_files();
  give_freed_arrays_back();
  return fascicle::cli::run(argc, argv);
}
