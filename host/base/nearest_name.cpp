#include "host/base/nearest_name.h"

#include <algorithm>
#include <array>

namespace fascicle::base {
namespace {

// The number of insertions, deletions, substitutions and swaps of neighbours that turn a into b.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::array<std::vector<std::size_t>, 3> rows;
  for (auto& row : rows) row.resize(b.size() + 1);
  auto& [before_last, last, row] = rows;
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    std::swap(before_last, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

}  // namespace

std::string nearest_name(std::string_view given, const std::vector<std::string>& names) {
  // Longer than any real name; bounds the cost of a hostile key.
  given = given.substr(0, 256);
  // With several characters, names begin with NAME/, which is easily forgotten.
  const std::string owned = "/" + std::string(given);
  for (const std::string& name : names)
    if (!given.empty() && name.ends_with(owned)) return name;
  // One typo counts as near, however short the name is.
  constexpr std::size_t letters_a_slip = 3;
  const std::string* nearest = nullptr;
  std::size_t least = 0;
  for (const std::string& name : names) {
    const std::size_t most = std::max({given.size(), name.size(), letters_a_slip}) / letters_a_slip;
    const std::size_t longer = std::max(given.size(), name.size()) - std::min(given.size(), name.size());
    // Most names are ruled out by their length, without the slow comparison of their letters.
    if (longer > most || (nearest && longer >= least)) continue;
    const std::size_t distance = edit_distance(given, name);
    if (distance > most || (nearest && distance >= least)) continue;
    nearest = &name;
    least = distance;
  }
  return nearest ? *nearest : std::string{};
}

std::string nearest_name_hint(std::string_view given, const std::vector<std::string>& names) {
  const std::string nearest = nearest_name(given, names);
  return nearest.empty() ? "" : "; did you mean " + nearest + "?";
}

}  // namespace fascicle::base
