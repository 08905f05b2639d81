// Words on pictures, and several pictures on one sheet.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/render/image.h"

namespace fascicle::render {

// Draws in capitals; what has no letter here becomes a space. (x, y) is the upper left corner, `height` that
// of the letters, in pixels.
void draw_text(Image& image, unsigned x, unsigned y, unsigned height, const std::string& text,
               const Vector3f& ink);
unsigned text_width(unsigned height, const std::string& text);

// What the colours mean: swatches with their names, or, if `is_scale`, one bar from the first name to the
// last.
struct Legend {
  struct Entry {
    std::string name;
    Vector3f colour;  // linear light
  };
  std::vector<Entry> entries;
  bool is_scale = false;
};

// In the lower left corner. Nothing where the picture is too small for it.
void draw_legend(Image& image, const Legend& legend);

// Pictures of one height from left to right, under a strip of paper with a line of words over each. Words
// that are too long are drawn smaller.
Image row_of(std::span<const Image> images, std::span<const std::string> words);

// Row by row, `columns` a row, all of one size; the rest of the last row stays paper.
Image sheet_of(std::span<const Image> images, unsigned columns);

}  // namespace fascicle::render
