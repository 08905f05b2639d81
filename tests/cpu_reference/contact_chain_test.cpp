// Contact chains: on a GPU points join a tetrahedron's chain in any order, and no result may depend on it.
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "cpu_reference/solver/contact_stages.h"
#include "cpu_reference/solver/fields.h"
#include "tests/cpu_reference/plain_contact_search.h"
#include "tests/cpu_reference/two_blocks.h"

namespace fascicle::tests {
namespace {

using cpu_reference::Fields;
using model::Model;

// Two blocks; the second is shrunk into a tetrahedron in the middle of the first, so it contains many points.
struct ChainCase {
  ChainCase() : blocks(make_two_blocks(4, 4, 4, 0.125, 4)), input(blocks.model, 1.0 / 600.0) {
    const Model& m = blocks.model;
    size_fields(m, found);
    size_plain_contact_fields(m, found);
    const model::State state = cpu_reference::make_cpu_solver(m, {}, 1)->save();
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    const std::size_t first = 3 * std::size_t{blocks.first_of_second}, middle = first / 2;
    for (std::size_t k = 0; k < state.positions.size(); ++k) {
      const std::size_t i = k / 3, axis = k % 3;
      const float at_middle = state.positions[middle / 3 * 3 + axis] + 0.01f;
      found.vertices[cpu_reference::vertex_stride * i + axis] =
          k < first ? state.positions[k] : at_middle + 0.001f * normal(random);
      found.velocities[cpu_reference::vector_stride * i + axis] = normal(random);
    }
    find_plainly(m, input.in, found);
  }

  // The response if the points join their chains in this order.
  Fields joined(const std::vector<std::uint32_t>& order) const {
    const Model& m = blocks.model;
    Fields fields = found;
    std::fill(fields.contact_first.begin(), fields.contact_first.end(), shader::no_contact);
    for (const std::uint32_t p : order) contact_chain(m, input.in, fields, {p, p + 1});
    contact_crowd(m, input.in, fields, {0, m.vertex_count});
    contact_press(m, input.in, fields, {0, static_cast<std::uint32_t>(m.contact.size())});
    contact(m, input.in, fields, {0, m.vertex_count});
    return fields;
  }

  std::uint32_t longest_chain() const {
    std::vector<std::uint32_t> count(blocks.model.contact_tetrahedron_count(), 0);
    for (const std::uint32_t t : found.contact_found)
      if (t < count.size()) ++count[t];
    return *std::max_element(count.begin(), count.end());
  }

  TwoBlocks blocks;
  SubstepWithTables input;
  Fields found;
};

bool same_numbers(const cpu_reference::Floats& a, const cpu_reference::Floats& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

TEST(ContactChain, NoResultDependsOnTheOrderInIt) {
  const ChainCase c;
  ASSERT_GE(c.longest_chain(), 3u) << "no chain is long enough for its order to matter";
  std::vector<std::uint32_t> order(c.blocks.model.contact.size());
  std::iota(order.begin(), order.end(), 0U);
  const Fields ascending = c.joined(order);
  EXPECT_FALSE(same_numbers(ascending.velocities, c.found.velocities)) << "no contact pushes";
  std::mt19937 random(5);
  for (int k = 0; k < 5; ++k) {
    std::shuffle(order.begin(), order.end(), random);
    const Fields shuffled = c.joined(order);
    EXPECT_NE(shuffled.contact_next, ascending.contact_next) << "the chains are the same";
    EXPECT_EQ(shuffled.contact_crowd, ascending.contact_crowd);
    EXPECT_TRUE(same_numbers(shuffled.velocities, ascending.velocities));
    EXPECT_TRUE(same_numbers(shuffled.vertices, ascending.vertices));
  }
}

// The control: a point missing from its chain is detected.
TEST(ContactChain, APointThatIsLeftOutIsMissed) {
  const ChainCase c;
  std::vector<std::uint32_t> order(c.blocks.model.contact.size());
  std::iota(order.begin(), order.end(), 0U);
  const Fields whole = c.joined(order);
  const auto one = std::find_if(order.begin(), order.end(), [&](std::uint32_t p) {
    return c.found.contact_found[p] != shader::no_contact;
  });
  ASSERT_NE(one, order.end());
  order.erase(one);
  EXPECT_NE(c.joined(order).contact_crowd, whole.contact_crowd);
}

}  // namespace
}  // namespace fascicle::tests
