#include "host/base/json_text.h"

#include <array>
#include <cassert>

namespace fascicle::base {

std::string_view shallow_json(std::string_view text, unsigned most_keys, unsigned deepest) {
  assert(deepest <= deepest_nesting);
  std::array<unsigned, deepest_nesting + 1> keys{};  // of the innermost object at each level
  unsigned level = 0;
  bool is_in_string = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (is_in_string) {
      if (c == '\\')
        ++at;
      else if (c == '"')
        is_in_string = false;
    } else if (c == '"') {
      is_in_string = true;
    } else if (c == '[' || c == '{') {
      if (++level > deepest) return {};
      keys[level] = 0;
    } else if (c == ':') {
      if (++keys[level] > most_keys) return {};
    } else if ((c == ']' || c == '}') && level > 0) {
      --level;
    }
  }
  return text;
}

}  // namespace fascicle::base
