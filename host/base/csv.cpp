#include "host/base/csv.h"

#include "host/base/errors.h"
#include "host/base/text.h"

namespace fascicle::base {

std::vector<std::string> csv_fields(std::string_view line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t k = 0; k < line.size(); ++k) {
    const char c = line[k];
    if (c == '"' && quoted && k + 1 < line.size() && line[k + 1] == '"') {
      fields.back() += c;
      ++k;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      if (fields.size() == most_csv_columns) break;
      fields.emplace_back();
    } else if (c != '\r') {
      fields.back() += c;
    }
  }
  return fields;
}

std::vector<std::string> csv_columns(std::string_view line, const std::filesystem::path& path) {
  std::size_t count = 1;
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == ',' && !quoted) ++count;
  }
  if (count > most_csv_columns)
    throw BakeError(path.string() + ": has " + number_text(count) +
                    " columns, the most is 4,096; bake again");
  return csv_fields(line);
}

namespace {

bool is_formula(std::string_view text) {
  return !text.empty() && std::string_view("=+-@").find(text.front()) != std::string_view::npos;
}

}  // namespace

std::string csv_text(std::string field) {
  if (field.starts_with('\'') && is_formula(std::string_view(field).substr(1))) field.erase(0, 1);
  return field;
}

std::string csv_field(std::string_view text) {
  std::string shown = shown_text(text);
  if (is_formula(shown)) shown.insert(shown.begin(), '\'');
  if (shown.find_first_of(",\"") == std::string::npos) return shown;
  std::string quoted = "\"";
  for (const char c : shown) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace fascicle::base
