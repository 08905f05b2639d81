#include "host/render/annotate.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <string_view>

#include "host/render/colour.h"

namespace fascicle::render {

namespace {

// A letter is a grid of seven rows of five dots (the highest bit is the leftmost); strokes join neighbouring
// dots, so that letters are round at any size.
constexpr int glyph_rows = 7, glyph_columns = 5, glyph_advance = 6;

struct Glyph {
  char letter;
  std::array<unsigned char, glyph_rows> rows;
};

constexpr std::array<Glyph, 44> glyphs{{
    {'0', {0x06, 0x09, 0x09, 0x09, 0x09, 0x09, 0x06}}, {'1', {0x04, 0x0c, 0x04, 0x04, 0x04, 0x04, 0x0e}},
    {'2', {0x0e, 0x11, 0x01, 0x02, 0x04, 0x08, 0x1f}}, {'3', {0x1f, 0x02, 0x04, 0x02, 0x01, 0x11, 0x0e}},
    {'4', {0x02, 0x06, 0x0a, 0x12, 0x1f, 0x02, 0x02}}, {'5', {0x1f, 0x10, 0x1e, 0x01, 0x01, 0x11, 0x0e}},
    {'6', {0x06, 0x08, 0x10, 0x1e, 0x11, 0x11, 0x0e}}, {'7', {0x1f, 0x01, 0x02, 0x04, 0x08, 0x08, 0x08}},
    {'8', {0x0e, 0x11, 0x11, 0x0e, 0x11, 0x11, 0x0e}}, {'9', {0x0e, 0x11, 0x11, 0x0f, 0x01, 0x02, 0x0c}},
    {'A', {0x0e, 0x11, 0x11, 0x1f, 0x11, 0x11, 0x11}}, {'B', {0x1e, 0x11, 0x11, 0x1e, 0x11, 0x11, 0x1e}},
    {'C', {0x0e, 0x11, 0x10, 0x10, 0x10, 0x11, 0x0e}}, {'D', {0x1e, 0x11, 0x11, 0x11, 0x11, 0x11, 0x1e}},
    {'E', {0x1f, 0x10, 0x10, 0x1e, 0x10, 0x10, 0x1f}}, {'F', {0x1f, 0x10, 0x10, 0x1e, 0x10, 0x10, 0x10}},
    {'G', {0x0e, 0x11, 0x10, 0x17, 0x11, 0x11, 0x0e}}, {'H', {0x11, 0x11, 0x11, 0x1f, 0x11, 0x11, 0x11}},
    {'I', {0x0e, 0x04, 0x04, 0x04, 0x04, 0x04, 0x0e}}, {'J', {0x07, 0x02, 0x02, 0x02, 0x02, 0x12, 0x0c}},
    {'K', {0x11, 0x12, 0x14, 0x18, 0x14, 0x12, 0x11}}, {'L', {0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x1f}},
    {'M', {0x11, 0x1b, 0x15, 0x15, 0x11, 0x11, 0x11}}, {'N', {0x11, 0x19, 0x15, 0x13, 0x11, 0x11, 0x11}},
    {'O', {0x0e, 0x11, 0x11, 0x11, 0x11, 0x11, 0x0e}}, {'P', {0x1e, 0x11, 0x11, 0x1e, 0x10, 0x10, 0x10}},
    {'Q', {0x0e, 0x11, 0x11, 0x11, 0x15, 0x12, 0x0d}}, {'R', {0x1e, 0x11, 0x11, 0x1e, 0x14, 0x12, 0x11}},
    {'S', {0x0f, 0x10, 0x10, 0x0e, 0x01, 0x01, 0x1e}}, {'T', {0x1f, 0x04, 0x04, 0x04, 0x04, 0x04, 0x04}},
    {'U', {0x11, 0x11, 0x11, 0x11, 0x11, 0x11, 0x0e}}, {'V', {0x11, 0x11, 0x11, 0x11, 0x11, 0x0a, 0x04}},
    {'W', {0x11, 0x11, 0x11, 0x15, 0x15, 0x1b, 0x11}}, {'X', {0x11, 0x11, 0x0a, 0x04, 0x0a, 0x11, 0x11}},
    {'Y', {0x11, 0x11, 0x0a, 0x04, 0x04, 0x04, 0x04}}, {'Z', {0x1f, 0x01, 0x02, 0x04, 0x08, 0x10, 0x1f}},
    {'.', {0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x04}}, {'-', {0x00, 0x00, 0x00, 0x0e, 0x00, 0x00, 0x00}},
    {'/', {0x01, 0x01, 0x02, 0x04, 0x08, 0x10, 0x10}}, {'_', {0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x1f}},
    {'+', {0x00, 0x04, 0x04, 0x1f, 0x04, 0x04, 0x00}}, {':', {0x00, 0x00, 0x04, 0x00, 0x04, 0x00, 0x00}},
    {'=', {0x00, 0x00, 0x1f, 0x00, 0x1f, 0x00, 0x00}}, {'%', {0x18, 0x19, 0x02, 0x04, 0x08, 0x13, 0x03}},
}};

struct Stroke {
  float x0, y0, x1, y1;  // in dots
};

std::vector<Stroke> strokes_of(char letter) {
  const char capital = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  std::vector<Stroke> strokes;
  for (const Glyph& glyph : glyphs) {
    if (glyph.letter != capital) continue;
    const auto lit = [&glyph](int x, int y) {
      return x >= 0 && x < glyph_columns && y < glyph_rows &&
             ((glyph.rows[static_cast<std::size_t>(y)] >> (glyph_columns - 1 - x)) & 1) != 0;
    };
    for (int y = 0; y < glyph_rows; ++y)
      for (int x = 0; x < glyph_columns; ++x) {
        if (!lit(x, y)) continue;
        const float fx = static_cast<float>(x), fy = static_cast<float>(y);
        strokes.push_back({fx, fy, fx, fy});
        if (lit(x + 1, y)) strokes.push_back({fx, fy, fx + 1, fy});
        if (lit(x, y + 1)) strokes.push_back({fx, fy, fx, fy + 1});
        // Diagonal strokes only where no corner already joins the two dots.
        if (lit(x + 1, y + 1) && !lit(x + 1, y) && !lit(x, y + 1))
          strokes.push_back({fx, fy, fx + 1, fy + 1});
        if (lit(x - 1, y + 1) && !lit(x - 1, y) && !lit(x, y + 1))
          strokes.push_back({fx, fy, fx - 1, fy + 1});
      }
  }
  return strokes;
}

float distance(const Stroke& s, float x, float y) {
  const float dx = s.x1 - s.x0, dy = s.y1 - s.y0, length = dx * dx + dy * dy;
  const float t = length > 0.0f ? std::clamp(((x - s.x0) * dx + (y - s.y0) * dy) / length, 0.0f, 1.0f) : 0.0f;
  return std::hypot(x - s.x0 - t * dx, y - s.y0 - t * dy);
}

void fill(Image& image, unsigned x0, unsigned y0, unsigned width, unsigned height, const Vector3f& colour) {
  for (unsigned y = y0; y < std::min(image.height, y0 + height); ++y)
    for (unsigned x = x0; x < std::min(image.width, x0 + width); ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = byte_of_linear(colour[c]);
}

constexpr std::uint8_t paper = 235;
const Vector3f dark_ink(0.05f, 0.05f, 0.06f);

}  // namespace

unsigned text_width(unsigned height, const std::string& text) {
  const float dot = static_cast<float>(height) / glyph_rows;
  return static_cast<unsigned>(std::ceil(dot * glyph_advance * static_cast<float>(text.size())));
}

void draw_text(Image& image, unsigned x0, unsigned y0, unsigned height, const std::string& text,
               const Vector3f& ink) {
  const float dot = static_cast<float>(height) / glyph_rows;
  constexpr float half_width = 0.42f;  // half the width of a stroke, in dots
  for (std::size_t k = 0; k < text.size(); ++k) {
    const std::vector<Stroke> strokes = strokes_of(text[k]);
    if (strokes.empty()) continue;
    const float left = static_cast<float>(x0) + dot * glyph_advance * static_cast<float>(k);
    const unsigned first = static_cast<unsigned>(left);
    const unsigned last = static_cast<unsigned>(left + dot * glyph_advance);
    for (unsigned y = y0; y < std::min(image.height, y0 + height + 1); ++y)
      for (unsigned x = first; x < std::min(image.width, last); ++x) {
        const float gx = (static_cast<float>(x) + 0.5f - left) / dot - 0.5f;
        const float gy = (static_cast<float>(y - y0) + 0.5f) / dot - 0.5f;
        float nearest = 1e9f;
        for (const Stroke& stroke : strokes) nearest = std::min(nearest, distance(stroke, gx, gy));
        const float cover = std::clamp(0.5f + (half_width - nearest) * dot, 0.0f, 1.0f);
        std::uint8_t* pixel = image.at(x, y);
        for (int c = 0; c < 3; ++c)
          pixel[c] = static_cast<std::uint8_t>(
              std::lround((1.0f - cover) * pixel[c] + cover * 255.0f * srgb_of_linear(ink[c])));
      }
  }
}

void draw_legend(Image& image, const Legend& legend) {
  if (legend.entries.empty() || image.height < 120 || image.width < 160) return;
  const unsigned text = std::max(9u, image.height / 64), swatch = text + text / 2, gap = text;
  if (legend.is_scale) {
    const unsigned width = std::min(image.width / 3, 16 * text), bar = text;
    const unsigned x0 = gap, y0 = image.height - gap - text - text / 2 - bar;
    const std::size_t stops = legend.entries.size();
    for (unsigned x = 0; x < width; ++x) {
      const float place = static_cast<float>(x) / static_cast<float>(width) * static_cast<float>(stops - 1);
      const std::size_t k = std::min(static_cast<std::size_t>(place), stops - 2);
      const float t = place - static_cast<float>(k);
      fill(image, x0 + x, y0, 1, bar,
           (1.0f - t) * legend.entries[k].colour + t * legend.entries[k + 1].colour);
    }
    const std::string &low = legend.entries.front().name, &high = legend.entries.back().name;
    const unsigned y1 = y0 + bar + text / 2;
    draw_text(image, x0, y1, text, low, dark_ink);
    const unsigned right = text_width(text, high);
    draw_text(image, right < width ? x0 + width - right : x0, y1, text, high, dark_ink);
    return;
  }
  unsigned y = image.height - gap - swatch;
  for (auto entry = legend.entries.rbegin(); entry != legend.entries.rend(); ++entry) {
    fill(image, gap, y, swatch, swatch, entry->colour);
    draw_text(image, gap + swatch + text / 2, y + (swatch - text) / 2, text, entry->name, dark_ink);
    if (y < swatch + swatch / 2) return;
    y -= swatch + swatch / 3;
  }
}

namespace {

// The height of a strip's letters if all captions are short.
unsigned text_of_row(unsigned image_height) {
  return std::max(9u, image_height / 32);
}

}  // namespace

unsigned caption_height(unsigned image_width, unsigned image_height, std::span<const std::string> words) {
  const unsigned text = text_of_row(image_height);
  unsigned height = text;
  for (const std::string& line : words)
    while (height > 5 && text_width(height, line) + text > image_width) --height;
  return height;
}

Image row_of(std::span<const Image> images, std::span<const std::string> words, unsigned letters) {
  if (images.empty()) return {};
  const unsigned text = text_of_row(images[0].height), strip = 2 * text;
  unsigned width = 0;
  for (const Image& image : images) width += image.width;
  Image row(width, strip + images[0].height);
  std::fill(row.pixels.begin(), row.pixels.end(), paper);
  unsigned x = 0;
  for (std::size_t k = 0; k < images.size(); ++k) {
    const Image& image = images[k];
    draw_text(row, x + text / 2, (strip - letters) / 2, letters, words[k], dark_ink);
    for (unsigned y = 0; y < image.height; ++y)
      std::memcpy(row.at(x, strip + y), image.at(0, y), std::size_t{3} * image.width);
    x += image.width;
  }
  return row;
}

Image sheet_of(std::span<const Image> images, unsigned columns) {
  if (images.empty() || columns == 0) return {};
  const unsigned width = images[0].width, height = images[0].height;
  const unsigned rows = static_cast<unsigned>((images.size() + columns - 1) / columns);
  Image sheet(columns * width, rows * height);
  std::fill(sheet.pixels.begin(), sheet.pixels.end(), paper);
  for (std::size_t k = 0; k < images.size(); ++k)
    for (unsigned y = 0; y < height; ++y)
      std::memcpy(sheet.at(static_cast<unsigned>(k % columns) * width,
                           static_cast<unsigned>(k / columns) * height + y),
                  images[k].at(0, y), std::size_t{3} * width);
  return sheet;
}

}  // namespace fascicle::render
