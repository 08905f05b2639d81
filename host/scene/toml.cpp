// The one place where toml++'s code is compiled; TOML_HEADER_ONLY is 0 for the whole room (CMakeLists.txt).
#define TOML_IMPLEMENTATION
#include "host/scene/toml.h"
