// The studio's page, as web/ was bundled into web/bundle.
#pragma once

#include <vector>

#include "host/studio/server.h"

namespace fascicle::studio {

std::vector<ServedFile> page_bundle();

}  // namespace fascicle::studio
