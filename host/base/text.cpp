#include "host/base/text.h"

#include <cinttypes>
#include <cmath>
#include <cstdio>

namespace fascicle::base {

std::string short_text(double value) {
  return number_text(std::round(value * 100.0) / 100.0);
}

std::string percent_text(double share) {
  return short_text(100.0 * share) + " %";
}

std::string hash_text(std::uint64_t hash) {
  std::array<char, 17> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%016" PRIx64, hash);
  return buffer.data();
}

}  // namespace fascicle::base
