#include "tests/fuzz/strange_numbers.h"

namespace fascicle::fuzz {
namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool is_in_name(char c) {
  return is_digit(c) || c == '_' || c == '.' || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

}  // namespace

std::vector<NumberPlace> numbers_in(std::string_view text) {
  std::vector<NumberPlace> places;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const std::size_t begin = k;
    if (text[k] == '-' && k + 1 < text.size()) ++k;
    if (!is_digit(text[k]) || (begin > 0 && is_in_name(text[begin - 1]))) continue;
    while (k < text.size() &&
           (is_in_name(text[k]) || ((text[k] == '-' || text[k] == '+') && text[k - 1] == 'e')))
      ++k;
    places.push_back({begin, k - begin});
  }
  return places;
}

std::string with_number(std::string_view text, const NumberPlace& place, std::string_view number) {
  std::string changed(text.substr(0, place.begin));
  changed += number;
  changed += text.substr(place.begin + place.length);
  return changed;
}

}  // namespace fascicle::fuzz
