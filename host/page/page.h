// One self-contained page: no script, nothing from elsewhere, light or dark as the reader has it. It is HTML
// and well-formed XML.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/page/writer.h"

namespace fascicle::page {

// How good what is said is. A colour alone never says it: a word stands beside it.
enum class Tone { neutral, good, warning, bad };

// Head, style and header; then sections go into the writer. `state` is a word beside the title, or empty.
Writer begin(std::string_view title, std::string_view subtitle, std::string_view state = {},
             Tone tone = Tone::neutral);
// Closes what begin opened. `footer`: one line.
std::string finish(Writer&& page, std::string_view footer);

// A section with its heading; close() ends it. `id` is for the links of contents().
void open_section(Writer& page, std::string_view id, std::string_view heading);
// Links to sections, as pairs of id and heading.
void contents(Writer& page, const std::vector<std::pair<std::string, std::string>>& sections);

// Large figures side by side.
struct Fact {
  std::string name, value;
  Tone tone = Tone::neutral;
  std::string note;
};
void facts(Writer& page, const std::vector<Fact>& facts);

// Two columns: a name and what it is.
void rows(Writer& page, const std::vector<std::pair<std::string, std::string>>& rows,
          std::string_view caption = {});
// The first row is the head; columns from `first_number` on are numbers.
void table(Writer& page, const std::vector<std::vector<std::string>>& table, std::size_t first_number,
           std::string_view caption = {});

// What colours mean: names, and colours as "#rrggbb".
void swatches(Writer& page, const std::vector<std::pair<std::string, std::string>>& colours);

// A picture inside the page. `png`: the file's bytes; pixels as it has them.
void picture(Writer& page, std::string_view png, std::string_view alt, unsigned width, unsigned height);

}  // namespace fascicle::page
