// The bytes that a substep moves, which the benchmark divides by its time, against a count of the arrays by
// hand.
#include "cpu_reference/solver/slices.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "cpu_reference/solver/fields.h"
#include "shaders/shared.h"
#include "tests/support/bar_model.h"

namespace fascicle::tests {
namespace {

using model::Model;

// One-ring entries per vertex: a slice has as many rows as its largest one-ring has neighbours.
double entries_of(const Model& m) {
  double entries = 0.0;
  for (std::uint32_t first = 0; first < m.vertex_count; first += cpu_reference::slice_size) {
    std::uint32_t rows = 0;
    for (std::uint32_t i = first; i < std::min(first + cpu_reference::slice_size, m.vertex_count); ++i)
      rows = std::max(rows, m.ring_offset[i + 1] - m.ring_offset[i]);
    entries += rows * cpu_reference::slice_size;
  }
  return entries / m.vertex_count;
}

// Per vertex, in floats or numbers of 4 bytes. Stage region reads 8 of the vertex and 4 numbers, and the
// entries; it writes a map of 16 and reads the rotation from the last one. Stage blend reads a map of 16, the
// entries, 2 numbers and 8 of the vertex, and writes those 8.
TEST(SubstepBytes, AreThoseOfTheArrays) {
  Model m = make_bar({.x = 9, .y = 5, .z = 4});
  ASSERT_TRUE(cpu_reference::make_slices(m).is_compact()) << "an entry takes 4 bytes";
  const double entries = entries_of(m);
  const double region = 8 + 4 + 16 + 16 + entries, blend = 16 + 2 + 8 + 8 + entries;
  // The velocity, read and written: 4 floats each.
  EXPECT_DOUBLE_EQ(cpu_reference::substep_bytes(m, 1), 4.0 * (region + blend + 4 + 4));
  m.stiffness.assign(m.vertex_count, 1.0f);
  // y, the previous iterate, read and written, and the goal: 4 floats each; the response.
  const double each = 4.0 * (region + blend + 4 + 8 + 4) + sizeof(shader::Response);
  EXPECT_DOUBLE_EQ(cpu_reference::substep_bytes(m, 1), each);
  EXPECT_DOUBLE_EQ(cpu_reference::substep_bytes(m, 7), 7.0 * each);
}

}  // namespace
}  // namespace fascicle::tests
