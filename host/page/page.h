// A self-contained page: no script, nothing external, light or dark by the reader's preference. It is HTML
// and well-formed XML.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/page/writer.h"

namespace fascicle::page {

// The severity of a statement. Colour is never the only sign: there is always a word, too.
enum class Tone { neutral, good, warning, bad };

// Writes the head, style and header; sections follow. `state`: a word beside the title, or empty.
Writer begin(std::string_view title, std::string_view subtitle, std::string_view state = {},
             Tone tone = Tone::neutral);
// Closes what begin opened. `footer`: one line.
std::string finish(Writer&& page, std::string_view footer);

// A section with its heading; end it with close(). `id`: for the links of contents().
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

// Two columns: name and value.
void rows(Writer& page, const std::vector<std::pair<std::string, std::string>>& rows,
          std::string_view caption = {});
// The first row is the header; columns from `first_number` on are numeric.
void table(Writer& page, const std::vector<std::vector<std::string>>& table, std::size_t first_number,
           std::string_view caption = {});

// A legend of colours: names, and colours as "#rrggbb".
void swatches(Writer& page, const std::vector<std::pair<std::string, std::string>>& colours);

// An embedded picture. `png`: the file's bytes; `width`, `height`: its pixels.
void picture(Writer& page, std::string_view png, std::string_view alt, unsigned width, unsigned height);

}  // namespace fascicle::page
