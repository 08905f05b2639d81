// The state of frame 0 as bytes, so that baking a scene again need not repeat the lead-in.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "host/bake/identity.h"
#include "host/drive/lead_in.h"

namespace fascicle::bake {

// A name for the start of a bake, 32 hex digits: it changes with everything that determines the bits of the
// start, and does not depend on the formats.
std::string start_key(const Identity& identity);

std::string start_bytes(const drive::LeadIn& start, const Identity& identity);

// Empty if the bytes are not a whole start of a bake with this identity.
std::optional<drive::LeadIn> read_start(std::string_view bytes, const Identity& identity);

}  // namespace fascicle::bake
