// Colours in linear light, and their way to bytes.
#pragma once

#include <cstdint>
#include <string>

#include "host/render/image.h"

namespace fascicle::render {

// The sRGB transfer function; 0 to 1 both ways.
float srgb_of_linear(float linear);
float linear_of_srgb(float encoded);
std::uint8_t byte_of_linear(float linear);

// 0xrrggbb as in a style sheet.
Vector3f colour(std::uint32_t hex);

// Of a layer: bone, muscle, fat and skin have their own, others the next of a row of eight by their number.
Vector3f layer_colour(const std::string& name, std::size_t number);

// Of what says nothing of its colour.
Vector3f skin_tone();

// Dark violet at 0 over green to yellow at 1, evenly brighter all the way, so that it reads the same in grey.
Vector3f scale_colour(float value);

// A line's direction: red along x, green along y, blue along z; the same both ways.
Vector3f direction_colour(const Vector3f& direction);

}  // namespace fascicle::render
