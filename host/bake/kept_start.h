// The state of frame 0 as bytes, so that baking a scene again need not step again what comes before it.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "host/bake/identity.h"
#include "host/drive/lead_in.h"

namespace fascicle::bake {

// A name for the start of a bake, 32 hex digits: it changes with all that decides the bits of the start, and
// not with the formats that are written.
std::string start_key(const Identity& identity);

std::string start_bytes(const drive::LeadIn& start, const Identity& identity);

// Nothing where the bytes are not a whole start of a bake with this identity.
std::optional<drive::LeadIn> read_start(std::string_view bytes, const Identity& identity);

}  // namespace fascicle::bake
