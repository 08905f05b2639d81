// The only place that compiles toml++'s code; TOML_HEADER_ONLY is 0 for the whole room (CMakeLists.txt).
// Assertions are off, because damaged text triggers two of them (`!is_value_terminator` in parse_value, and
// one in parse_key at `[=`), which would abort the program; without them, the parser goes on and reports that
// there is no value or key.
#ifndef NDEBUG
#define NDEBUG
#endif
#define TOML_IMPLEMENTATION
#include "host/scene/toml.h"
