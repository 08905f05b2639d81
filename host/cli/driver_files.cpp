#include "host/cli/driver_files.h"

#include <cstdlib>

namespace fascicle::cli {

void keep_drivers_from_writing() {
  constexpr int stays = 0;
  ::setenv("MESA_SHADER_CACHE_DISABLE", "true", stays);
  ::setenv("__GL_SHADER_DISK_CACHE", "0", stays);
}

}  // namespace fascicle::cli
