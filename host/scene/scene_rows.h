// One row per key of the scene file, with the member of scene.h that it sets. A tuple of rows yields the
// table of keys that files, --set and the schema are checked against (scene_table.h), the reader, and the
// manifest's JSON. The key's type and default are those of the member.
//
// Next to each tuple, static_assert(base::has_row_for_each_member<Owner, decltype(rows)>) fails to compile if
// a member has no row.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/base/fields.h"
#include "host/base/names.h"
#include "host/scene/scene.h"
#include "host/scene/scene_json.h"
#include "host/scene/scene_table.h"
#include "host/scene/scene_values.h"

namespace fascicle::scene {

// Whether the manifest shows the member.
enum class Shown { always, where_set, never };

struct RowTraits {
  bool depends = false;  // the default is not the member's own, or `doc` states it
  bool by_hand = false;  // read by the struct's reader, because it depends on more than the key's own text
  Shown shown = Shown::always;  // where_set: only if it differs from the default
};

// A key that sets a member. The values of an enumeration are its names; `allowed` may give words for false
// and true, in that order.
template <class Owner, class T>
struct KeyRow {
  T Owner::*member;
  Key key;
  RowTraits traits;
};
// A member that no single key sets; `name` is its name in the manifest.
template <class Owner, class T>
struct MemberRow {
  const char* name;
  T Owner::*member;
  Shown shown;
};
// A key that sets no member directly.
struct LooseKey {
  Key key;
};

namespace rows {

inline constexpr double farthest = 1e6;  // metres; its square and cube are far from overflowing a float

constexpr Range between(double minimum, double maximum) {
  return {minimum, maximum, false};
}
constexpr Range positive(double maximum) {
  return {0.0, maximum, true};
}
inline constexpr Range coordinate = between(-farthest, farthest);

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;

template <class T>
consteval KeyType type_of() {
  if constexpr (is_optional<T>)
    return type_of<typename T::value_type>();
  else if constexpr (std::is_same_v<T, bool>)
    return KeyType::boolean;
  else if constexpr (std::is_floating_point_v<T>)
    return KeyType::number;
  else if constexpr (std::is_integral_v<T>)
    return KeyType::integer;
  else if constexpr (std::is_same_v<T, std::string> || std::is_enum_v<T>)
    return KeyType::text;
  else if constexpr (std::is_same_v<T, Vector3d>)
    return KeyType::vector;
  else if constexpr (std::is_same_v<T, std::array<std::uint32_t, 3>>)
    return KeyType::integer_vector;
  else if constexpr (std::is_same_v<T, std::vector<double>>)
    return KeyType::numbers;
  else if constexpr (std::is_same_v<T, std::vector<std::string>>)
    return KeyType::texts;
  else if constexpr (std::is_same_v<T, NameLists>)
    return KeyType::name_lists;
  else if constexpr (std::is_same_v<T, std::vector<Vector3d>>)
    return KeyType::points;
  else if constexpr (std::is_same_v<T, KeyedCurve>)
    return KeyType::curve;
  else if constexpr (std::is_same_v<T, PerBone>)
    return KeyType::named_numbers;
  else
    return std::is_same_v<T, Where> ? KeyType::tables : throw "no key has such a type";
}

template <class T>
inline constexpr bool is_worded = std::is_enum_v<T> || std::is_same_v<T, bool>;

template <class T>
Json json_of_member(const Key& key, const T& value) {
  if constexpr (is_worded<T>)
    if (!key.allowed.empty()) return key.allowed[static_cast<std::size_t>(value)];
  if constexpr (!std::is_enum_v<T>)
    return json_of_value(value);
  else
    return nullptr;
}

// Whether a missing key has a default that can be written as a value.
template <class T>
inline constexpr bool has_default =
    !is_optional<T> && (std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, std::string> ||
                        std::is_same_v<T, Vector3d> || std::is_same_v<T, std::array<std::uint32_t, 3>>);

template <class Owner, class T>
KeyRow<Owner, T> key(T Owner::*member, Key described, RowTraits traits = {}) {
  described.type = type_of<T>();
  if (std::is_same_v<T, bool> && !described.allowed.empty()) described.type = KeyType::text;
  if constexpr (std::is_enum_v<T>) described.allowed = base::all_names<T>();
  if constexpr (has_default<T>)
    if (!described.required && !traits.depends)
      described.fallback = json_of_member(described, Owner{}.*member);
  return {member, std::move(described), traits};
}

template <class Owner, class T>
MemberRow<Owner, T> member(const char* name, T Owner::*place, Shown shown = Shown::always) {
  return {name, place, shown};
}

inline LooseKey loose_key(Key described) {
  return {std::move(described)};
}

template <class Owner>
KeyRow<Owner, Where> where_key(Where Owner::*place, bool required, const char* doc) {
  return key(place, {.name = "where", .doc = doc, .required = required, .table = &shape_table()},
             {.by_hand = true});
}

template <class Row>
inline constexpr bool has_member = requires(const Row& row) {
  row.member;
};
template <class Row>
inline constexpr bool has_key = requires(const Row& row) {
  row.key;
};

}  // namespace rows

// Adds the rows' keys to the table, in order.
template <class... Row>
Table with_keys(Table table, const std::tuple<Row...>& rows_of_table) {
  base::for_each_row(rows_of_table, [&](const auto& row) {
    if constexpr (rows::has_key<std::decay_t<decltype(row)>>) table.keys.push_back(row.key);
  });
  return table;
}

// Reads the keys that are present into their members, except those marked by_hand.
template <class Owner, class... Row>
void read_rows(const toml::table& table, const std::tuple<Row...>& rows_of_table, Owner& owner) {
  base::for_each_row(rows_of_table, [&](const auto& row) {
    using R = std::decay_t<decltype(row)>;
    if constexpr (rows::has_member<R> && rows::has_key<R>) {
      using T = std::decay_t<decltype(owner.*row.member)>;
      if (row.traits.by_hand) return;
      if constexpr (rows::is_worded<T>)
        if (!row.key.allowed.empty())
          return read_word(table, row.key,
                           [&](std::size_t word) { owner.*row.member = static_cast<T>(word); });
      if constexpr (!std::is_enum_v<T> && !std::is_same_v<T, Where>)
        read(table, row.key.name.c_str(), owner.*row.member);
    }
  });
}

// The members under the names of their keys.
template <class Owner, class... Row>
Json json_of_rows(const std::tuple<Row...>& rows_of_table, const Owner& owner) {
  Json object = Json::object();
  base::for_each_row(rows_of_table, [&](const auto& row) {
    using R = std::decay_t<decltype(row)>;
    if constexpr (rows::has_member<R> && rows::has_key<R>) {
      Json value = rows::json_of_member(row.key, owner.*row.member);
      const bool is_set =
          row.traits.shown == Shown::always || value != rows::json_of_member(row.key, Owner{}.*row.member);
      if (row.traits.shown != Shown::never && is_set) object[row.key.name] = std::move(value);
    } else if constexpr (rows::has_member<R>) {
      if constexpr (!std::is_enum_v<std::decay_t<decltype(owner.*row.member)>>)
        if (row.shown != Shown::never) object[row.name] = json_of_value(owner.*row.member);
    }
  });
  return object;
}

}  // namespace fascicle::scene
