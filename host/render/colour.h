// Colours in linear light, and their conversion to bytes.
#pragma once

#include <cstdint>
#include <string>

#include "host/render/image.h"

namespace fascicle::render {

// The sRGB transfer function; 0 to 1 both ways.
float srgb_of_linear(float linear);
float linear_of_srgb(float encoded);
std::uint8_t byte_of_linear(float linear);

// 0xrrggbb, as in a style sheet.
Vector3f colour(std::uint32_t hex);

// Bone, muscle, fat and skin have fixed colours; other layers take theirs from a cycle of eight by number.
Vector3f layer_colour(const std::string& name, std::size_t number);

// For surfaces without a colour of their own.
Vector3f skin_tone();

// Dark violet at 0 through green to yellow at 1, with evenly rising lightness, so that it also reads
// correctly in grey.
Vector3f scale_colour(float value);

// For the direction of a line: red along x, green along y, blue along z; the sign does not matter.
Vector3f direction_colour(const Vector3f& direction);

}  // namespace fascicle::render
