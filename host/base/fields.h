// Tables of an aggregate's members, one row per member. Code that handles every member (check, hash, read,
// write, print) uses the table, and a member without a row does not compile.
//
// A table is a std::tuple of rows; a row is any struct with `member`, a pointer to member. A table may also
// contain rows without `member`. Next to the table, write
//
//   static_assert(base::has_row_for_each_member<Owner, decltype(table)>, "...");
#pragma once

#include <cstddef>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

namespace fascicle::base {

namespace detail {

// Converts to any type; never defined.
struct AnyValue {
  template <class T>
  operator T() const;
};

template <class... T>
struct Types {};
template <class... A, class... B>
Types<A..., B...> operator+(Types<A...>, Types<B...>);

template <class Owner, class T>
Types<T> type_of(T Owner::*member);
template <class Row>
auto types_of_row(const Row& row) {
  if constexpr (requires { row.member; })
    return decltype(type_of(row.member)){};
  else
    return Types<>{};
}

// Whether values of these types initialise all of Owner's members, in order.
template <class Owner, class... T>
consteval bool is_filled_by(Types<T...>) {
  return requires {
    Owner{std::declval<T>()...};
  }
  &&!requires {
    Owner{std::declval<T>()..., AnyValue{}};
  };
}

template <class Owner, class Table>
struct Coverage;
template <class Owner, class... Rows>
struct Coverage<Owner, std::tuple<Rows...>> {
  static constexpr bool is_complete =
      is_filled_by<Owner>(decltype((Types<>{} + ... + types_of_row(std::declval<Rows>()))){});
};

}  // namespace detail

// Whether the rows name every member of the aggregate Owner, in the order of the struct.
template <class Owner, class Table>
inline constexpr bool has_row_for_each_member =
    std::is_aggregate_v<Owner>&& detail::Coverage<Owner, std::remove_const_t<Table>>::is_complete;

template <class... Rows>
consteval bool has_distinct_names(const std::tuple<Rows...>& table) {
  return std::apply(
      [](const auto&... rows) {
        const std::string_view names[] = {rows.name...};
        for (std::size_t a = 0; a < sizeof...(rows); ++a)
          for (std::size_t b = 0; b < a; ++b)
            if (names[a] == names[b]) return false;
        return true;
      },
      table);
}

// Calls use(row) for each row, in order.
template <class... Rows, class Use>
constexpr void for_each_row(const std::tuple<Rows...>& table, Use&& use) {
  std::apply([&use](const auto&... rows) { (use(rows), ...); }, table);
}

// The index of the row whose member is `member`; the table's size if there is none.
template <class... Rows, class Owner, class Value>
consteval std::size_t row_of(const std::tuple<Rows...>& table, Value Owner::*member) {
  return std::apply(
      [member](const auto&... rows) {
        const auto is_it = [member](const auto& row) {
          if constexpr (std::is_same_v<std::decay_t<decltype(row.member)>, Value Owner::*>)
            return row.member == member;
          else
            return false;
        };
        const bool found[] = {is_it(rows)...};
        std::size_t k = 0;
        while (k < sizeof...(rows) && !found[k]) ++k;
        return k;
      },
      table);
}

}  // namespace fascicle::base
