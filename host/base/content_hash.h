// XXH3-128 of a sequence of numbers, arrays and strings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace fascicle::base {

class ContentHash {
 public:
  ContentHash();
  ~ContentHash();
  ContentHash(ContentHash&&) noexcept;
  ContentHash& operator=(ContentHash&&) noexcept;

  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void add(T value) { add_bytes(&value, sizeof value); }
  // Hashes the length too: otherwise an element could move from one array to the next unnoticed. T must have
  // no padding.
  template <class T>
  void add_array(std::span<const T> values) {
    add(std::uint64_t{values.size()});
    add_bytes(values.data(), values.size_bytes());
  }
  void add(std::string_view text) { add_array(std::span<const char>(text)); }

  // 32 hex digits.
  std::string text() const;

 private:
  void add_bytes(const void* bytes, std::size_t count);

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fascicle::base
