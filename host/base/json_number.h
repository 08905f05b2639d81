// Whole numbers of untrusted JSON.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <utility>

namespace fascicle::base {

// The value as an Integer; nothing if it is no whole number of that range. nlohmann's get() converts any
// number: what it makes of 1e300 is undefined, and of -1 a large unsigned number. Json is nlohmann::json or
// ordered_json.
template <std::integral Integer, class Json>
std::optional<Integer> whole_number(const Json& value) {
  if (value.is_number_unsigned()) {
    const auto number = value.template get<std::uint64_t>();
    return std::in_range<Integer>(number) ? std::optional(static_cast<Integer>(number)) : std::nullopt;
  }
  if (value.is_number_integer()) {
    const auto number = value.template get<std::int64_t>();
    return std::in_range<Integer>(number) ? std::optional(static_cast<Integer>(number)) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace fascicle::base
