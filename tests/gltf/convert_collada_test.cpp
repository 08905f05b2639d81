// Collada: which animations are one clip, and joints that share a name or are bound twice.
#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "host/gltf/gltf.h"
#include "host/rig/character.h"
#include "tests/gltf/convert_files.h"
#include "tests/gltf/gltf_builder.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3d;
using rig::Character;

const std::string raised = "1 0 0 0 0 1 0 1 0 0 1 0 0 0 0 1", aside = "1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1",
                  aside_undone = "1 0 0 -5 0 1 0 0 0 0 1 0 0 0 0 1";

// An animation that raises a node by a metre between two times, and an empty node of the animation's name:
// assimp itself joins animations that have one channel each.
std::string animation(const std::string& id, const std::string& node, const std::string& times) {
  const auto source = [&](const std::string& what, const std::string& array, const std::string& numbers,
                          const std::string& stride, const std::string& type) {
    const std::string name = id + "-" + what;
    return "<source id=\"" + name + "\"><" + array + " id=\"" + name + "-array\" count=\"" +
           (stride == "16" ? "32" : "2") + "\">" + numbers + "</" + array +
           "><technique_common><accessor source=\"#" + name + "-array\" count=\"2\" stride=\"" + stride +
           "\"><param name=\"P\" type=\"" + type + "\"/></accessor></technique_common></source>";
  };
  const auto channel = [&](const std::string& target) {
    const std::string sampler = id + "-" + target;
    return "<sampler id=\"" + sampler + "\"><input semantic=\"INPUT\" source=\"#" + id +
           "-times\"/><input semantic=\"OUTPUT\" source=\"#" + id +
           "-places\"/><input semantic=\"INTERPOLATION\" source=\"#" + id +
           "-ways\"/></sampler><channel source=\"#" + sampler + "\" target=\"" + target + "/transform\"/>";
  };
  return "<animation id=\"" + id + "\">" + source("times", "float_array", times, "1", "float") +
         source("places", "float_array", unit + " " + raised, "16", "float4x4") +
         source("ways", "Name_array", "LINEAR LINEAR", "1", "name") + channel(node) + channel(id) +
         "</animation>";
}

// The character of dae_of, whose joint and the node above it are raised one after the other.
std::string dae_raised(const std::string& second_node, const std::string& clips) {
  std::string text = dae_of("top", "bone");
  const std::size_t first = text.find("<animation id=\"still\">"), end = text.find("</library_animations>");
  text.replace(first, end - first,
               animation("one", "bone", "0.5 1.5") + animation("two", second_node, "2.5 3.5"));
  replace(text, "</library_animations>", "</library_animations>" + clips);
  replace(text, "<node id=\"top\" name=\"top\">",
          "<node id=\"top\" name=\"top\"><matrix sid=\"transform\">" + unit + "</matrix>");
  for (const char* name : {"one", "two"})
    replace(text, "</node>\n</visual_scene>",
            std::string("<node id=\"") + name + "\" name=\"" + name + "\"><matrix sid=\"transform\">" + unit +
                "</matrix></node></node>\n</visual_scene>");
  return text;
}

double raised_by(const Character& character, std::size_t clip, double time) {
  return skinned(character, &character.clips.at(clip), time).at(0).y() -
         skinned(character, nullptr, 0.0).at(0).y();
}

TEST(Collada, animations_of_different_nodes_are_one_clip) {
  const TemporaryFolder folder;
  const Character joined = gltf::read_gltf(folder.write("joined.dae", dae_raised("top", "")));
  ASSERT_EQ(joined.clips.size(), 1u);
  EXPECT_TRUE(joined.notes.empty()) << joined.notes.front();
  EXPECT_NEAR(joined.clips[0].duration, 3.0, 1e-6);
  for (const auto& [time, height_there] :
       Keys{{0.0, 0.0}, {0.5, 0.5}, {1.0, 1.0}, {2.0, 1.0}, {2.5, 1.5}, {3.0, 2.0}})
    EXPECT_NEAR(raised_by(joined, 0, time), height_there, file_rounding) << time;
}

TEST(Collada, animations_that_belong_apart_stay_clips_of_their_own) {
  const TemporaryFolder folder;
  const Character twice = gltf::read_gltf(folder.write("twice.dae", dae_raised("bone", "")));
  ASSERT_EQ(twice.clips.size(), 2u);
  ASSERT_EQ(twice.notes.size(), 1u);
  EXPECT_NE(twice.notes[0].find("several animations move `bone`"), std::string::npos) << twice.notes[0];
  // Files that name several clips are not joined, those with one clip of everything are.
  const auto clip = [](const std::string& name, const std::string& of) {
    return "<animation_clip id=\"" + name + "\" start=\"0\" end=\"4\">" + of + "</animation_clip>";
  };
  const std::string one = "<instance_animation url=\"#one\"/>", two = "<instance_animation url=\"#two\"/>",
                    library = "<library_animation_clips>", end = "</library_animation_clips>";
  const Character whole =
      gltf::read_gltf(folder.write("whole.dae", dae_raised("top", library + clip("all", one + two) + end)));
  EXPECT_EQ(whole.clips.size(), 1u);
  const Character named = gltf::read_gltf(
      folder.write("named.dae", dae_raised("top", library + clip("nod", one) + clip("wave", two) + end)));
  ASSERT_EQ(named.notes.size(), 1u);
  EXPECT_NE(named.notes[0].find("Export each clip into a file of its own"), std::string::npos)
      << named.notes[0];
  ASSERT_EQ(named.clips.size(), 2u);
  for (const Character* character : {&twice, &named})
    for (const std::size_t c : {0u, 1u}) {
      EXPECT_NEAR(character->clips[c].duration, 1.0, 1e-6);
      EXPECT_NEAR(raised_by(*character, c, 1.0), 1.0, file_rounding);
    }
}

const std::vector<Vector3d> dae_plate{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};

std::vector<Vector3d> shifted(const std::vector<Vector3d>& points, const Vector3d& by) {
  std::vector<Vector3d> result;
  for (const Vector3d& p : points) result.push_back(p + by);
  return result;
}

TEST(Collada, joints_of_one_name_are_one_joint) {
  const TemporaryFolder folder;
  std::string text = dae_raised("top", "");
  replace(text, "name=\"bone\" type=\"JOINT\"", "name=\"hand\" type=\"JOINT\"");
  replace(text, "count=\"1\">bone</Name_array>", "count=\"2\">bone other</Name_array>");
  replace(text, "joints-array\" count=\"1\"", "joints-array\" count=\"2\"");
  replace(text, "id=\"binds-array\" count=\"16\">" + unit,
          "id=\"binds-array\" count=\"32\">" + unit + " " + aside_undone);
  replace(text, "binds-array\" count=\"1\"", "binds-array\" count=\"2\"");
  // The last two vertices follow the other joint, the second one both.
  replace(text, "<vcount>1 1 1 1</vcount><v>0 0 0 0 0 0 0 0</v>",
          "<vcount>1 2 1 1</vcount><v>0 0 0 0 1 0 1 0 1 0</v>");
  replace(text, "<node id=\"body\"",
          "<node id=\"other\" sid=\"other\" name=\"hand\" type=\"JOINT\"><matrix sid=\"transform\">" + aside +
              "</matrix></node>\n<node id=\"body\"");
  const Character hands = gltf::read_gltf(folder.write("hands.dae", text));
  ASSERT_EQ(hands.notes.size(), 1u);
  EXPECT_NE(hands.notes[0].find("several nodes are named `hand`"), std::string::npos) << hands.notes[0];
  EXPECT_LT(both_ways(skinned(hands, nullptr, 0.0), dae_plate), file_rounding);
  EXPECT_LT(both_ways(skinned(hands, &hands.clips.at(0), 1.0), shifted(dae_plate, {0, 1, 0})), file_rounding);
}

TEST(Collada, a_joint_may_be_bound_twice) {
  const TemporaryFolder folder;
  std::string text = dae_raised("top", "");
  // The same skin with another place of the mesh, on the same node.
  const std::size_t from = text.find("<controller id=\"skin\">"), to = text.find("</library_controllers>");
  std::string second = text.substr(from, to - from);
  replace(second, "id=\"skin\"", "id=\"skin-2\"");
  replace(second, "<bind_shape_matrix>" + unit, "<bind_shape_matrix>" + aside);
  const std::size_t sources = second.find("<source "), joints = second.find("<joints>");
  second.erase(sources, joints - sources);  // those of the first are used
  text.insert(to, second);
  replace(text, "</instance_controller></node>",
          "</instance_controller><instance_controller url=\"#skin-2\"><skeleton>#bone</skeleton>"
          "</instance_controller></node>");
  const Character both = gltf::read_gltf(folder.write("both.dae", text));
  std::vector<Vector3d> wanted = shifted(dae_plate, {5, 0, 0});
  wanted.insert(wanted.end(), dae_plate.begin(), dae_plate.end());
  EXPECT_LT(both_ways(skinned(both, nullptr, 0.0), wanted), file_rounding);
  EXPECT_LT(both_ways(skinned(both, &both.clips.at(0), 1.0), shifted(wanted, {0, 1, 0})), file_rounding);
  EXPECT_LT(both_ways(skinned(both, &both.clips.at(0), 3.0), shifted(wanted, {0, 2, 0})), file_rounding);
}

}  // namespace
}  // namespace fascicle::tests
