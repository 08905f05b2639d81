// Axis-aligned boxes compared on all axes at once.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>

namespace fascicle::model {

// Four floats, the last of which is 0 for points and boxes, and the result of comparing two of them.
using Quad = float __attribute__((vector_size(16)));
using QuadFlags = std::int32_t __attribute__((vector_size(16)));
using QuadHalves = std::int64_t __attribute__((vector_size(16)));

inline bool all_of(QuadFlags flags) {
  const auto halves = std::bit_cast<QuadHalves>(flags);
  return (halves[0] & halves[1]) == -1;
}

struct Box {
  Quad low, high;
};

inline constexpr float box_infinity = std::numeric_limits<float>::infinity();
inline constexpr Box empty_box{{box_infinity, box_infinity, box_infinity, box_infinity},
                               {-box_infinity, -box_infinity, -box_infinity, -box_infinity}};

// NaN does not grow a box.
inline void grow(Box& box, Quad low, Quad high) {
  box.low = low < box.low ? low : box.low;
  box.high = high > box.high ? high : box.high;
}

inline bool holds(const Box& box, Quad x) {
  return all_of((x >= box.low) & (x <= box.high));
}

inline bool overlap(const Box& a, const Box& b) {
  return all_of((a.low <= b.high) & (b.low <= a.high));
}

}  // namespace fascicle::model
