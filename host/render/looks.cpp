#include "host/render/looks.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host/render/colour.h"

namespace fascicle::render {
namespace {

constexpr float full = 65535.0f;

std::array<std::uint16_t, 256> linear_bytes() {
  std::array<std::uint16_t, 256> table{};
  for (std::size_t k = 0; k < table.size(); ++k)
    table[k] = static_cast<std::uint16_t>(std::lround(full * linear_of_srgb(static_cast<float>(k) / 255.0f)));
  return table;
}

// The index of the texel at `place`, which may be outside 0 to count - 1.
unsigned wrapped(std::int64_t place, unsigned count, Wrap wrap) {
  const auto n = static_cast<std::int64_t>(count);
  switch (wrap) {
    case Wrap::clamp:
      return static_cast<unsigned>(std::clamp<std::int64_t>(place, 0, n - 1));
    case Wrap::mirror: {
      const std::int64_t in_two = ((place % (2 * n)) + 2 * n) % (2 * n);
      return static_cast<unsigned>(in_two < n ? in_two : 2 * n - 1 - in_two);
    }
    case Wrap::repeat:
      break;
  }
  return static_cast<unsigned>(((place % n) + n) % n);
}

// Two neighbouring texels and the share of the second.
struct Neighbours {
  std::array<unsigned, 2> texel{};
  float share = 0.0f;
};

Neighbours neighbours(float coordinate, unsigned count, Wrap wrap) {
  // Beyond this a float has no fraction of a texel left; NaN is outside too.
  constexpr float farthest = 1e6f;
  const float inside = std::isfinite(coordinate) ? std::clamp(coordinate, -farthest, farthest) : 0.0f;
  const double place = static_cast<double>(inside) * count - 0.5;
  const double below = std::floor(place);
  const auto first = static_cast<std::int64_t>(below);
  return {{wrapped(first, count, wrap), wrapped(first + 1, count, wrap)}, static_cast<float>(place - below)};
}

}  // namespace

Texture::Texture(const Texels& texels, Wrap across, Wrap down, unsigned most) : across_(across), down_(down) {
  if (texels.width == 0 || texels.height == 0 ||
      texels.values.size() != std::size_t{4} * texels.width * texels.height)
    throw std::invalid_argument("Texture: needs width x height x 4 values, and at least one texel");
  static const std::array<std::uint16_t, 256> linear = linear_bytes();
  Level first{texels.width, texels.height, {}};
  first.values.reserve(texels.values.size());
  for (std::size_t k = 0; k < texels.values.size(); ++k)
    first.values.push_back(k % 4 == 3 ? static_cast<std::uint16_t>(257u * texels.values[k])
                                      : linear[texels.values[k]]);
  levels_.push_back(std::move(first));
  while (levels_.back().width > std::max(most, 1u) || levels_.back().height > std::max(most, 1u))
    levels_.back() = half_of(levels_.back());
  while (levels_.back().width > 1 || levels_.back().height > 1) levels_.push_back(half_of(levels_.back()));
}

// The mean of each two by two texels. The last row or column of an odd number is dropped, unless it is the
// only one.
Texture::Level Texture::half_of(const Level& level) {
  Level half{std::max(1u, level.width / 2), std::max(1u, level.height / 2), {}};
  half.values.reserve(std::size_t{4} * half.width * half.height);
  const auto value = [&level](unsigned x, unsigned y, std::size_t c) -> std::uint32_t {
    return level.values[4 * (std::size_t{std::min(y, level.height - 1)} * level.width +
                             std::min(x, level.width - 1)) +
                        c];
  };
  for (unsigned y = 0; y < half.height; ++y)
    for (unsigned x = 0; x < half.width; ++x)
      for (std::size_t c = 0; c < 4; ++c)
        half.values.push_back(
            static_cast<std::uint16_t>((value(2 * x, 2 * y, c) + value(2 * x + 1, 2 * y, c) +
                                        value(2 * x, 2 * y + 1, c) + value(2 * x + 1, 2 * y + 1, c) + 2) /
                                       4));
  return half;
}

Texels Texture::texels() const {
  const Level& level = levels_[0];
  Texels texels{level.width, level.height, {}};
  texels.values.reserve(level.values.size());
  for (std::size_t k = 0; k < level.values.size(); ++k) {
    const float value = static_cast<float>(level.values[k]) / full;
    texels.values.push_back(k % 4 == 3 ? static_cast<std::uint8_t>(std::lround(255.0f * value))
                                       : byte_of_linear(value));
  }
  return texels;
}

unsigned Texture::level_for(float texels) const {
  unsigned level = 0;
  for (; texels > 2.0f && level + 1 < level_count(); ++level) texels /= 4.0f;
  return level;
}

Vector4f Texture::at(const Vector2f& uv, unsigned number) const {
  const Level& level = levels_[std::min(number, level_count() - 1)];
  const Neighbours x = neighbours(uv.x(), level.width, across_), y = neighbours(uv.y(), level.height, down_);
  const auto texel = [&](std::size_t i, std::size_t j) {
    const std::uint16_t* v = &level.values[4 * (std::size_t{y.texel[j]} * level.width + x.texel[i])];
    return Vector4f(v[0], v[1], v[2], v[3]);
  };
  const Vector4f above = (1.0f - x.share) * texel(0, 0) + x.share * texel(1, 0);
  const Vector4f below = (1.0f - x.share) * texel(0, 1) + x.share * texel(1, 1);
  return ((1.0f - y.share) * above + y.share * below) / full;
}

}  // namespace fascicle::render
