// check_model finds every broken promise; validation finds a planted difference and locates it.
#include "host/model/model.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/model/validate.h"
#include "tests/support/contact_models.h"
#include "tests/support/limit_models.h"
#include "tests/support/sliding_models.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {

namespace {

using model::check_model;
using model::Model;

TEST(CheckModel, AcceptsGoodModels) {
  EXPECT_NO_THROW(check_model(make_model(kuhn_bar(3, 2, 2, 0.25))));
  for (unsigned seed = 0; seed < 20; ++seed) EXPECT_NO_THROW(check_model(random_model(seed))) << seed;
}

TEST(CheckModel, AcceptsTheSmallestFactorsThatAreNotZero) {
  Model model = make_model(kuhn_bar(3, 2, 2, 0.25));
  model.alpha[2] = model::least_factor;
  model.pull[3] = model::least_factor;
  model.pull[4] = 0.0f;
  EXPECT_NO_THROW(check_model(model));
}

TEST(Factor, BelowTheLeastIsZero) {
  for (const double sign : {1.0, -1.0}) {
    EXPECT_EQ(model::as_factor(0.0), 0.0f);
    EXPECT_EQ(model::as_factor(sign * 0x1p-40), sign * 0x1p-40);
    EXPECT_EQ(model::as_factor(sign * 0x1.fffffep-41), 0.0f);
    EXPECT_EQ(model::as_factor(sign * 1e-42), 0.0f);
    EXPECT_EQ(model::as_factor(sign * 0.75), sign * 0.75);
  }
}

// The upper half slides.
Model& tie_down(Model& model) {
  add_sliding(model, [](const Eigen::Vector3d& p) { return p.y() > 0.4; });
  return model;
}

Model& limited(Model& model) {
  model = make_implicit(model, 1e4);
  add_limits(model, 0.3);
  return model;
}

// The first point has two vertices across a gap.
Model& touching(Model& model) {
  add_contact(model, 0.1, depth_below_boundary(model));
  add_gap(model, 0, {3, 5}, 0.25f);
  return model;
}

TEST(CheckModel, AcceptsContact) {
  Model model = make_model(kuhn_bar(3, 2, 2, 0.25));
  EXPECT_NO_THROW(check_model(touching(model)));
  add_gap(model, 4, {0, 1, 2}, 0.0f);
  EXPECT_NO_THROW(check_model(model));
  ignore_some_contact(model, 1);
  EXPECT_NO_THROW(check_model(model));
  EXPECT_NO_THROW(check_model(without_contact(model)));
}

// The arrays, and the sizes of the fields written by hand, per point, vertex, leaf, branch and tetrahedron.
TEST(SolverBytes, CountContact) {
  Model model = make_model(kuhn_bar(3, 2, 2, 0.25));
  const std::uint64_t without = solver_bytes(touching(model)) - solver_bytes(without_contact(model));
  const std::uint64_t arrays =
      sizeof(float) *
          (2 * model.contact_near.size() + model.contact_tetrahedron.size() + model.contact_depth.size() +
           model.contact_number.size() + model.contact_offset.size() + model.contact_entry.size() +
           model.contact_rest_box.size() + model.mobility.size()) +
      sizeof(shader::ContactPoint) * model.contact.size();
  const std::uint64_t fields =
      sizeof(float) * (15 * model.contact.size() + 4 * std::uint64_t{model.vertex_count} +
                       6 * std::uint64_t{model.contact_leaf_count()} +
                       6 * std::uint64_t{model.contact_branch_count()} + model.contact_tetrahedron_count());
  EXPECT_EQ(without, arrays + fields);
}

TEST(CheckModel, AcceptsColliders) {
  Model model = make_model(kuhn_bar(3, 2, 2, 0.25));
  for (const std::uint32_t count : {1u, model::most_colliders}) {
    model.collider_count = count;
    model.spared.assign(model.vertex_count, 0x80000001u);
    EXPECT_NO_THROW(check_model(model)) << count;
  }
}

TEST(CheckModel, NamesTheArrayThatBreaksItsPromise) {
  using Change = void (*)(Model&);
  const std::pair<const char*, Change> changes[] = {
      {"unit", [](Model& m) { m.unit = 0.3; }},
      {"rest_origin", [](Model& m) { m.rest_origin[1] = std::numeric_limits<double>::quiet_NaN(); }},
      {"rest_origin", [](Model& m) { m.rest_origin[2] = std::numeric_limits<double>::infinity(); }},
      {"layer.damping", [](Model& m) { m.layers[0].damping = std::numeric_limits<double>::quiet_NaN(); }},
      {"layer.damping", [](Model& m) { m.layers[0].damping = std::numeric_limits<double>::infinity(); }},
      {"layer.damping", [](Model& m) { m.layers[0].damping = -0.5; }},
      {"rest", [](Model& m) { m.rest[5] = std::numeric_limits<float>::quiet_NaN(); }},
      {"rest", [](Model& m) { m.rest.pop_back(); }},
      {"mass", [](Model& m) { m.mass[1] = 0.0; }},
      {"alpha", [](Model& m) { m.alpha[2] = -0.1f; }},
      {"alpha", [](Model& m) { m.alpha[2] = 0x1.fffffep-41f; }},
      {"beta", [](Model& m) { m.beta[0] = 1.5f; }},
      {"tag", [](Model& m) { m.tag[0] = 7; }},
      {"ring_offset", [](Model& m) { m.ring_offset[1] = 1000000; }},
      {"ring", [](Model& m) { m.ring[0] = 0; }},
      {"ring", [](Model& m) { std::swap(m.ring[0], m.ring[1]); }},
      {"share_given", [](Model& m) { m.share_given[0] += 0x1p-16f; }},
      {"share_given", [](Model& m) { m.share_given[0] = m.share_taken[0] = 0.3f; }},
      {"pull", [](Model& m) { m.pull[0] = -1.0f; }},
      {"pull", [](Model& m) { m.pull[0] = 1e-40f; }},
      {"region_rest", [](Model& m) { m.region_rest[3] = std::numeric_limits<float>::infinity(); }},
      {"region_muscle",
       [](Model& m) {
         m.region_muscle.push_back({0, 1.0f, 0.0f});
       }},
      {"muscle_offset", [](Model& m) { m.muscle_count = 1; }},
      {"volume_gain", [](Model& m) { m.region_volume.assign(3 * m.vertex_count, 1.0f); }},
      {"region_volume", [](Model& m) { m.volume_gain.assign(m.vertex_count, 1.0f); }},
      {"volume_gain",
       [](Model& m) {
         add_volume(m, 1.0f);
         m.volume_gain[3] = -1.0f;
       }},
      {"region_volume",
       [](Model& m) {
         add_volume(m, 1.0f);
         m.region_volume[4] = 0.0f;
       }},
      {"tie", [](Model& m) { tie_down(m).tie[0].corner_b = m.vertex_count; }},
      {"tie",
       [](Model& m) {
         tie_down(m);
         m.tie[0].corner_b = m.tie[0].sliding;
       }},
      {"tie", [](Model& m) { tie_down(m).tie[0].mobility_a = 1e-42f; }},
      {"tie", [](Model& m) { tie_down(m).tie[0].rest_height = 0.0f; }},
      {"tie_offset", [](Model& m) { tie_down(m).tie_offset.pop_back(); }},
      {"tie_index", [](Model& m) { tie_down(m).tie_index[0] = 1000; }},
      {"tie_index", [](Model& m) { make_kinematic(m, tie_down(m).tie[0].sliding); }},
      {"tie_coefficient", [](Model& m) { tie_down(m).tie_coefficient[0] *= -1.0f; }},
      {"tie_coefficient", [](Model& m) { tie_down(m).tie_coefficient.back() = 1e-42f; }},
      {"tie_index", [](Model& m) { m.tie_index.push_back(0); }},
      {"limit", [](Model& m) { add_limits(m, 0.3); }},  // on an explicit model
      {"limit_offset", [](Model& m) { limited(m).limit_offset.pop_back(); }},
      {"limit_entry", [](Model& m) { ++limited(m).limit_entry[0]; }},
      {"limit_entry", [](Model& m) { m.limit_entry.push_back(0); }},
      {"limit", [](Model& m) { limited(m).limit[0].corner_b = m.vertex_count; }},
      {"limit", [](Model& m) { limited(m).limit[0].least = 0.0f; }},
      {"limit", [](Model& m) { limited(m).limit[0].size = 0.75f; }},
      {"mobility", [](Model& m) { limited(m).mobility[0] = 0.0f; }},
      {"mobility", [](Model& m) { m.mobility.push_back(1.0f); }},
      {"mobility", [](Model& m) { touching(m).mobility.clear(); }},
      {"mobility", [](Model& m) { touching(m).mobility[2] = 0.0f; }},
      {"mobility",
       [](Model& m) {
         touching(m);
         make_kinematic(m, 2);
       }},
      {"contact", [](Model& m) { touching(m).contact[1].vertex = m.vertex_count; }},
      {"contact", [](Model& m) {
 touching(m);
 std::swap(m.contact[1].vertex, m.contact[2].vertex);
 }},
      {"contact",
       [](Model& m) {
         touching(m);
         std::swap(m.contact[1].vertex, m.contact[2].vertex);
         std::swap(m.contact_number[m.contact[1].vertex], m.contact_number[m.contact[2].vertex]);
       }},
      {"contact", [](Model& m) { touching(m).contact[1].margin = 0.0f; }},
      {"contact", [](Model& m) { touching(m).contact[1].margin = 1e-40f; }},
      {"contact", [](Model& m) { touching(m).contact[1].allowance = -0.5f; }},
      {"contact",
       [](Model& m) { touching(m).contact[1].friction = std::numeric_limits<float>::quiet_NaN(); }},
      {"contact",
       [](Model& m) { touching(m).contact[1].friction = std::numeric_limits<float>::infinity(); }},
      {"contact", [](Model& m) { touching(m).contact[1].first_near = 1; }},
      {"contact", [](Model& m) { touching(m).contact[1].near_count = 1; }},
      {"contact_near", [](Model& m) { touching(m).contact_near.push_back({7, 8}); }},
      {"contact_near", [](Model& m) { touching(m).contact_near[0].end = 3; }},
      {"contact_near", [](Model& m) { touching(m).contact_near[0] = {5, 6}; }},
      {"contact_near", [](Model& m) { touching(m).contact_near[0].end = 5; }},
      {"contact_near", [](Model& m) { touching(m).contact_near[1].end = m.vertex_count + 1; }},
      {"contact_near", [](Model& m) { m.contact_near.push_back({0, 1}); }},
      {"contact_tetrahedron", [](Model& m) { touching(m).contact_tetrahedron.pop_back(); }},
      {"contact_tetrahedron", [](Model& m) { touching(m).contact_tetrahedron[5] = m.vertex_count; }},
      {"contact_ignored",
       [](Model& m) {
         ignore_some_contact(touching(m), 1);
         m.contact_ignored.pop_back();
       }},
      {"contact_ignored",
       [](Model& m) {
         ignore_some_contact(touching(m), 1);
         m.contact_ignored[2] = 8;
       }},
      {"contact_ignored", [](Model& m) { m.contact_ignored.push_back(1); }},
      {"contact_group",
       [](Model& m) {
         ignore_some_contact(touching(m), 1);
         m.contact_group.clear();
         add_group_depths(m);
       }},
      {"contact_group",
       [](Model& m) {
         touching(m).contact_group.assign(m.contact_tetrahedron_count(), 1);
         add_group_depths(m);
       }},
      {"contact_depth",
       [](Model& m) {
         ignore_some_contact(touching(m), 1);
         m.contact_depth.resize(m.vertex_count);
       }},
      {"contact_depth", [](Model& m) { touching(m).contact_depth[1] = -0.5f; }},
      {"contact_depth", [](Model& m) { touching(m).contact_depth.pop_back(); }},
      {"contact_number",
       [](Model& m) {
         touching(m);
         // Interior vertices have no contact point, and no point's number is free for them.
         for (std::uint32_t& number : m.contact_number)
           if (number == shader::no_contact) number = 0;
       }},
      {"contact_number",
       [](Model& m) {
         touching(m);
         for (std::uint32_t& number : m.contact_number)
           if (number == shader::no_contact) number = std::uint32_t(m.contact.size());
       }},
      {"contact_offset", [](Model& m) { touching(m).contact_offset[1] = 100000; }},
      {"contact_entry", [](Model& m) {
 touching(m);
 std::swap(m.contact_entry[0], m.contact_entry[1]);
 }},
      {"contact_entry", [](Model& m) {
 touching(m);
 m.contact_entry[0] = m.contact_entry.back();
 }},
      {"contact_entry", [](Model& m) { touching(m).contact_entry.push_back(0); }},
      {"contact_rest_box", [](Model& m) {
 touching(m);
 std::swap(m.contact_rest_box[1], m.contact_rest_box[5]);
 }},
      {"contact_rest_box", [](Model& m) { touching(m).contact_rest_box.pop_back(); }},
      {"contact_rest_box", [](Model& m) { touching(m).contact_rest_box[0] += 0.125f; }},
      {"contact_rest_box",
       [](Model& m) {
         touching(m);
         m.contact_rest_box[8 * std::size_t{m.contact_leaf_count()} + 5] -= 0.125f;
       }},
      {"contact_rest_box",
       [](Model& m) { touching(m).contact_rest_box[2] = std::numeric_limits<float>::quiet_NaN(); }},
      {"spared", [](Model& m) { m.collider_count = 1; }},
      {"spared", [](Model& m) { m.spared.assign(m.vertex_count, 0); }},  // without colliders
      {"spared",
       [](Model& m) {
         m.collider_count = 2;
         m.spared.assign(m.vertex_count + 1, 0);
       }},
      {"collider_count",
       [](Model& m) {
         m.collider_count = model::most_colliders + 1;
         m.spared.assign(m.vertex_count, 0);
       }},
      {"joint_count", [](Model& m) { m.joint_count = (1u << 20u) + 1; }},
      {"muscle_count", [](Model& m) { m.muscle_count = (1u << 20u) + 1; }},
      {"force_count", [](Model& m) { m.force_count = (1u << 20u) + 1; }},
      {"skin_joint", [](Model& m) { m.skin_joint.push_back(0); }},
      {"force_index", [](Model& m) { m.force_index.push_back(0); }},
      {"surface_vertex", [](Model& m) { m.surface_vertex[0] = m.vertex_count; }},
      {"tetrahedron", [](Model& m) { m.tetrahedron[0] = m.vertex_count; }},
      {"layers", [](Model& m) { m.layers.clear(); }},
  };
  const Model good = make_model(kuhn_bar(3, 2, 2, 0.25));
  for (const auto& [array, change] : changes) {
    Model model = good;
    change(model);
    try {
      check_model(model);
      ADD_FAILURE() << array << ": not found";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(array), std::string::npos) << array << ": " << error.what();
    }
  }
}

TEST(UlpDistance, CountsRepresentableFloats) {
  EXPECT_EQ(model::ulp_distance(1.0f, 1.0f), 0u);
  EXPECT_EQ(model::ulp_distance(1.0f, std::nextafter(1.0f, 2.0f)), 1u);
  EXPECT_EQ(model::ulp_distance(-0.0f, 0.0f), 1u);
  EXPECT_EQ(model::ulp_distance(std::nextafter(0.0f, -1.0f), std::nextafter(0.0f, 1.0f)), 3u);
  EXPECT_EQ(model::ulp_distance(std::numeric_limits<float>::quiet_NaN(), 1.0f),
            std::numeric_limits<std::uint64_t>::max());
}

// Changes one value of one stage by one ULP, only in the probe's copy.
class Planted : public model::Solver {
 public:
  Planted(std::unique_ptr<model::Solver> solver, model::Where where, std::size_t index)
      : solver_(std::move(solver)), where_(where), index_(index) {}
  void submit(const model::Drive& drive, model::Read what, model::Probe* probe) override {
    struct Bend : model::Probe {
      void on_stage(const model::Where& where, std::span<const float> values) override {
        std::vector<float> bent(values.begin(), values.end());
        if (where.frame == at.frame && where.substep == at.substep && where.stage == at.stage)
          bent[index] = std::nextafter(bent[index], 2.0f);
        next->on_stage(where, bent);
      }
      model::Probe* next = nullptr;
      model::Where at;
      std::size_t index = 0;
    } bend;
    bend.next = probe;
    bend.at = where_;
    bend.index = index_;
    solver_->submit(drive, what, probe ? &bend : nullptr);
  }
  model::Frame collect() override { return solver_->collect(); }
  model::State save() const override { return solver_->save(); }
  void load(const model::State& state) override { solver_->load(state); }

 private:
  std::unique_ptr<model::Solver> solver_;
  model::Where where_;
  std::size_t index_;
};

TEST(FirstDifference, NamesThePlaceOfAPlantedOne) {
  const Model model = random_model(1);
  TestDrive drive = quiet_drive(model, 1.0 / 240.0, 2, {0, -9.81, 0});
  const auto drives = [&](std::uint64_t) { return drive.get(); };
  const auto same_a = cpu_reference::make_cpu_solver(model, {}, 1),
             same_b = cpu_reference::make_cpu_solver(model, {}, 2);
  EXPECT_FALSE(model::first_difference(*same_a, *same_b, drives, 5).has_value());

  for (const model::Stage stage :
       {model::Stage::predict, model::Stage::region, model::Stage::goal, model::Stage::integrate}) {
    const auto plain = cpu_reference::make_cpu_solver(model, {}, 1);
    const std::uint32_t width = model::stage_width(stage);
    Planted planted(cpu_reference::make_cpu_solver(model, {}, 1), {3, 1, stage}, 4 * width + 1);
    const auto difference = model::first_difference(*plain, planted, drives, 5);
    ASSERT_TRUE(difference.has_value());
    EXPECT_EQ(difference->where.frame, 3u);
    EXPECT_EQ(difference->where.substep, 1u);
    EXPECT_EQ(difference->where.stage, stage);
    EXPECT_EQ(difference->item, 4u);
    EXPECT_EQ(difference->component, 1u);
    EXPECT_EQ(difference->ulp, 1u);
  }
}

TEST(PositionHash, SeesOneBit) {
  model::Frame frame;
  frame.positions = {1.0f, 2.0f, 3.0f};
  const std::uint64_t before = model::position_hash(frame);
  frame.positions[1] = std::nextafter(2.0f, 3.0f);
  EXPECT_NE(model::position_hash(frame), before);
}

}  // namespace

}  // namespace fascicle::tests
