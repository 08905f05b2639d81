#include <stdexcept>

#include "tests/fuzz/readers.h"

namespace fascicle::fuzz {

bool planted(std::string_view bytes) {
  // Compares letter by letter, so that coverage guides the fuzzer.
  const std::string_view bone = "bone", fat = "fat";
  std::size_t of_bone = 0, of_fat = 0;
  while (of_bone < bone.size() && of_bone < bytes.size() && bytes[of_bone] == bone[of_bone]) ++of_bone;
  while (of_fat < fat.size() && of_fat < bytes.size() && bytes[of_fat] == fat[of_fat]) ++of_fat;
  if (of_fat == fat.size()) throw std::runtime_error("planted");
  return of_bone == bone.size() && bytes.data()[bytes.size()] == 'x';
}

}  // namespace fascicle::fuzz
