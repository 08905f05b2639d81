// The studio's page, bundled from web/ into web/bundle.
#pragma once

#include <vector>

#include "host/studio/server.h"

namespace fascicle::studio {

std::vector<ServedFile> page_bundle();

}  // namespace fascicle::studio
