// libFuzzer's entry point; one program per reader, which FASCICLE_FUZZ_READER names.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/readers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  fascicle::fuzz::FASCICLE_FUZZ_READER({reinterpret_cast<const char*>(bytes), size});
  return 0;
}
