#include "host/cli/metrics_table.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <sstream>

#include "host/bake/bake.h"
#include "host/bake/outputs.h"
#include "host/base/csv.h"
#include "host/base/file.h"

namespace fascicle::cli {

std::optional<double> csv_number(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

const std::vector<double>* MetricsTable::find(std::string_view column) const {
  const auto at = std::find(columns.begin(), columns.end(), column);
  return at == columns.end() ? nullptr : &values[static_cast<std::size_t>(at - columns.begin())];
}

MetricsTable read_metrics_table(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / bake::metrics_name;
  MetricsTable table;
  std::istringstream file(base::read_input_if_there(path, base::most_metrics_bytes).value_or(""));
  std::string line;
  if (!std::getline(file, line)) return table;
  table.columns = base::csv_columns(line, path);
  if (table.columns.front() != "frame")
    throw bake::BakeError(path.string() + ": its first column is not `frame`; bake again");
  table.values.resize(table.columns.size());
  while (std::getline(file, line)) {
    const std::vector<std::string> fields = base::csv_fields(line);
    if (fields.size() < table.columns.size() || !csv_number(fields.front())) continue;
    for (std::size_t c = 0; c < table.columns.size(); ++c)
      table.values[c].push_back(csv_number(fields[c]).value_or(std::numeric_limits<double>::quiet_NaN()));
  }
  return table;
}

}  // namespace fascicle::cli
