// Our own JSON files end with a checksum: after a bit flip, a number or a name is often still valid.
#pragma once

#include <string>

#include "host/scene/scene_json.h"

namespace fascicle::bake {

// "version" of sealed files. Earlier versions had no checksum.
inline constexpr int sealed_json_version = 2;

// The object as text, with "checksum" as its last key: the XXH3-64 of the object without that key, as one
// line (scene::dump), in hexadecimal digits. Indentation does not count.
std::string sealed_text(scene::Json object, int indent = -1);

// Whether the checksum does not match the rest, or is missing although the version requires it.
bool is_damaged(const scene::Json& object);

}  // namespace fascicle::bake
