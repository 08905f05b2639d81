#include "host/cli/open_ends.h"

#include <map>

#include "host/cli/text.h"

namespace fascicle::cli {

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
