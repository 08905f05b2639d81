#include "host/page/curves.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "host/bake/outputs.h"
#include "host/base/csv.h"
#include "host/base/errors.h"
#include "host/base/file.h"
#include "host/base/text.h"

namespace fascicle::page {

namespace {

// Of all curves together. The file's columns and the bake's frames are few bytes each, their product is not.
constexpr std::uint64_t most_values = 10'000'000;

std::optional<double> number_in(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

struct Column {
  std::size_t number = 0;
  double factor = 1.0;  // to the curve's unit
};

struct Drawn {
  const char* column;
  const char* name;
  const char* unit;
  double factor = 1.0;
  std::optional<double> limit = {};
};

// In the order of the page's list; lags come before these.
const std::vector<Drawn>& drawn_columns() {
  static const std::vector<Drawn> columns{{"kinetic_energy", "Energy", "J"},
                                          {"volume_ratio", "Volume", "%", 100.0},
                                          {"look", "Look", "", 1.0, 1.0},
                                          {"inverted", "Inverted", ""},
                                          {"contact_deepest", "Contact depth", "mm", 1e3}};
  return columns;
}

}  // namespace

std::vector<Curve> read_curves(const std::filesystem::path& folder, std::uint64_t frames) {
  const std::filesystem::path path = folder / bake::metrics_name;
  std::istringstream file(base::read_input_if_there(path, base::most_metrics_bytes).value_or(""));
  std::string line;
  if (!std::getline(file, line)) return {};
  const std::vector<std::string> header = base::csv_columns(line, path);
  std::vector<Curve> curves;
  std::vector<Column> columns;
  const auto add = [&](std::size_t number, const std::string& name, const char* unit, double factor,
                       std::optional<double> limit) {
    columns.push_back({number, factor});
    if (columns.size() * frames > most_values)
      throw base::BakeError(path.string() + ": its columns of " + base::number_text(frames) +
                            " frames are too many for a page; bake a shorter range (--start, --end)");
    curves.push_back({name, unit, std::vector<std::optional<double>>(frames), limit});
  };
  const std::string lag = bake::lag_column;
  for (std::size_t c = 0; c < header.size(); ++c)
    if (header[c].starts_with(lag)) add(c, "Lag of " + header[c].substr(lag.size()), "mm", 1e3, {});
  for (const Drawn& drawn : drawn_columns())
    if (const auto at = std::find(header.begin(), header.end(), drawn.column); at != header.end())
      add(static_cast<std::size_t>(at - header.begin()), drawn.name, drawn.unit, drawn.factor, drawn.limit);
  while (std::getline(file, line)) {
    const std::vector<std::string> fields = base::csv_fields(line);
    const std::optional<double> frame = number_in(fields[0]);
    if (!frame || !(*frame >= 0.0 && *frame < static_cast<double>(frames))) continue;
    for (std::size_t c = 0; c < curves.size(); ++c)
      if (columns[c].number < fields.size())
        if (const std::optional<double> value = number_in(fields[columns[c].number]))
          curves[c].values[static_cast<std::size_t>(*frame)] = *value * columns[c].factor;
  }
  std::erase_if(curves, [](const Curve& curve) {
    return std::all_of(curve.values.begin(), curve.values.end(),
                       [](const std::optional<double>& value) { return value.value_or(0.0) == 0.0; });
  });
  return curves;
}

}  // namespace fascicle::page
