// Lines of comma-separated values (RFC 4180).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace fascicle::base {

// The most columns of a table that is read: far more than a bake writes, which has at most 256 layers and 256
// probes with three columns each.
inline constexpr std::size_t most_csv_columns = 4096;

// The fields of a line. A quoted field may contain commas, and "" for a quotation mark. Fields beyond the
// most columns are left out: a damaged line may have one for each byte.
std::vector<std::string> csv_fields(std::string_view line);
// The same for a table's first line, the names of its columns. Throws BakeError, naming `path`, if there are
// more than most_csv_columns.
std::vector<std::string> csv_columns(std::string_view line, const std::filesystem::path& path);

// Any text as one field. The line stays one line: line breaks and other control characters become escapes, as
// in base::shown_text. A leading = + - or @, at which spreadsheets would take the text for a formula, gets a
// ' before it.
std::string csv_field(std::string_view text);
// The text of a field that csv_field wrote and csv_fields read, without the ' before it. Escapes stay.
std::string csv_text(std::string field);

}  // namespace fascicle::base
