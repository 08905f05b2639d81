// Enumerations whose values have names: the words used in scene files, options, messages and manifests.
//
// The single table of names is next to the enumeration, in its namespace, in the order of the values:
//
//   enum class Fruit { apple, pear };
//   constexpr auto names_of(Fruit) { return std::array{"apple", "pear"}; }
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace fascicle::base {

template <class E>
concept Named = std::is_enum_v<E> && requires(E value) {
  names_of(value);
};

template <Named E>
constexpr const char* name_of(E value) {
  return names_of(value).at(static_cast<std::size_t>(value));
}

// Nothing if no value has the name.
template <Named E>
constexpr std::optional<E> named(std::string_view name) {
  constexpr auto names = names_of(E{});
  for (std::size_t k = 0; k < names.size(); ++k)
    if (names[k] == name) return static_cast<E>(k);
  return std::nullopt;
}

template <Named E>
std::vector<std::string> all_names() {
  constexpr auto names = names_of(E{});
  return {names.begin(), names.end()};
}

}  // namespace fascicle::base
