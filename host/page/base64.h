// RFC 4648.
#pragma once

#include <string>
#include <string_view>

namespace fascicle::page {

std::string base64(std::string_view bytes);

}  // namespace fascicle::page
