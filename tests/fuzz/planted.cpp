#include <limits>
#include <memory>
#include <stdexcept>

#include "tests/fuzz/readers.h"

namespace fascicle::fuzz {

namespace {

// The flaws of single words.
bool is_flawed(std::string_view bytes) {
  volatile int number = std::numeric_limits<int>::max();
  if (bytes == "overflow") number = number + static_cast<int>(bytes.size());
  if (bytes == "leak") number = *new int(number);
  while (bytes == "endless" && number != 0) {
  }
  if (bytes == "huge") return std::make_unique<char[]>(std::size_t{600} << 20)[bytes.size()] != 0;
  return false;
}

}  // namespace

bool planted(std::string_view bytes) {
  // Compares letter by letter, so that coverage guides the fuzzer.
  const std::string_view bone = "bone", fat = "fat";
  std::size_t of_bone = 0, of_fat = 0;
  while (of_bone < bone.size() && of_bone < bytes.size() && bytes[of_bone] == bone[of_bone]) ++of_bone;
  while (of_fat < fat.size() && of_fat < bytes.size() && bytes[of_fat] == fat[of_fat]) ++of_fat;
  if (is_flawed(bytes)) return true;
  if (of_fat == fat.size()) throw std::runtime_error("planted");
  return of_bone == bone.size() && bytes.data()[bytes.size()] == 'x';
}

bool planted_number(std::string_view bytes) {
  if (bytes == "length 1e300") throw std::runtime_error("planted number");
  return true;
}

}  // namespace fascicle::fuzz
