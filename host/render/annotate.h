// Text on pictures, and several pictures on one sheet.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/render/image.h"

namespace fascicle::render {

// Draws in capitals; characters without a glyph become spaces. (x, y) is the upper left corner, `height` the
// height of the letters, in pixels.
void draw_text(Image& image, unsigned x, unsigned y, unsigned height, const std::string& text,
               const Vector3f& ink);
unsigned text_width(unsigned height, const std::string& text);

// What the colours mean: named swatches or, if `is_scale`, one bar from the first name to the last.
struct Legend {
  struct Entry {
    std::string name;
    Vector3f colour;  // linear light
  };
  std::vector<Entry> entries;
  bool is_scale = false;
};

// In the lower left corner. Draws nothing if the picture is too small for it.
void draw_legend(Image& image, const Legend& legend);

// The greatest height, in pixels, at which each of these captions fits above a picture of this size.
unsigned caption_height(unsigned image_width, unsigned image_height, std::span<const std::string> words);
// Pictures of equal height from left to right, each under a strip of paper colour with a line of text, whose
// letters are `letters` pixels high.
Image row_of(std::span<const Image> images, std::span<const std::string> words, unsigned letters);

// Row by row, `columns` per row, all of one size; the rest of the last row stays blank paper.
Image sheet_of(std::span<const Image> images, unsigned columns);

}  // namespace fascicle::render
