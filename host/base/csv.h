// Lines of comma-separated values (RFC 4180).
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fascicle::base {

// The fields of a line. A quoted field may contain commas, and "" for a quotation mark.
std::vector<std::string> csv_fields(std::string_view line);

}  // namespace fascicle::base
