#include "host/cli/open_ends.h"

#include <algorithm>
#include <array>
#include <map>

#include "host/cli/text.h"

namespace fascicle::cli {

std::vector<bake::OpenEndEntry> open_ends_of(const build::Report& report) {
  // As build::OpenEnd::Fate counts.
  static constexpr std::array<const char*, 3> fates{"closed", "left open: the outline of a sheet",
                                                    "left open: a hem around several limbs"};
  const build::OpenEnds& ends = report.fill.cage.ends;
  std::vector<bake::OpenEndEntry> entries;
  for (std::size_t k = 0; k < ends.vertex.size(); ++k) {
    const bool has_joint =
        ends.joint[k] >= 0 && static_cast<std::size_t>(ends.joint[k]) < report.joints.size();
    entries.push_back({has_joint ? report.joints[static_cast<std::size_t>(ends.joint[k])].name : "",
                       fates[std::min<std::size_t>(ends.fate[k], fates.size() - 1)], ends.width[k],
                       ends.edges[k], ends.vertex[k]});
  }
  return entries;
}

std::vector<std::pair<std::string, std::string>> rows_of(const std::vector<bake::OpenEndEntry>& ends) {
  struct Row {
    std::size_t count = 0;
    double widest = 0.0;
    std::uint32_t vertex = 0;
  };
  std::map<std::pair<std::string, std::string>, Row> found;
  for (const bake::OpenEndEntry& end : ends) {
    Row& row = found[{end.became, end.joint}];
    ++row.count;
    if (end.width < row.widest) continue;
    row.widest = end.width;
    row.vertex = end.vertex;
  }
  std::vector<std::pair<std::string, std::string>> rows;
  for (const auto& [key, row] : found)
    rows.emplace_back("open ends" + (key.second.empty() ? "" : " at " + key.second),
                      count_text(row.count) + " " + key.first + "; the widest " +
                          number_text(row.widest * 1e3) + " mm, at vertex " + std::to_string(row.vertex));
  return rows;
}

}  // namespace fascicle::cli
