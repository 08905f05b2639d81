#include "host/cli/command.h"

int main(int argc, char** argv) {
  return fascicle::cli::run(argc, argv);
}
