// Numbers in texts, replaced by ones that a reader may not expect. A fuzzer that changes single bytes rarely
// finds them: in ten million files it wrote no 1e300, whose conversion to an integer is undefined.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace fascicle::fuzz {

// Too large for a double, any integer, 64 bits, 32 bits; negative; the largest of 32 bits, which often means
// "none"; zero; with a fraction; too small for a normal number; no number at all.
inline constexpr std::array<std::string_view, 14> strange_numbers{"1e999",
                                                                  "1e300",
                                                                  "-1e300",
                                                                  "18446744073709551616",
                                                                  "-9223372036854775809",
                                                                  "9223372036854775807",
                                                                  "4294967296",
                                                                  "2147483648",
                                                                  "-1",
                                                                  "4294967295",
                                                                  "0",
                                                                  "0.5",
                                                                  "1e-320",
                                                                  "null"};

struct NumberPlace {
  std::size_t begin = 0, length = 0;
};
std::vector<NumberPlace> numbers_in(std::string_view text);
std::string with_number(std::string_view text, const NumberPlace& place, std::string_view number);

}  // namespace fascicle::fuzz
