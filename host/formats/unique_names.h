// Names that differ from each other.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "host/base/text.h"

namespace fascicle::formats {

// Hands out each name only once: the wanted one, or the first of NAME_2, NAME_3, ... that is free.
class UniqueNames {
 public:
  std::string take(const std::string& wanted) {
    if (taken_.insert(wanted).second) return wanted;
    // Continues where the last search for this name ended, because a taken name stays taken: many equal names
    // would otherwise take time by the square of their number.
    std::uint64_t& number = next_.try_emplace(wanted, 2).first->second;
    while (true) {
      std::string name = wanted + '_' + base::number_text(number++);
      if (taken_.insert(name).second) return name;
    }
  }

 private:
  std::unordered_set<std::string> taken_;
  std::unordered_map<std::string, std::uint64_t> next_;  // per wanted name: the number to try next
};

}  // namespace fascicle::formats
