// metrics.csv as columns of numbers.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fascicle::cli {

// nullopt if the field is not a number.
std::optional<double> csv_number(const std::string& text);

struct MetricsTable {
  std::vector<std::string> columns;
  std::vector<std::vector<double>>
      values;  // one list per column, all of equal length; NaN for missing values

  // The values of a column; null if there is none.
  const std::vector<double>* find(std::string_view column) const;
  std::size_t rows() const { return values.empty() ? 0 : values.front().size(); }
};

// For the bake in `folder`; no columns if it has no metrics.csv. Skips an incomplete last line, as in a
// running bake. Throws bake::BakeError if the file is not a metrics table.
MetricsTable read_metrics_table(const std::filesystem::path& folder);

}  // namespace fascicle::cli
