// Files of JSON of our own end with a checksum: where a bit has turned, a number or a name is often one
// still.
#pragma once

#include <string>

#include "host/scene/scene_json.h"

namespace fascicle::bake {

// "version" of what is sealed. Before that there were no checksums.
inline constexpr int sealed_json_version = 2;

// The object as text, with "checksum" as its last key: the XXH3-64 of the object without that key, as one
// line (scene::dump), in hexadecimal digits. Indentation does not count.
std::string sealed_text(scene::Json object, int indent = -1);

// Whether the checksum is not that of all else, or is not there while the version says that it should be.
bool is_damaged(const scene::Json& object);

}  // namespace fascicle::bake
