// Painted attributes of glTF's vertices: what is carried, and what is noted or refused.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/rig/character.h"
#include "tests/gltf/gltf_builder.h"
#include "tests/gltf/gltf_read.h"

namespace fascicle::tests::gltf_test {
namespace {

using Eigen::Vector3d;
using nlohmann::json;
using rig::Character;

// Paint that does nothing because of its name or kind is said.
TEST(Gltf, unused_paint_is_noted) {
  const auto notes_of = [](const std::string& name, const std::string& type, std::size_t width) {
    GltfBuilder b = column();
    b.document["meshes"][0]["primitives"][0]["attributes"][name] =
        b.add<float>(type, std::vector<float>(12 * width, 1.0f));
    const Character c = read(b);
    return c.notes.empty() ? std::string() : c.notes.back();
  };
  const std::string unused = " is not used unless a scene file names it; did you mean ";
  EXPECT_EQ(notes_of("_layer", "SCALAR", 1), "the attribute `_layer`" + unused + "_LAYER?");
  EXPECT_EQ(notes_of("_LAYERS", "SCALAR", 1), "the attribute `_LAYERS`" + unused + "_LAYER?");
  EXPECT_EQ(notes_of("_STIFFNESS", "VEC4", 4),
            "the attribute `_STIFFNESS` has 4 numbers a vertex instead of 1, and is not used");
  // The controls: what acts, and names of one's own.
  for (const char* name : {"_LAYER", "_STIFFNESS", "_RIGID", "_BATCHID", "_muscle_mask"})
    EXPECT_EQ(notes_of(name, "SCALAR", 1), "");
}

// Exporters write colours with alpha on one mesh and without on another.
TEST(Gltf, paint_takes_the_larger_width) {
  GltfBuilder b = column();
  b.document["meshes"][0]["primitives"].push_back(b.document["meshes"][0]["primitives"][0]);
  b.document["meshes"][0]["primitives"].push_back(b.document["meshes"][0]["primitives"][0]);
  json& primitives = b.document["meshes"][0]["primitives"];
  const auto add = [&](const char* type, std::size_t width) {
    return b.add<float>(type, std::vector<float>(12 * width, 0.25f));
  };
  primitives[0]["attributes"]["COLOR_0"] = add("VEC3", 3);
  primitives[0]["attributes"]["_WIND"] = add("VEC4", 4);
  primitives[1]["attributes"]["COLOR_0"] = add("VEC4", 4);
  primitives[1]["attributes"]["_WIND"] = add("VEC3", 3);
  primitives[2]["attributes"]["COLOR_0"] = add("VEC3", 3);
  const Character c = read(b);
  ASSERT_EQ(c.painted.size(), 2u);
  for (const rig::PaintedAttribute& a : c.painted) {
    ASSERT_EQ(a.width, 4u) << a.name;
    ASSERT_EQ(a.values.size(), 4u * 36) << a.name;
    for (std::size_t i = 0; i < a.values.size(); ++i) {
      const std::size_t vertex = i / 4, component = i % 4;
      double expected = 0.25;
      if (a.name == "COLOR_0" && component == 3 && vertex / 12 != 1) expected = 1.0;  // opaque
      if (a.name == "_WIND" && (vertex >= 24 || (vertex >= 12 && component == 3))) expected = 0.0;
      EXPECT_EQ(a.values[i], expected) << a.name << " " << i;
    }
  }
}

// The other kinds act by themselves: there a padded number would mean something else.
TEST(Gltf, paint_that_acts_must_have_one_width) {
  GltfBuilder b = column();
  b.document["meshes"][0]["primitives"].push_back(b.document["meshes"][0]["primitives"][0]);
  json& primitives = b.document["meshes"][0]["primitives"];
  primitives[0]["attributes"]["_LAYER"] = b.add<float>("SCALAR", std::vector<float>(12, 1.0f));
  primitives[1]["attributes"]["_LAYER"] = b.add<float>("VEC3", std::vector<float>(36, 1.0f));
  try {
    read(b);
    ADD_FAILURE() << "was read";
  } catch (const base::SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("attributes/_LAYER: has 3 numbers a vertex, and 1 on another"),
              std::string::npos)
        << error.what();
  }
}

TEST(Gltf, too_much_paint_is_left_out_and_named) {
  GltfBuilder b = column();
  json& attributes = b.document["meshes"][0]["primitives"][0]["attributes"];
  const std::size_t values = b.add<float>("SCALAR", std::vector<float>(12, 1.0f));
  for (char letter = 'A'; letter <= 'R'; ++letter) attributes[std::string("_BAG_") + letter] = values;
  attributes["_RIGID"] = values;
  const Character c = read(b);
  EXPECT_EQ(c.painted.size(), 17u);
  EXPECT_TRUE(
      std::any_of(c.painted.begin(), c.painted.end(), [](const auto& a) { return a.name == "_RIGID"; }));
  ASSERT_FALSE(c.notes.empty());
  EXPECT_EQ(
      c.notes[0],
      "the attribute `_BAG_Q` and 1 more are not read: a character has at most 16 besides those that act by "
      "themselves");
}

// The column's raw units are centimetres with Z up: a fibre along z is along y in the bind pose.
TEST(Gltf, painted_attributes_are_carried) {
  GltfBuilder b = column();
  std::vector<float> layer, stiffness, fibre;
  std::vector<std::uint8_t> colour;
  for (int i = 0; i < 12; ++i) {
    layer.push_back(static_cast<float>(i % 4));
    stiffness.push_back(static_cast<float>(i % 4) / 4.0f);
    fibre.insert(fibre.end(), {0.0f, 0.0f, i < 6 ? 2.0f : 0.0f});
    colour.insert(colour.end(), {static_cast<std::uint8_t>(51 * (i % 6)), 0, 255, 255});
  }
  json primitive = b.document["meshes"][0]["primitives"][0];
  json& attributes = b.document["meshes"][0]["primitives"][0]["attributes"];
  attributes["_LAYER"] = b.add<float>("SCALAR", layer);
  attributes["_STIFFNESS"] = b.add<float>("SCALAR", stiffness);
  attributes["_FIBER"] = b.add<float>("VEC3", fibre);
  attributes["COLOR_0"] = b.add<std::uint8_t>("VEC4", colour, {{"normalized", true}});
  attributes["TEXCOORD_0"] = 12345;  // not needed, so ignored
  // Two without paint, one before it and one after it.
  b.document["meshes"][0]["primitives"].push_back(primitive);
  b.document["meshes"][0]["primitives"].insert(b.document["meshes"][0]["primitives"].begin(), primitive);
  const Character c = read(b);
  ASSERT_EQ(c.surface.vertices.size(), 36u);
  ASSERT_EQ(c.painted.size(), 4u);
  for (const rig::PaintedAttribute& a : c.painted) {
    ASSERT_EQ(a.values.size(), 36u * a.width) << a.name;
    for (std::size_t i = 0; i < a.values.size(); ++i) {
      // Unpainted flesh is as stiff as its layer.
      if (i / a.width / 12 != 1) {
        EXPECT_EQ(a.values[i], a.name == "_STIFFNESS" ? 1.0 : 0.0) << a.name;
      }
    }
    const double* painted = a.values.data() + 12 * a.width;
    for (std::size_t i = 0; i < 12; ++i) {
      if (a.name == "_LAYER") {
        EXPECT_EQ(painted[i], static_cast<double>(i % 4));
      } else if (a.name == "_STIFFNESS") {
        EXPECT_EQ(painted[i], static_cast<double>(i % 4) / 4.0);
      } else if (a.name == "COLOR_0") {
        EXPECT_NEAR(painted[4 * i], 0.2 * static_cast<double>(i % 6), float_rounding);
        EXPECT_EQ(painted[4 * i + 2], 1.0);
      } else {
        const Vector3d d(painted[3 * i], painted[3 * i + 1], painted[3 * i + 2]);
        EXPECT_LT((d - Vector3d(0, i < 6 ? 2 : 0, 0)).norm(), 2 * float_rounding);
      }
    }
  }

  // Invalid paint is refused, with its place.
  GltfBuilder missing = column();
  missing.document["meshes"][0]["primitives"][0]["attributes"]["_LAYER"] = 999;
  try {
    read(missing);
    ADD_FAILURE() << "a missing accessor was accepted";
  } catch (const base::SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("/meshes/0/primitives/0/attributes/_LAYER"), std::string::npos)
        << error.what();
  }
  GltfBuilder few = column();
  few.document["meshes"][0]["primitives"][0]["attributes"]["_LAYER"] = few.add<float>("SCALAR", {1.0f, 2.0f});
  try {
    read(few);
    ADD_FAILURE() << "two values for twelve vertices were accepted";
  } catch (const base::SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("2 elements for 12 positions"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace fascicle::tests::gltf_test
