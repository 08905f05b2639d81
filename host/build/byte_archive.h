// Structures as bytes and back: numbers as they lie in memory, arrays and texts behind their length. What is
// read may be damaged: lengths are held against what is left before memory is taken.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace fascicle::build {

// What T's bytes are: an array of numbers.
template <class T>
struct IsFlat : std::is_arithmetic<T> {};
template <class T, std::size_t count>
struct IsFlat<std::array<T, count>> : IsFlat<T> {};

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

 private:
  std::string& bytes_;
};

class ByteReader {
 public:
  struct Damaged : std::runtime_error {
    using std::runtime_error::runtime_error;
  };

  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  // All throw Damaged where the bytes end too early.
  template <class T>
  requires IsFlat<T>::value void operator()(T& value) { take(&value, sizeof value); }
  template <class T>
  requires IsFlat<T>::value void operator()(std::vector<T>& values) {
    values.resize(length(sizeof(T)));
    take(values.data(), values.size() * sizeof(T));
  }
  void operator()(std::string& text) {
    text.resize(length(1));
    take(text.data(), text.size());
  }
  bool at_end() const { return bytes_.empty(); }

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
