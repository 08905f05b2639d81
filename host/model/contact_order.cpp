#include "host/model/contact_order.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace fascicle::model {

namespace {

// Spreads the bits of a number below 2^10 to every third place.
std::uint32_t spread_bits(std::uint32_t number) {
  std::uint32_t bits = 0;
  for (unsigned b = 0; b < 10; ++b) bits |= (number >> b & 1U) << (3 * b);
  return bits;
}

}  // namespace

std::vector<std::uint32_t> contact_points_along_curve(const Model& model) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> keyed;
  for (std::uint32_t p = 0; p < model.contact.size(); ++p) {
    std::uint32_t code = 0;
    for (unsigned a = 0; a < 3; ++a) {
      const float along = (model.rest[3 * std::size_t{model.contact[p].vertex} + a] + 1.0f) * 512.0f;
      code |= spread_bits(static_cast<std::uint32_t>(std::clamp(along, 0.0f, 1023.0f))) << a;
    }
    keyed.emplace_back(code, p);
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<std::uint32_t> order;
  order.reserve(keyed.size());
  for (const auto& [code, p] : keyed) order.push_back(p);
  return order;
}

}  // namespace fascicle::model
