#include "host/cli/command.h"

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
  give_freed_arrays_back();
  return fascicle::cli::run(argc, argv);
}
