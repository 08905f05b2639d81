#include "host/render/colour.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace fascicle::render {

float srgb_of_linear(float linear) {
  const float x = std::clamp(linear, 0.0f, 1.0f);
  return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
}

float linear_of_srgb(float encoded) {
  const float x = std::clamp(encoded, 0.0f, 1.0f);
  return x <= 0.04045f ? x / 12.92f : std::pow((x + 0.055f) / 1.055f, 2.4f);
}

std::uint8_t byte_of_linear(float linear) {
  return static_cast<std::uint8_t>(std::lround(255.0f * srgb_of_linear(linear)));
}

Vector3f colour(std::uint32_t hex) {
  const auto channel = [hex](unsigned shift) {
    return linear_of_srgb(static_cast<float>((hex >> shift) & 0xffu) / 255.0f);
  };
  return {channel(16), channel(8), channel(0)};
}

Vector3f layer_colour(const std::string& name, std::size_t number) {
  if (name == "bone") return colour(0xede4cf);
  if (name == "muscle") return colour(0xb8433f);
  if (name == "fat") return colour(0xf2c14e);
  if (name == "skin") return colour(0xe6a98c);
  static constexpr std::array<std::uint32_t, 8> others{0x4c8fbd, 0x63a375, 0x9673b9, 0xd98248,
                                                       0x5cb8b2, 0xc46a94, 0x8d9440, 0x8c8c96};
  return colour(others[number % others.size()]);
}

Vector3f skin_tone() {
  return colour(0xe3ab8c);
}

Vector3f scale_colour(float value) {
  // Stops chosen by eye along a line of rising lightness.
  static const std::array<Vector3f, 6> stops{colour(0x3b1054), colour(0x3f4788), colour(0x2d718e),
                                             colour(0x1f9c88), colour(0x6cc35a), colour(0xf9e52a)};
  const float place = std::clamp(value, 0.0f, 1.0f) * static_cast<float>(stops.size() - 1);
  const std::size_t k = std::min(static_cast<std::size_t>(place), stops.size() - 2);
  const float t = place - static_cast<float>(k);
  return (1.0f - t) * stops[k] + t * stops[k + 1];
}

Vector3f direction_colour(const Vector3f& direction) {
  const float length = direction.norm();
  if (length == 0.0f) return Vector3f::Zero();
  // The squares sum to one: every direction is equally bright, and the axes get pure colours.
  const Vector3f share = (direction / length).cwiseAbs2();
  return share.x() * colour(0xd8342c) + share.y() * colour(0x2f9e41) + share.z() * colour(0x2b62d9);
}

}  // namespace fascicle::render
