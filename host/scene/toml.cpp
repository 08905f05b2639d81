// The one place where toml++'s code is compiled; TOML_HEADER_ONLY is 0 for the whole room (CMakeLists.txt).
// Without its assertions: damaged text reaches two of them (`!is_value_terminator` in parse_value, and one in
// parse_key at `[=`), where it would end the program; the parser goes on to say that there is no value or
// key.
#ifndef NDEBUG
#define NDEBUG
#endif
#define TOML_IMPLEMENTATION
#include "host/scene/toml.h"
