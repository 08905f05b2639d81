// libFuzzer's entry points; one program per reader, which FASCICLE_FUZZ_READER names.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/readers.h"
#include "tests/fuzz/strange_numbers.h"

using fascicle::fuzz::NumberPlace;

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* bytes, std::size_t size, std::size_t most);

// One change in sixteen replaces a number; the others are libFuzzer's own.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size, std::size_t most,
                                               unsigned seed) {
  std::minstd_rand random(seed);
  random.discard(1);  // the first value is nearly the seed
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

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  fascicle::fuzz::FASCICLE_FUZZ_READER({reinterpret_cast<const char*>(bytes), size});
  return 0;
}
