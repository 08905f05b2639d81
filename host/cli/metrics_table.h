// metrics.csv as columns of numbers.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fascicle::cli {

// Nothing where the field is no number.
std::optional<double> csv_number(const std::string& text);

struct MetricsTable {
  std::vector<std::string> columns;
  std::vector<std::vector<double>>
      values;  // one list a column, of one length; not a number where none stands

  // The values of a column, or null.
  const std::vector<double>* find(std::string_view column) const;
  std::size_t rows() const { return values.empty() ? 0 : values.front().size(); }
};

// Of the bake in `folder`; no columns where it has no metrics.csv. A last line that is cut off, as of a
// running bake, is left out. Throws bake::BakeError where the file is something else.
MetricsTable read_metrics_table(const std::filesystem::path& folder);

}  // namespace fascicle::cli
