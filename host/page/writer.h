// Writes XML that is also HTML. All text and attribute values are escaped here and nowhere else.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fascicle::page {

using Attributes = std::vector<std::pair<std::string_view, std::string>>;

// Text escaped for XML and HTML: markup becomes entities; invisible characters with an effect (control
// characters, bidirectional marks) and invalid UTF-8 become
// , \x1b or \u202e.
std::string escaped(std::string_view text);

// An element stays open until it is closed; text() and other elements go into the innermost open one.
class Writer {
 public:
  Writer& start(std::string_view name, const Attributes& attributes = {});
  // An element without content: <meta .../>, <img .../>, or one of SVG.
  Writer& empty(std::string_view name, const Attributes& attributes = {});
  Writer& text(std::string_view text);
  Writer& line_end();
  Writer& close();
  // Equivalent to start, text, close.
  Writer& element(std::string_view name, std::string_view text, const Attributes& attributes = {});

  // The page's own style sheet. Not escaped, so it must not come from input.
  Writer& style(std::string_view css);

  // Returns everything written; all elements must be closed.
  std::string finish() &&;

 private:
  void tag(std::string_view name, const Attributes& attributes, std::string_view end);

  std::string out_;
  std::vector<std::string> open_;
};

}  // namespace fascicle::page
