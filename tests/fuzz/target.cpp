// libFuzzer's entry points; one program per reader, which FASCICLE_FUZZ_READER names.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/readers.h"
#include "tests/fuzz/strange_numbers.h"

using fascicle::fuzz::NumberPlace;

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* bytes, std::size_t size, std::size_t most);

// One change in sixteen replaces a number; the others are libFuzzer's own.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size, std::size_t most,
                                               unsigned seed) {
  std::minstd_rand random(seed);
  if (random() % 16 != 0) return LLVMFuzzerMutate(bytes, size, most);
  const std::string text(bytes, bytes + size);
  const std::vector<NumberPlace> places = fascicle::fuzz::numbers_in(text);
  if (places.empty()) return LLVMFuzzerMutate(bytes, size, most);
  const NumberPlace& place = places[random() % places.size()];
  const auto& numbers = fascicle::fuzz::strange_numbers;
  const std::string changed = fascicle::fuzz::with_number(text, place, numbers[random() % numbers.size()]);
  if (changed.size() > most) return LLVMFuzzerMutate(bytes, size, most);
  std::copy(changed.begin(), changed.end(), bytes);
  return changed.size();
}

// With FASCICLE_FUZZ_EACH_NUMBER, reads the file with each of its numbers replaced by each strange one
// instead. The last line of the log then says which.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const bool has_each_number = std::getenv("FASCICLE_FUZZ_EACH_NUMBER") != nullptr;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  if (!has_each_number) {
    fascicle::fuzz::FASCICLE_FUZZ_READER(text);
    return 0;
  }
  for (const NumberPlace& place : fascicle::fuzz::numbers_in(text))
    for (const std::string_view number : fascicle::fuzz::strange_numbers) {
      std::fprintf(stderr, "byte %zu: %.*s\n", place.begin, static_cast<int>(number.size()), number.data());
      fascicle::fuzz::FASCICLE_FUZZ_READER(fascicle::fuzz::with_number(text, place, number));
    }
  return 0;
}
