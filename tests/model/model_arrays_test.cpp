// The table of a model's members is complete and in the struct's order, and the checks that follow from it
// work.
#include "host/model/model_arrays.h"

#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/contact_models.h"
#include "tests/support/limit_models.h"
#include "tests/support/sliding_models.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {
namespace {

using model::Model;

// The compile-time check of Model, applied to a struct with rows for all members and with one row missing at
// the beginning, in the middle and at the end.
struct Three {
  bool first = false;
  bool second = false;
  std::vector<float> array;
};
using model::FieldRow;
constexpr std::tuple all_three{FieldRow{"first", &Three::first}, FieldRow{"second", &Three::second},
                               FieldRow{"array", &Three::array}};
constexpr std::tuple none_for_the_last{FieldRow{"first", &Three::first}, FieldRow{"second", &Three::second}};
constexpr std::tuple none_for_the_second{FieldRow{"first", &Three::first}, FieldRow{"array", &Three::array}};
constexpr std::tuple two_alike{FieldRow{"first", &Three::first}, FieldRow{"first", &Three::second}};
static_assert(base::has_row_for_each_member<Three, decltype(all_three)>);
static_assert(!base::has_row_for_each_member<Three, decltype(none_for_the_last)>);
static_assert(!base::has_row_for_each_member<Three, decltype(none_for_the_second)>);
static_assert(base::has_distinct_names(all_three) && !base::has_distinct_names(two_alike));
static_assert(base::row_of(all_three, &Three::array) == 2 && base::row_of(two_alike, &Three::array) == 2);

// As there are as many rows as members, strictly ascending offsets mean that none is missing or repeated.
TEST(ModelArrays, RowsAreInTheOrderOfTheStruct) {
  const Model m;
  std::ptrdiff_t before = -1;
  base::for_each_row(model::model_arrays, [&](const auto& row) {
    const std::ptrdiff_t place =
        reinterpret_cast<const std::byte*>(&(m.*row.member)) - reinterpret_cast<const std::byte*>(&m);
    EXPECT_GT(place, before) << row.name;
    before = place;
  });
}

// In a model with ties, limits, contact and colliders, one entry too many is detected in each array.
TEST(ModelArrays, EveryArraysSizeIsChecked) {
  Model good = make_implicit(make_model(kuhn_bar(3, 2, 2, 0.25)), 1e4);
  add_sliding(good, [](const Eigen::Vector3d& p) { return p.y() > 0.4; });
  add_limits(good, 0.3);
  add_contact(good, 0.1, depth_below_boundary(good));
  good.collider_count = 3;
  good.spared.assign(good.vertex_count, 5);
  ASSERT_NO_THROW(model::check_model(good));
  int checked = 0;
  base::for_each_row(model::model_arrays, [&](const auto& row) {
    if constexpr (model::is_array_row<std::decay_t<decltype(row)>>) {
      Model changed = good;
      (changed.*row.member).emplace_back();
      if (!row.traits.items.count && row.traits.items.each == 1) return;  // any number
      ++checked;
      try {
        model::check_model(changed);
        ADD_FAILURE() << row.name << " has an entry too many, and check_model accepts it";
      } catch (const std::invalid_argument&) {
      }
    }
  });
  EXPECT_GT(checked, 30);
}

// No two arrays share a buffer of the GPU.
TEST(ModelArrays, BuffersAreDistinct) {
  std::vector<bool> taken(shader::buffer_count);
  base::for_each_row(model::model_arrays, [&](const auto& row) {
    if constexpr (model::is_array_row<std::decay_t<decltype(row)>>) {
      const std::uint32_t number = row.traits.buffer.number;
      if (number == model::no_buffer) return;
      ASSERT_LT(number, shader::buffer_count) << row.name;
      EXPECT_FALSE(taken[number]) << row.name;
      EXPECT_EQ(row.traits.needed, model::Needed::by_solvers) << row.name;
      taken[number] = true;
    }
  });
}

}  // namespace
}  // namespace fascicle::tests
