// The search for contacts against its plain form, and both against an exhaustive search: the same contacts
// and the same bits, however the body moves and whatever the search remembers.
#include "cpu_reference/solver/contact_search.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "cpu_reference/solver/contact_stages.h"
#include "cpu_reference/solver/lane_stages.h"
#include "tests/cpu_reference/plain_contact_search.h"
#include "tests/cpu_reference/two_blocks.h"

namespace fascicle::tests::contact_search_test {
namespace {

namespace cpu = cpu_reference;
using cpu::Fields;
using cpu::Place;
using cpu::SubstepInput;
using model::Model;

constexpr double step_length = 1.0 / 480.0;

// The response of a substep, in two passes or three iterations: calls over_points and over_vertices
// alternately.
template <class OverPoints, class OverVertices>
void respond(const Model& m, const OverPoints& over_points, const OverVertices& over_vertices) {
  using model::Kernel;
  for (int pass = 0; !m.is_implicit() && pass < 2; ++pass) {
    over_points(Kernel::contact_press, &cpu::contact_press);
    over_vertices(Kernel::contact, &cpu::contact);
  }
  if (!m.is_implicit()) return;
  for (int iteration = 0; iteration < 3; ++iteration) {
    over_points(Kernel::contact_hold, &cpu::contact_hold);
    over_vertices(Kernel::contact_yield, &cpu::contact_yield);
  }
  over_points(Kernel::contact_settle, &cpu::contact_settle);
  over_vertices(Kernel::contact_rest, &cpu::contact_rest);
}

void respond_plainly(const Model& m, const SubstepInput& in, Fields& fields) {
  const auto over = [&](std::uint32_t count) {
    return [&m, &in, &fields, count](model::Kernel, cpu::ModelStage stage) {
      stage(m, in, fields, {0, count});
    };
  };
  respond(m, over(static_cast<std::uint32_t>(m.contact.size())), over(m.vertex_count));
}

// The first tetrahedron that each point meets, by exhaustive search.
std::vector<std::uint32_t> found_among_all(const Model& m, Fields fields) {
  std::vector<std::uint32_t> found(m.contact.size(), shader::no_contact);
  const auto place_of = [&](std::uint32_t i) { return cpu::position_of(fields, i); };
  for (std::uint32_t p = 0; p < found.size(); ++p)
    for (std::uint32_t t = 0; t < m.contact_tetrahedron_count() && found[p] == shader::no_contact; ++t)
      if (cpu::contact_meets(m, fields, p, place_of(m.contact[p].vertex), t, place_of)) found[p] = t;
  return found;
}

bool same_bits(const float* a, const float* b, std::size_t count) {
  return std::equal(a, a + count, b, [](float x, float y) {
    return std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(y);
  });
}

// Describes the first difference; empty if there is none.
std::string contact_difference(const Model& m, const Fields& a, const Fields& b) {
  for (std::size_t p = 0; p < m.contact.size(); ++p) {
    if (a.contact_found[p] != b.contact_found[p])
      return "point " + std::to_string(p) + " is in " + std::to_string(a.contact_found[p]) + " or in " +
             std::to_string(b.contact_found[p]);
    if (a.contact_found[p] == shader::no_contact) continue;
    if (!same_bits(&a.contact_place[10 * p], &b.contact_place[10 * p], 10))
      return "the place of point " + std::to_string(p);
    if (!same_bits(&a.contact_impulse[3 * p], &b.contact_impulse[3 * p], 3))
      return "the impulse of point " + std::to_string(p);
  }
  for (std::size_t i = 0; i < m.vertex_count; ++i)
    for (const auto& [of_a, of_b, stride] : {std::tuple{&a.vertices, &b.vertices, cpu::vertex_stride},
                                             {&a.velocities, &b.velocities, cpu::vector_stride},
                                             {&a.goals, &b.goals, cpu::vector_stride}})
      if (!of_a->empty() && !same_bits(&(*of_a)[stride * i], &(*of_b)[stride * i], 3))
        return "the motion of vertex " + std::to_string(i);
  return "";
}

void put(const Model& m, const std::vector<float>& positions, const std::vector<float>& velocities,
         Fields& fields) {
  for (std::size_t i = 0; i < m.vertex_count; ++i)
    for (std::size_t a = 0; a < 3; ++a) {
      fields.vertices[cpu::vertex_stride * i + a] = positions[3 * i + a];
      fields.velocities[cpu::vector_stride * i + a] = velocities[3 * i + a];
      if (!m.is_implicit()) continue;
      const std::size_t at = cpu::vector_stride * i + a;
      fields.positions_before[at] = positions[3 * i + a] - 0.002f * velocities[3 * i + a];
      fields.velocities_before[at] = -0.5f * velocities[3 * i + a];
      fields.goals[at] = positions[3 * i + a];
    }
}

// What else happens to a body that is thrown about.
struct Fate {
  std::array<double, 3> thickness{1.0, 1.0, 1.0};  // flakes and needles, in a skew direction
  bool turns = false;  // passes through zero thickness and is inside out half of the time
  double fall = 0.0;   // gain of speed along each axis per step
};

// A body that is thrown about step by step.
class Motions {
 public:
  Motions(const TwoBlocks& blocks, unsigned seed, const Fate& fate)
      : blocks_(blocks), fate_(fate), random_(seed), along_(-1.0 + blocks.spacing) {
    bent_.resize(blocks.model.rest.size(), 0.0);
    velocities.resize(blocks.model.rest.size(), 0.0f);
  }

  std::vector<float> positions, velocities;

  void next() {
    const double s = blocks_.spacing;
    // It mostly trembles, sometimes swings, and sometimes jumps.
    const double reach = step_ % 17 == 16 ? 1.5 : step_ % 7 == 6 ? 0.4 : 0.01;
    along_ = std::clamp(along_ + reach * s * normal(), -1.0 - s, -1.0 + 2.5 * s);
    aside_ = std::clamp(aside_ + reach * s * normal(), -s, s);
    for (double& x : bent_)
      x = std::clamp(x + (step_ % 17 == 16 ? 0.1 : 0.005) * s * normal(), -0.4 * s, 0.4 * s);
    positions = blocks_.model.rest;
    for (std::size_t k = 0; k < positions.size(); ++k) {
      double x = double{positions[k]} + bent_[k];
      if (k >= 3 * std::size_t{blocks_.first_of_second}) x += k % 3 == 0 ? along_ : aside_;
      // Creates points on corners, edges and faces, coincident corners, and tetrahedra without volume.
      if (step_ % 5 == 3) x = std::round(x * 2.0 / s) * s / 2.0;
      positions[k] = static_cast<float>(x);
      velocities[k] = static_cast<float>(normal());
    }
    if (fate_.thickness != Fate{}.thickness || fate_.fall > 0.0) suffer();
    if (step_ % 11 == 4) positions[random_() % positions.size()] = std::numeric_limits<float>::quiet_NaN();
    if (step_ % 11 == 8) positions[random_() % positions.size()] = std::numeric_limits<float>::infinity();
    if (step_ % 11 == 9) velocities[random_() % positions.size()] = std::numeric_limits<float>::quiet_NaN();
    // Flat as paper.
    for (std::size_t k = 2; step_ % 13 == 7 && k < positions.size(); k += 3) positions[k] = 0.125f;
    // Vertices that coincide with others.
    for (int pair = 0; step_ % 3 == 1 && pair < 10; ++pair) {
      const std::size_t from = 3 * (random_() % blocks_.model.vertex_count),
                        to = 3 * (random_() % blocks_.model.vertex_count);
      std::copy_n(positions.begin() + static_cast<std::ptrdiff_t>(from), 3,
                  positions.begin() + static_cast<std::ptrdiff_t>(to));
    }
    ++step_;
  }

 private:
  double normal() { return normal_(random_); }

  void suffer() {
    const Eigen::Vector3d fallen = Eigen::Vector3d::Constant(0.5 * fate_.fall * step_ * step_);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
    Eigen::Vector3d thickness(fate_.thickness[0], fate_.thickness[1], fate_.thickness[2]);
    if (fate_.turns) thickness *= std::cos(0.3 * step_);
    for (std::uint32_t i = 0; i < blocks_.model.vertex_count; ++i) {
      const Eigen::Vector3d x = turn * thickness.cwiseProduct(triple_at(positions, i)) + fallen;
      for (std::size_t a = 0; a < 3; ++a) positions[3 * std::size_t{i} + a] = static_cast<float>(x[int(a)]);
    }
  }

  const TwoBlocks& blocks_;
  Fate fate_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  std::vector<double> bent_;
  double along_, aside_ = 0.0;
  int step_ = 0;
};

// Some points may meet their neighbours from the start.
void let_neighbours_meet(Model& m) {
  for (std::uint32_t p = 0; p < m.contact.size(); p += 4) {
    std::vector<std::uint32_t> near;
    for (std::uint32_t i = 0; i < m.vertex_count; ++i)
      if (i % 3 != 0 && (triple_at(m.rest, i) - triple_at(m.rest, m.contact[p].vertex)).norm() < 0.4)
        near.push_back(i);
    add_gap(m, p, near, 0.001f * static_cast<float>(p % 3));
  }
}

struct Seen {
  std::size_t contacts = 0, most = 0, changes = 0;
};

Seen expect_same_contacts(const TwoBlocks& blocks, int steps, unsigned seed, const Fate& fate = {}) {
  const Model& m = blocks.model;
  const SubstepWithTables input(m, step_length);
  const SubstepInput& in = input.in;
  struct Searching {
    Searching(const Model& m, cpu::Simd simd, unsigned threads, cpu::ContactRestMemory& memory)
        : search(m, cpu::lane_stages(simd)->contact, memory.of(m)), pool(threads) {
      size_fields(m, fields);
    }
    cpu::ContactSearch search;
    cpu::ThreadPool pool;
    Fields fields;
  };
  std::vector<std::unique_ptr<Searching>> searches;
  cpu::ContactRestMemory memory;
  for (const cpu::Simd simd : cpu::available_simd())
    if (simd != cpu::Simd::scalar)
      searches.push_back(std::make_unique<Searching>(m, simd, 1 + unsigned(searches.size()) % 3, memory));
  Motions motions(blocks, seed, fate);
  Fields plain;
  size_fields(m, plain);
  size_plain_contact_fields(m, plain);
  Seen seen;
  for (int step = 0; step < steps; ++step) {
    SCOPED_TRACE("step " + std::to_string(step));
    motions.next();
    const std::vector<std::uint32_t> before = plain.contact_found;
    put(m, motions.positions, motions.velocities, plain);
    find_plainly(m, in, plain);
    EXPECT_EQ(plain.contact_found, found_among_all(m, plain));
    respond_plainly(m, in, plain);
    for (const auto& s : searches) {
      put(m, motions.positions, motions.velocities, s->fields);
      s->search.find(s->fields, s->pool);
      const auto run = [&](model::Kernel kernel, cpu::ModelStage) {
        ASSERT_TRUE(cpu::ContactSearch::runs(kernel));
        s->search.run(kernel, in, s->fields, s->pool);
      };
      respond(m, run, run);
      EXPECT_EQ(contact_difference(m, plain, s->fields), "") << s->pool.size() << " threads";
    }
    if (testing::Test::HasFailure()) return seen;
    const auto contacts = plain.contact_found.size() -
                          static_cast<std::size_t>(std::count(plain.contact_found.begin(),
                                                              plain.contact_found.end(), shader::no_contact));
    seen.contacts += contacts;
    seen.most = std::max(seen.most, contacts);
    seen.changes += before != plain.contact_found;
  }
  return seen;
}

TEST(ContactSearch, FindsWhatThePlainKernelsFind) {
  for (unsigned seed = 0; seed < 4; ++seed)
    for (const bool implicit : {false, true}) {
      SCOPED_TRACE("seed " + std::to_string(seed) + (implicit ? ", implicit" : ", explicit"));
      TwoBlocks blocks = make_two_blocks(3, 3, 2 + seed % 2, 0.125, seed, implicit, seed % 2 == 1);
      if (seed >= 2) let_neighbours_meet(blocks.model);
      const Seen seen = expect_same_contacts(blocks, 120, seed);
      EXPECT_GT(seen.contacts, 500u);
      EXPECT_GT(seen.changes, 20u);
    }
}

// The cache is valid for models with the same inputs, and for no others.
TEST(ContactSearch, WhatIsKeptIsOfTheModelAtHand) {
  Model m = make_two_blocks(3, 3, 2, 0.125, 1).model;
  cpu::ContactRestMemory memory;
  auto is_kept = [&, before = memory.of(m)]() mutable {
    const auto now = memory.of(m);
    const cpu::ContactRest fresh(m);
    EXPECT_EQ(now->relevant, fresh.relevant);
    EXPECT_EQ(now->leaf_is_held, fresh.leaf_is_held);
    EXPECT_EQ(now->leaf_group, fresh.leaf_group);
    return std::exchange(before, now) == now;
  };
  EXPECT_TRUE(is_kept());
  for (shader::ContactPoint& point : m.contact) point.friction = 0.9f;
  for (double& mass : m.mass) mass *= 2.0;
  for (float& mobility : m.mobility) mobility *= 0.5f;
  EXPECT_TRUE(is_kept());
  m.contact[3].margin *= 1.5f;
  EXPECT_FALSE(is_kept());
  m.mobility[m.contact[0].vertex] = m.mobility[m.contact[0].vertex] > 0.0f ? 0.0f : 1.0f;
  EXPECT_FALSE(is_kept());
  ignore_some_contact(m, 1);
  EXPECT_FALSE(is_kept());
  m.rest[0] = std::nextafter(m.rest[0], 2.0f);
  EXPECT_FALSE(is_kept());
  EXPECT_TRUE(is_kept());
}

// Fewer contacts than without groups, but some.
TEST(ContactSearch, FindsNothingThatIsIgnored) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    TwoBlocks blocks =
        seed < 3 ? make_two_blocks(3, 3, 2, 0.125, seed, seed == 1) : make_two_blocks(6, 5, 5, 0.0625, seed);
    if (seed == 2) let_neighbours_meet(blocks.model);
    const int steps = seed < 3 ? 120 : 40;
    const std::size_t all = expect_same_contacts(blocks, steps, seed).contacts;
    ignore_some_contact(blocks.model, seed);
    const std::size_t some = expect_same_contacts(blocks, steps, seed).contacts;
    EXPECT_GT(some, all / 8);
    EXPECT_LT(some, 7 * all / 8);
    // Every block ignores every leaf as a whole.
    blocks.model.contact_ignored.assign(blocks.model.contact.size(), 4);
    blocks.model.contact_group.assign(blocks.model.contact_tetrahedron_count(), 6);
    add_group_depths(blocks.model);
    EXPECT_EQ(expect_same_contacts(blocks, steps, seed).contacts, 0u);
  }
}

// The planes of such tetrahedra are mostly rounding, and a hundredth of a millimetre is far on their scale.
TEST(ContactSearch, FindsThemInFlakesAndNeedles) {
  unsigned seed = 0;
  for (const double thickness : {0.1, 1e-3, 1e-4, 1e-6})
    for (const bool needle : {false, true})
      for (const bool turns : {false, true}) {
        SCOPED_TRACE(std::to_string(thickness) + (needle ? ", needle" : "") + (turns ? ", turns" : ""));
        const TwoBlocks blocks = make_two_blocks(3, 3, 2 + seed % 2, 0.125, seed);
        const Fate fate{.thickness = {1.0, thickness, needle ? thickness : 1.0}, .turns = turns};
        EXPECT_GT(expect_same_contacts(blocks, 80, seed, fate).contacts, 200u);
        ++seed;
      }
}

// At the end it moves 15 units a step, 600 from its start, where the last bit of a coordinate is 6e-5.
TEST(ContactSearch, FindsThemInABodyThatFalls) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const TwoBlocks blocks = make_two_blocks(3, 3, 2, 0.125, seed, seed % 2 == 1);
    const Fate fate{.thickness = {1.0, 1.0, seed < 2 ? 1.0 : 1e-2}, .fall = 0.19};
    EXPECT_GT(expect_same_contacts(blocks, 80, seed, fate).contacts, 200u);
  }
}

// More than one branch of leaves.
TEST(ContactSearch, FindsWhatThePlainKernelsFindInLargerBodies) {
  const TwoBlocks blocks = make_two_blocks(6, 5, 5, 0.0625, 9);
  ASSERT_GT(blocks.model.contact_branch_count(), 1u);
  EXPECT_GT(expect_same_contacts(blocks, 40, 5).most, 10u);
}

struct Touching {
  Touching() : blocks(make_two_blocks(3, 3, 3, 0.125, 4)), input(blocks.model, step_length), in(input.in) {
    size_fields(blocks.model, fields);
    size_plain_contact_fields(blocks.model, fields);
    const auto solver = cpu::make_cpu_solver(blocks.model, {}, 1);
    const model::State state = overlapping(blocks, solver->save(), 3);
    put(blocks.model, state.positions, state.velocities, fields);
    find_plainly(blocks.model, in, fields);
    found = fields;
    respond_plainly(blocks.model, in, fields);
  }
  TwoBlocks blocks;
  SubstepWithTables input;
  const SubstepInput& in;
  Fields found, fields;  // before the response and after it
};

// The controls: one missing contact, and one changed bit, are detected.
TEST(ContactSearch, ADroppedContactWouldBeSeen) {
  const Touching t;
  Fields dropped = t.fields;
  const auto found = std::find_if(dropped.contact_found.begin(), dropped.contact_found.end(),
                                  [](std::uint32_t at) { return at != shader::no_contact; });
  ASSERT_NE(found, dropped.contact_found.end());
  EXPECT_EQ(contact_difference(t.blocks.model, t.fields, dropped), "");
  *found = shader::no_contact;
  EXPECT_NE(contact_difference(t.blocks.model, t.fields, dropped), "");
  Fields bent = t.fields;
  const auto moved =
      std::find_if(bent.velocities.begin(), bent.velocities.end(), [](float x) { return x != 0.0f; });
  *moved = std::nextafter(*moved, 2.0f * *moved);
  EXPECT_NE(contact_difference(t.blocks.model, t.fields, bent), "");
}

// The response to the contacts found, summed in the same order for all vertices: first the own contact, then
// by tetrahedron, then by point; or all of it backwards.
Fields added_up(const Touching& t, bool backwards) {
  const Model& m = t.blocks.model;
  Fields fields = t.found;
  for (int pass = 0; pass < 2; ++pass) {
    contact_press(m, t.in, fields, {0, static_cast<std::uint32_t>(m.contact.size())});
    for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
      std::vector<Place> terms;
      const auto impulse_of = [&](std::uint32_t p) {
        return cpu::place_at(&fields.contact_impulse[3 * std::size_t{p}]);
      };
      for (std::uint32_t p = 0; p < m.contact.size(); ++p)
        if (m.contact[p].vertex == i && fields.contact_found[p] != shader::no_contact)
          terms.push_back(impulse_of(p));
      for (std::uint32_t tetrahedron = 0; tetrahedron < m.contact_tetrahedron_count(); ++tetrahedron)
        for (std::uint32_t p = 0; p < m.contact.size(); ++p)
          for (std::size_t k = 0; k < 4; ++k)
            if (fields.contact_found[p] == tetrahedron && cpu::corners_of(m, tetrahedron)[k] == i)
              terms.push_back(kernel::scaled_vector<float>(-fields.contact_place[10 * std::size_t{p} + k],
                                                           impulse_of(p)));
      if (backwards) std::reverse(terms.begin(), terms.end());
      Place sum{0.0f, 0.0f, 0.0f};
      for (std::size_t k = 0; k < terms.size(); ++k)
        sum = k == 0 ? terms[k] : kernel::vector_sum<float>(sum, terms[k]);
      if (!terms.empty()) cpu::contact_apply(m, t.in, fields, i, sum);
    }
  }
  return fields;
}

TEST(ContactSearch, AnotherOrderOfSummationWouldBeSeen) {
  const Touching t;
  EXPECT_EQ(contact_difference(t.blocks.model, t.fields, added_up(t, false)), "");
  EXPECT_NE(contact_difference(t.blocks.model, t.fields, added_up(t, true)), "");
}

}  // namespace
}  // namespace fascicle::tests::contact_search_test
