// Serialises structures to bytes and back: numbers in memory layout, arrays and texts with a length prefix,
// optional values with a flag. Input may be damaged, so lengths are checked against the bytes left before
// memory is allocated.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace fascicle::build {

// Whether T is stored as its bytes in memory: a number, or an array of numbers.
template <class T>
struct IsFlat : std::is_arithmetic<T> {};
template <class T, std::size_t count>
struct IsFlat<std::array<T, count>> : IsFlat<T> {};

// A structure with listed fields: for_each_field(value, visit) calls visit with each, in a fixed order.
template <class T, class Visit>
concept HasFields = requires(T& value, Visit& visit) {
  for_each_field(value, visit);
};

class ByteWriter {
 public:
  explicit ByteWriter(std::string& bytes) : bytes_(bytes) {}

  template <class T>
  requires IsFlat<T>::value void operator()(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class T>
  requires IsFlat<T>::value void operator()(const std::vector<T>& values) {
    (*this)(std::uint64_t{values.size()});
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  void operator()(const std::string& text) {
    (*this)(std::uint64_t{text.size()});
    bytes_ += text;
  }
  template <class T>
  requires HasFields<const T, ByteWriter>
  void operator()(const T& value) { for_each_field(value, *this); }
  template <class T>
  requires HasFields<const T, ByteWriter>
  void operator()(const std::vector<T>& values) {
    (*this)(std::uint64_t{values.size()});
    for (const T& value : values) (*this)(value);
  }
  template <class T>
  void operator()(const std::optional<T>& value) {
    (*this)(value.has_value());
    if (value) (*this)(*value);
  }

 private:
  std::string& bytes_;
};

class ByteReader {
 public:
  struct Damaged : std::runtime_error {
    using std::runtime_error::runtime_error;
  };

  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  // All throw Damaged if the bytes end too early.
  template <class T>
  requires IsFlat<T>::value void operator()(T& value) { take(&value, sizeof value); }
  void operator()(bool& value) {
    std::uint8_t byte = 0;
    (*this)(byte);
    value = byte != 0;
  }
  template <class T>
  requires IsFlat<T>::value void operator()(std::vector<T>& values) {
    values.resize(length(sizeof(T)));
    take(values.data(), values.size() * sizeof(T));
  }
  void operator()(std::string& text) {
    text.resize(length(1));
    take(text.data(), text.size());
  }
  template <class T>
  requires HasFields<T, ByteReader>
  void operator()(T& value) { for_each_field(value, *this); }
  // Element by element: a structure takes more memory than the fewest bytes it can be read from.
  template <class T>
  requires HasFields<T, ByteReader>
  void operator()(std::vector<T>& values) {
    values.clear();
    for (std::size_t left = length(1); left > 0; --left) (*this)(values.emplace_back());
  }
  template <class T>
  void operator()(std::optional<T>& value) {
    bool is_there = false;
    (*this)(is_there);
    value.reset();
    if (is_there) (*this)(value.emplace());
  }
  bool at_end() const { return bytes_.empty(); }
  std::string_view rest() const { return bytes_; }

 private:
  std::size_t length(std::size_t size) {
    std::uint64_t count = 0;
    (*this)(count);
    if (count > bytes_.size() / size) throw Damaged("an array is longer than the file");
    return static_cast<std::size_t>(count);
  }
  void take(void* to, std::size_t size) {
    if (size > bytes_.size()) throw Damaged("the file ends too early");
    if (size > 0) std::memcpy(to, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }

  std::string_view bytes_;
};

}  // namespace fascicle::build
