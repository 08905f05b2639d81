// Writes XML that is HTML too. Every text and every value of an attribute is escaped here and nowhere else.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fascicle::page {

using Attributes = std::vector<std::pair<std::string_view, std::string>>;

// Text as XML and HTML show it: markup becomes entities, and what a reader would obey and not show (controls,
// marks that turn the direction of text, bytes that are no UTF-8) becomes \n, \x1b or \u202e.
std::string escaped(std::string_view text);

// An element is open until it is closed; text() and other elements go into the innermost open one.
class Writer {
 public:
  Writer& start(std::string_view name, const Attributes& attributes = {});
  // Without content: <meta .../>, <img .../>, or an element of SVG.
  Writer& empty(std::string_view name, const Attributes& attributes = {});
  Writer& text(std::string_view text);
  Writer& line_end();
  Writer& close();
  // start, text, close.
  Writer& element(std::string_view name, std::string_view text, const Attributes& attributes = {});

  // The page's own style, which is no one's input: it has no markup.
  Writer& style(std::string_view css);

  // All that was written; every element must be closed.
  std::string finish() &&;

 private:
  void tag(std::string_view name, const Attributes& attributes, std::string_view end);

  std::string out_;
  std::vector<std::string> open_;
};

}  // namespace fascicle::page
