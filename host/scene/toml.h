// toml++ as this room uses it: compiled once, in toml.cpp. Everything here includes this header and not its
// own.
#pragma once

#include <toml++/toml.h>
