// Characters in other formats: compared with Blender, which writes one character as glTF, FBX and Collada,
// and with the formula of FBX's transforms; and malicious files.

#include "host/gltf/convert.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "host/gltf/gltf.h"
#include "host/gltf/gltf_rig.h"
#include "host/rig/pose.h"
#include "host/scene/scene_file.h"
#include "tests/gltf/gltf_builder.h"
#include "tests/support/readers.h"
#include "tests/support/seed.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3d;
using rig::Character;
namespace fs = std::filesystem;

std::vector<Vector3d> skinned(const Character& character, const rig::Clip* clip, double time) {
  const std::vector<Eigen::Matrix4d> joints = rig::pose_at(character, clip, time);
  std::vector<Vector3d> result;
  for (std::size_t v = 0; v < character.surface.vertices.size(); ++v) {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t k = 0; k < 8; ++k)
      sum += character.weights[v][k] *
             (joints[character.joints[v][k]] * character.surface.vertices[v].homogeneous()).head<3>();
    result.push_back(sum);
  }
  return result;
}

// The largest distance of a point to the nearest point of the other set: vertex orders and seams differ.
double distance(const std::vector<Vector3d>& one, const std::vector<Vector3d>& other) {
  double largest = 0.0;
  for (const Vector3d& p : one) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vector3d& q : other) nearest = std::min(nearest, (p - q).norm());
    largest = std::max(largest, nearest);
  }
  return largest;
}

double both_ways(const std::vector<Vector3d>& one, const std::vector<Vector3d>& other) {
  return std::max(distance(one, other), distance(other, one));
}

double height(const std::vector<Vector3d>& points) {
  double low = points.front().y(), high = low;
  for (const Vector3d& p : points) {
    low = std::min(low, p.y());
    high = std::max(high, p.y());
  }
  return high - low;
}

std::string text_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

bool has_joint(const Character& character, const std::string& name) {
  return std::any_of(character.skeleton.begin(), character.skeleton.end(),
                     [&](const rig::Joint& joint) { return joint.name == name; });
}

// Single precision through three changes of unit: 1e-6 of 1.8 m, a few times over.
constexpr double file_rounding = 1e-5;

class FromBlender : public testing::Test {
 protected:
  void SetUp() override {
    FASCICLE_NEEDS_BLENDER;
    const std::string command = std::string(
                                    "blender --background --factory-startup --python-exit-code 1 "
                                    "--python '") +
                                FASCICLE_SOURCE_DIR + "/tests/readers/export_blender.py' -- '" +
                                folder_.path().string() + "' > '" + (folder_.path() / "log").string() +
                                "' 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << text_of(folder_.path() / "log");
  }
  Character read(const std::string& name) const { return gltf::read_gltf(folder_.path() / name); }

  TemporaryFolder folder_;
};

TEST_F(FromBlender, one_character_is_the_same_in_three_formats) {
  const Character glb = read("post.glb");
  const rig::Clip* const bend = rig::find_clip(glb, "bend");
  for (const std::string name : {"post.fbx", "post.dae"}) {
    const Character other = read(name);
    EXPECT_TRUE(other.notes.empty()) << name << ": " << other.notes.front();
    EXPECT_NEAR(height(other.surface.vertices), 1.8, file_rounding) << name << ": not in metres";
    EXPECT_EQ(other.surface.triangles.size(), glb.surface.triangles.size()) << name;
    for (const char* joint : {"lower", "upper"}) EXPECT_TRUE(has_joint(other, joint)) << name << ' ' << joint;
    ASSERT_EQ(other.clips.size(), 1u) << name;
    EXPECT_NEAR(other.clips[0].duration, bend->duration, file_rounding) << name;
    EXPECT_LT(both_ways(skinned(other, nullptr, 0.0), skinned(glb, nullptr, 0.0)), file_rounding)
        << name << ": the file was saved in the middle of the clip, which is its rest pose";
    double largest = 0.0, moved = 0.0;
    for (int frame = 0; frame <= 24; ++frame) {
      const std::vector<Vector3d> wanted = skinned(glb, bend, frame / 24.0);
      largest = std::max(largest, both_ways(skinned(other, &other.clips[0], frame / 24.0), wanted));
      moved = std::max(moved, both_ways(skinned(other, nullptr, 0.0), wanted));
    }
    EXPECT_LT(largest, file_rounding) << name;
    EXPECT_GT(moved, 0.3) << name << ": the clip moves nothing, so the comparison is meaningless";
  }
  EXPECT_EQ(read("post.fbx").clips[0].name, "Rig|bend");
}

// The largest displacement by blend shapes at a time, m.
double most_shaped(const gltf::Rig& rig, const std::string& clip, double time) {
  double largest = 0.0;
  for (const gltf::RigPart& part : rig.parts) {
    const std::vector<Vector3d> shaped =
        gltf::shaped_positions(part, rig::find_clip(rig.character, clip), time);
    for (std::size_t v = 0; v < shaped.size(); ++v)
      largest = std::max(largest, (shaped[v] - part.positions[v]).norm());
  }
  return largest;
}

TEST_F(FromBlender, blend_shapes_come_with_their_clips) {
  const gltf::Rig glb = gltf::read_rig(folder_.path() / "post.glb"),
                  fbx = gltf::read_rig(folder_.path() / "post.fbx");
  ASSERT_EQ(fbx.parts.size(), 1u);
  EXPECT_EQ(fbx.parts[0].shapes.size(), 1u);
  for (int frame = 0; frame <= 24; frame += 6) {
    const double wanted = most_shaped(glb, "swell", frame / 24.0);
    EXPECT_NEAR(most_shaped(fbx, "Rig|bend", frame / 24.0), wanted, file_rounding) << frame;
    EXPECT_NEAR(wanted, 0.075 * frame / 24.0, file_rounding) << frame;
  }
}

// As above, with a binary file: assimp passes on the keys of shapes after the stop.
TEST_F(FromBlender, blend_shapes_end_where_their_stack_does) {
  std::string text = text_of(folder_.path() / "post.fbx");
  const auto bytes_of = [](std::int64_t ticks) {
    std::string bytes(sizeof ticks, '\0');
    std::memcpy(bytes.data(), &ticks, sizeof ticks);
    return "L" + bytes;
  };
  constexpr std::int64_t second = 46186158000;
  std::size_t halved = 0;
  for (std::size_t at = text.find("LocalStop"); at != std::string::npos; at = text.find("LocalStop", at + 1))
    if (const std::size_t number = text.find(bytes_of(second), at); number < at + 40) {
      text.replace(number, 9, bytes_of(second / 2));
      ++halved;
    }
  ASSERT_GT(halved, 0u);
  const gltf::Rig rig = gltf::read_rig(folder_.write("half.fbx", text));
  EXPECT_NEAR(rig::find_clip(rig.character, "Rig|bend")->duration, 0.5, file_rounding);
  EXPECT_NEAR(most_shaped(rig, "Rig|bend", 0.5), 0.0375, file_rounding);
}

TEST_F(FromBlender, cut_off_and_damaged_files_are_refused_or_read) {
  std::mt19937_64 random(seed_of_run(7));
  for (const std::string name : {"post.fbx", "post.dae"}) {
    const std::string whole = text_of(folder_.path() / name);
    for (const std::size_t part : {1u, 2u, 3u}) {
      const fs::path cut = folder_.write("cut-" + name, whole.substr(0, whole.size() * part / 4));
      try {
        gltf::read_gltf(cut);
        FAIL() << name << " was read with " << part << " quarters of it";
      } catch (const base::SceneError& error) {
        const std::string what = error.what();
        EXPECT_EQ(what.find(cut.string() + ": "), 0u) << what;
        EXPECT_NE(what.find("export `cut-post.glb`"), std::string::npos) << what;
        EXPECT_EQ(what.find('\n'), std::string::npos) << what;
      }
    }
    // Anything but an error or a character fails this test too.
    for (int i = 0; i < 12; ++i) {
      std::string damaged = whole;
      for (int k = 0; k < 20; ++k) damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
      try {
        gltf::read_gltf(folder_.write("damaged-" + name, damaged));
      } catch (const base::SceneError&) {
      }
    }
  }
}

using Keys = std::vector<std::pair<double, double>>;  // s, value

// A plate on a rotating node, as text: 40 lines make an FBX file.
struct Post {
  std::string properties = {};
  int up = 1, up_sign = 1, right = 0, right_sign = 1;
  double unit = 1.0;       // cm
  bool has_still = false;  // constant translation keys of the plate at 0 and 2 s
  std::string stack = {};  // properties of the clip
  Keys turns = {};         // degrees about Z, instead of 0 to 90 in a second with 30 frames
  Keys shapes = {};        // per cent of a blend shape that moves the plate's last vertex by 10 cm
};

std::string property(const std::string& name, double x, double y, double z) {
  std::ostringstream out;
  out << "P: \"" << name << "\", \"Vector3D\", \"Vector\", \"\"," << x << ',' << y << ',' << z << "\n";
  return out.str();
}

constexpr double ticks_a_second = 46186158000.0, degree = 3.14159265358979323846 / 180.0;

long long ticks_of(double seconds) {
  return std::llround(ticks_a_second * seconds);
}

std::string span(double start, double stop) {
  return "Properties70: {\nP: \"LocalStart\", \"KTime\", \"Time\", \"\"," + std::to_string(ticks_of(start)) +
         "\nP: \"LocalStop\", \"KTime\", \"Time\", \"\"," + std::to_string(ticks_of(stop)) + "\n}\n";
}

std::string curve(int id, const Keys& keys) {
  std::ostringstream out;
  out << "AnimationCurve: " << id << ", \"AnimCurve::\", \"\" {\nDefault: 0\nKeyVer: 4008\n"
      << "KeyTime: *" << keys.size() << " {\na: ";
  for (std::size_t k = 0; k < keys.size(); ++k) out << (k ? "," : "") << ticks_of(keys[k].first);
  out << "\n}\nKeyValueFloat: *" << keys.size() << " {\na: ";
  for (std::size_t k = 0; k < keys.size(); ++k) out << (k ? "," : "") << keys[k].second;
  out << "\n}\n}\n";
  return out.str();
}

std::string fbx_of(const Post& post) {
  Keys turns = post.turns;
  for (int k = 0; post.turns.empty() && k <= 30; ++k) turns.emplace_back(k / 30.0, 3.0 * k);
  Keys none = turns;
  for (auto& key : none) key.second = 0.0;
  std::ostringstream out;
  out << "; FBX 7.4.0 project file\nFBXHeaderExtension: {\nFBXHeaderVersion: 1003\nFBXVersion: 7400\n}\n"
         "GlobalSettings: {\nVersion: 1000\nProperties70: {\n"
      << "P: \"UpAxis\", \"int\", \"Integer\", \"\"," << post.up << "\nP: \"UpAxisSign\", \"int\", "
      << "\"Integer\", \"\"," << post.up_sign << "\nP: \"FrontAxis\", \"int\", \"Integer\", \"\",2\n"
      << "P: \"FrontAxisSign\", \"int\", \"Integer\", \"\",1\nP: \"CoordAxis\", \"int\", \"Integer\", \"\","
      << post.right << "\nP: \"CoordAxisSign\", \"int\", \"Integer\", \"\"," << post.right_sign
      << "\nP: \"UnitScaleFactor\", \"double\", \"Number\", \"\"," << post.unit
      << "\nP: \"TimeMode\", \"enum\", \"\", \"\",6\n}\n}\n"
         "Objects: {\n"
         "Model: 10, \"Model::Arm\", \"Null\" {\nVersion: 232\nProperties70: {\n"
      << post.properties
      << "}\n}\nModel: 11, \"Model::Plate\", \"Mesh\" {\nVersion: 232\nProperties70: {\n}\n}\n"
         "Geometry: 12, \"Geometry::Plate\", \"Mesh\" {\nVertices: *12 {\na: 0,0,0,10,0,0,0,20,0,0,0,30\n}\n"
         "PolygonVertexIndex: *12 {\na: 0,2,-2,0,1,-4,1,2,-4,2,0,-4\n}\nGeometryVersion: 124\n}\n"
         "AnimationStack: 20, \"AnimStack::turn\", \"\" {\n"
      << post.stack
      << "}\nAnimationLayer: 21, \"AnimLayer::base\", \"\" {\n}\n"
         "AnimationCurveNode: 22, \"AnimCurveNode::R\", \"\" {\n}\n";
  for (int axis = 0; axis < 3; ++axis) out << curve(23 + axis, axis == 2 ? turns : none);
  for (int axis = 0; post.has_still && axis < 3; ++axis) out << curve(33 + axis, {{0.0, 0.0}, {2.0, 0.0}});
  if (post.has_still) out << "AnimationCurveNode: 32, \"AnimCurveNode::T\", \"\" {\n}\n";
  if (!post.shapes.empty())
    out << "Geometry: 40, \"Geometry::Swell\", \"Shape\" {\nVersion: 100\nIndexes: *1 {\na: 3\n}\n"
           "Vertices: *3 {\na: 0,0,10\n}\nNormals: *3 {\na: 0,0,0\n}\n}\n"
           "Deformer: 41, \"Deformer::Swell\", \"BlendShape\" {\nVersion: 100\n}\n"
           "Deformer: 42, \"SubDeformer::Swell\", \"BlendShapeChannel\" {\nVersion: 100\nDeformPercent: 0\n"
           "FullWeights: *1 {\na: 100\n}\n}\nAnimationCurveNode: 43, \"AnimCurveNode::DeformPercent\", \"\" "
           "{\n}\n"
        << curve(44, post.shapes);
  out << "}\nConnections: {\nC: \"OO\",10,0\nC: \"OO\",11,10\nC: \"OO\",12,11\nC: \"OO\",21,20\n"
         "C: \"OO\",22,21\nC: \"OP\",22,10, \"Lcl Rotation\"\nC: \"OP\",23,22, \"d|X\"\n"
         "C: \"OP\",24,22, \"d|Y\"\nC: \"OP\",25,22, \"d|Z\"\n";
  if (post.has_still)
    out << "C: \"OO\",32,21\nC: \"OP\",32,11, \"Lcl Translation\"\nC: \"OP\",33,32, \"d|X\"\n"
           "C: \"OP\",34,32, \"d|Y\"\nC: \"OP\",35,32, \"d|Z\"\n";
  if (!post.shapes.empty())
    out << "C: \"OO\",40,42\nC: \"OO\",42,41\nC: \"OO\",41,12\nC: \"OO\",43,21\n"
           "C: \"OP\",43,42, \"DeformPercent\"\nC: \"OP\",44,43, \"d|DeformPercent\"\n";
  out << "}\n";
  return out.str();
}

// A plate skinned to one joint below a node, as Blender would write it. The clip holds it still for 2 s.
std::string dae_of(const std::string& top, const std::string& joint) {
  const std::string unit = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";
  const auto numbers = [](const std::string& id, int count, const std::string& values, int width,
                          const std::string& params) {
    return "<source id=\"" + id + "\"><float_array id=\"" + id + "-array\" count=\"" + std::to_string(count) +
           "\">" + values + "</float_array><technique_common><accessor source=\"#" + id +
           "-array\" count=\"" + std::to_string(count / width) + "\" stride=\"" + std::to_string(width) +
           "\">" + params + "</accessor></technique_common></source>\n";
  };
  const auto params = [](const std::string& names, const std::string& type) {
    std::string result;
    for (const char c : names) result += std::string("<param name=\"") + c + "\" type=\"" + type + "\"/>";
    return result;
  };
  const std::string matrix = "<param name=\"TRANSFORM\" type=\"float4x4\"/>";
  const std::string names_of = "<technique_common><accessor source=\"#";
  return "<?xml version=\"1.0\"?>\n<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
         "version=\"1.4.1\">\n<asset><contributor><authoring_tool>Blender 3.4</authoring_tool></contributor>"
         "<unit name=\"meter\" meter=\"1\"/><up_axis>Y_UP</up_axis></asset>\n"
         "<library_geometries><geometry id=\"plate\" name=\"plate\"><mesh>\n" +
         numbers("places", 12, "0 0 0 1 0 0 0 2 0 0 0 3", 3, params("XYZ", "float")) +
         "<vertices id=\"corners\"><input semantic=\"POSITION\" source=\"#places\"/></vertices>\n"
         "<triangles count=\"4\"><input semantic=\"VERTEX\" source=\"#corners\" offset=\"0\"/>"
         "<p>0 2 1 0 1 3 1 2 3 2 0 3</p></triangles>\n</mesh></geometry></library_geometries>\n"
         "<library_controllers><controller id=\"skin\"><skin source=\"#plate\"><bind_shape_matrix>" +
         unit +
         "</bind_shape_matrix>\n<source id=\"joints\"><Name_array id=\"joints-array\" count=\"1\">bone"
         "</Name_array>" +
         names_of +
         "joints-array\" count=\"1\" stride=\"1\"><param name=\"JOINT\" type=\"name\"/></accessor>"
         "</technique_common></source>\n" +
         numbers("binds", 16, unit, 16, matrix) + numbers("weights", 1, "1", 1, params("W", "float")) +
         "<joints><input semantic=\"JOINT\" source=\"#joints\"/><input semantic=\"INV_BIND_MATRIX\" "
         "source=\"#binds\"/></joints>\n<vertex_weights count=\"4\"><input semantic=\"JOINT\" "
         "source=\"#joints\" offset=\"0\"/><input semantic=\"WEIGHT\" source=\"#weights\" offset=\"1\"/>"
         "<vcount>1 1 1 1</vcount><v>0 0 0 0 0 0 0 0</v></vertex_weights>\n</skin></controller>"
         "</library_controllers>\n<library_animations><animation id=\"still\">\n" +
         numbers("times", 2, "0 2", 1, params("T", "float")) +
         numbers("turns", 32, unit + " " + unit, 16, matrix) +
         "<source id=\"ways\"><Name_array id=\"ways-array\" count=\"2\">LINEAR LINEAR</Name_array>" +
         names_of +
         "ways-array\" count=\"2\" stride=\"1\"><param name=\"INTERPOLATION\" type=\"name\"/></accessor>"
         "</technique_common></source>\n<sampler id=\"sampler\"><input semantic=\"INPUT\" "
         "source=\"#times\"/><input semantic=\"OUTPUT\" source=\"#turns\"/><input "
         "semantic=\"INTERPOLATION\" source=\"#ways\"/></sampler>\n<channel source=\"#sampler\" "
         "target=\"bone/transform\"/></animation></library_animations>\n"
         "<library_visual_scenes><visual_scene id=\"scene\" name=\"scene\">\n<node id=\"top\" name=\"" +
         top + "\"><node id=\"bone\" sid=\"bone\" name=\"" + joint +
         "\" type=\"JOINT\"><matrix sid=\"transform\">" + unit +
         "</matrix></node>\n<node id=\"body\" name=\"body\"><instance_controller url=\"#skin\">"
         "<skeleton>#bone</skeleton></instance_controller></node></node>\n</visual_scene>"
         "</library_visual_scenes>\n<scene><instance_visual_scene url=\"#scene\"/></scene></COLLADA>\n";
}

Eigen::Affine3d turned(double x, double y, double z) {
  return Eigen::Affine3d(Eigen::AngleAxisd(z * degree, Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(y * degree, Vector3d::UnitY()) *
                         Eigen::AngleAxisd(x * degree, Vector3d::UnitX()));
}
Eigen::Affine3d moved(double x, double y, double z) {
  return Eigen::Affine3d(Eigen::Translation3d(x, y, z));
}

const std::vector<Vector3d> plate{{0, 0, 0}, {10, 0, 0}, {0, 20, 0}, {0, 0, 30}};

// `local` gives the transform at an angle, in the file's axes and unit; `world` converts those to metres.
template <typename Local>
void expect_motion(const std::string& text, const Eigen::Matrix3d& world, const Local& local) {
  const TemporaryFolder folder;
  const Character character = gltf::read_gltf(folder.write("plate.fbx", text));
  ASSERT_EQ(character.clips.size(), 1u);
  EXPECT_EQ(character.clips[0].name, "turn");
  EXPECT_NEAR(character.clips[0].duration, 1.0, 1e-6);
  for (const double time : {0.0, 0.5, 1.0}) {
    std::vector<Vector3d> wanted;
    for (const Vector3d& p : plate) wanted.push_back(world * (local(90.0 * time) * p));
    EXPECT_LT(both_ways(skinned(character, &character.clips[0], time), wanted),
              file_rounding * world.norm() * 30.0)
        << "at " << time << " s";
  }
}

TEST(Fbx, axes_and_unit_become_metres_with_y_up) {
  // 3ds Max: Z up, inches.
  Post post{.properties = property("Lcl Translation", 1, 2, 3), .up = 2, .unit = 2.54};
  Eigen::Matrix3d world;
  world << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  expect_motion(fbx_of(post), 0.0254 * world,
                [](double angle) { return moved(1, 2, 3) * turned(0, 0, angle); });
  // Control: in centimetres, the usual unit, the plate would be elsewhere.
  const Eigen::Matrix3d inches = 0.0254 * world;
  std::vector<Vector3d> in_inches;
  for (const Vector3d& p : plate) in_inches.push_back(inches * (moved(1, 2, 3) * p));
  post.unit = 1.0;
  const TemporaryFolder folder;
  const Character smaller = gltf::read_gltf(folder.write("plate.fbx", fbx_of(post)));
  EXPECT_GT(both_ways(skinned(smaller, &smaller.clips.at(0), 0.0), in_inches), 0.01 * inches.norm());
}

TEST(Fbx, rotations_before_and_after_the_nodes_own_are_kept) {
  const Post post{.properties = property("Lcl Translation", 1, 2, 3) + property("PreRotation", 90, 20, 0) +
                                property("PostRotation", 0, 30, 10)};
  expect_motion(fbx_of(post), 0.01 * Eigen::Matrix3d::Identity(), [](double angle) {
    return moved(1, 2, 3) * turned(90, 20, 0) * turned(0, 0, angle) * turned(0, 30, 10).inverse();
  });
}

TEST(Fbx, nodes_turn_about_their_pivots) {
  const Post post{.properties = property("Lcl Translation", 1, 2, 3) + property("RotationOffset", 4, 0, 0) +
                                property("RotationPivot", 0, 50, 0) + property("PreRotation", 0, 0, 40) +
                                property("ScalingOffset", 0, 0, 7) + property("ScalingPivot", 5, 5, 5) +
                                property("Lcl Scaling", 2, 2, 2)};
  expect_motion(fbx_of(post), 0.01 * Eigen::Matrix3d::Identity(), [](double angle) {
    return moved(1, 2, 3) * moved(4, 0, 0) * moved(0, 50, 0) * turned(0, 0, 40) * turned(0, 0, angle) *
           moved(0, -50, 0) * moved(0, 0, 7) * moved(5, 5, 5) * Eigen::Scaling(2.0) * moved(-5, -5, -5);
  });
}

// Constant channels are dropped, but they still extend the clip.
TEST(Converter, clips_last_to_their_last_key) {
  const TemporaryFolder folder;
  const Character held = gltf::read_gltf(folder.write("held.fbx", fbx_of({.has_still = true})));
  ASSERT_EQ(held.clips.size(), 1u);
  EXPECT_NEAR(held.clips[0].duration, 2.0, 1e-6);
  for (const rig::Channel& channel : held.clips[0].channels)
    EXPECT_EQ(held.skeleton[channel.joint].name, "Arm") << "the plate stands still";
  EXPECT_LT(both_ways(skinned(held, &held.clips[0], 2.0), skinned(held, &held.clips[0], 1.0)), file_rounding);

  const Character still = gltf::read_gltf(folder.write("still.dae", dae_of("top", "bone")));
  ASSERT_EQ(still.clips.size(), 1u);
  EXPECT_NEAR(still.clips[0].duration, 2.0, 1e-6);
  EXPECT_LT(both_ways(skinned(still, &still.clips[0], 1.0), skinned(still, nullptr, 0.0)), file_rounding);
}

// The angle by which the plate is turned about Z, in degrees.
double angle_at(const Character& character, double time) {
  const std::vector<Vector3d> still = skinned(character, nullptr, 0.0),
                              now = skinned(character, &character.clips.at(0), time);
  std::size_t far = 0;
  for (std::size_t v = 0; v < still.size(); ++v)
    if (still[v].x() > still[far].x()) far = v;
  return std::atan2(now[far].y(), now[far].x()) / degree;
}

// Single precision through quaternions, degrees.
constexpr double angle_rounding = 1e-3;

// Assimp passes on the first key of a rotation even if it is outside.
TEST(Fbx, a_rotations_first_key_outside_its_stack_counts_up_to_the_border) {
  const TemporaryFolder folder;
  const auto read = [&](const Keys& turns) {
    return gltf::read_gltf(folder.write("plate.fbx", fbx_of({.stack = span(1.0, 2.0), .turns = turns})));
  };
  const Character held = read({{0.0, 45.0}});
  ASSERT_EQ(held.clips.size(), 1u);
  EXPECT_NEAR(angle_at(held, 0.0), 45.0, angle_rounding);
  const Character cut = read({{0.0, 0.0}, {1.5, 90.0}});
  ASSERT_EQ(cut.clips.size(), 1u);
  EXPECT_NEAR(cut.clips[0].duration, 0.5, 1e-6);
  EXPECT_NEAR(angle_at(cut, 0.0), 60.0, angle_rounding);
  EXPECT_NEAR(angle_at(cut, 0.25), 75.0, angle_rounding);
  EXPECT_NEAR(angle_at(cut, 0.5), 90.0, angle_rounding);
  const Character late = read({{3.0, 45.0}});
  ASSERT_EQ(late.clips.size(), 1u);
  EXPECT_LE(late.clips[0].duration, 1.0 + 1e-6);
  EXPECT_NEAR(angle_at(late, 1.0), 45.0, angle_rounding);
  // Control: keys at the borders are taken as they are.
  const Character whole = read({{1.0, 10.0}, {2.0, 20.0}});
  EXPECT_NEAR(angle_at(whole, 0.0), 10.0, angle_rounding);
  EXPECT_NEAR(whole.clips.at(0).duration, 1.0, 1e-6);
}

void replace(std::string& text, const std::string& part, const std::string& by) {
  const std::size_t at = text.find(part);
  ASSERT_NE(at, std::string::npos) << part;
  text.replace(at, part.size(), by);
}

// Shapes are in the file's unit, cm.
constexpr double shape_rounding = 100.0 * file_rounding;

TEST(Fbx, blend_shapes_last_as_long_as_their_stack) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) { return gltf::read_rig(folder.write("plate.fbx", text)); };
  const Keys turns{{1.0, 0.0}, {2.0, 90.0}}, shapes{{0.0, 0.0}, {4.0, 100.0}};
  const gltf::Rig cut = read(fbx_of({.stack = span(1.0, 2.0), .turns = turns, .shapes = shapes}));
  ASSERT_EQ(cut.character.clips.size(), 1u);
  EXPECT_NEAR(cut.character.clips[0].duration, 1.0, 1e-6);
  EXPECT_NEAR(most_shaped(cut, "turn", 0.0), 2.5, shape_rounding);
  EXPECT_NEAR(most_shaped(cut, "turn", 1.0), 5.0, shape_rounding);

  // A stack without start and stop lasts to the last key of nodes or shapes, also if it says so with zeros.
  for (const std::string& none : {std::string(), span(0.0, 0.0)}) {
    const gltf::Rig all = read(fbx_of({.stack = none, .turns = turns, .shapes = {{1.0, 0.0}, {4.0, 100.0}}}));
    EXPECT_NEAR(all.character.clips.at(0).duration, 3.0, 1e-6);
    EXPECT_NEAR(most_shaped(all, "turn", 3.0), 10.0, shape_rounding);
  }
}

TEST(Fbx, a_clip_of_blend_shapes_alone_begins_at_its_first_key) {
  const TemporaryFolder folder;
  std::string text = fbx_of({.shapes = {{1.0, 0.0}, {3.0, 100.0}}});
  replace(
      text, "AnimationCurveNode: 43",
      "AnimationStack: 50, \"AnimStack::swell\", \"\" {\n}\nAnimationLayer: 51, \"AnimLayer::base\", \"\" "
      "{\n}\nAnimationCurveNode: 43");
  replace(text, "C: \"OO\",43,21", "C: \"OO\",43,51\nC: \"OO\",51,50");
  const gltf::Rig rig = gltf::read_rig(folder.write("plate.fbx", text));
  ASSERT_EQ(rig.character.clips.size(), 2u);
  // Assimp shifts its times by 10^10 frames, which leaves 2e-6 of a frame.
  EXPECT_NEAR(rig::find_clip(rig.character, "swell")->duration, 2.0, 1e-6);
  EXPECT_NEAR(most_shaped(rig, "swell", 0.0), 0.0, shape_rounding);
  EXPECT_NEAR(most_shaped(rig, "swell", 1.0), 5.0, shape_rounding);
}

const std::string unit = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1", raised = "1 0 0 0 0 1 0 1 0 0 1 0 0 0 0 1",
                  aside = "1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1",
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

TEST(Fbx, files_that_mean_no_good_get_one_message) {
  const TemporaryFolder folder;
  const std::string good = fbx_of({});
  const auto refused = [&](const std::string& name, const std::string& text) {
    try {
      gltf::read_gltf(folder.write(name, text));
    } catch (const base::SceneError& error) {
      const std::string what = error.what();
      EXPECT_EQ(what.find('\n'), std::string::npos) << what;
      return what;
    }
    return std::string();
  };
  EXPECT_EQ(refused("good.fbx", good), "");
  EXPECT_NE(refused("empty.fbx", "").find("it is empty"), std::string::npos);
  EXPECT_NE(refused("noise.fbx", "\x01\x02 noise").find("cannot be read"), std::string::npos);
  // Just a header that announces blocks of 4 GiB.
  std::string binary = "Kaydara FBX Binary  ";
  binary += std::string("\0\x1a\0\xe8\x1c\0\0", 7) + std::string(64, '\xff');
  EXPECT_NE(refused("huge.fbx", binary).find("cannot be read"), std::string::npos);
  std::string counts = good;
  counts.replace(counts.find("*12 {"), 5, "*4000000000 {");
  EXPECT_NE(refused("counts.fbx", counts).find("cannot be read"), std::string::npos);
  std::string nothing = good;
  nothing.replace(nothing.find("C: \"OO\",12,11"), 13, "");
  EXPECT_NE(refused("nothing.fbx", nothing).find("contains no polygon mesh"), std::string::npos);
  // By its name an FBX file, by its content one that would open others.
  EXPECT_NE(
      refused("other.fbx", "mtllib /etc/passwd\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").find("cannot be"),
      std::string::npos);
  // Names that assimp gives parts of an FBX node are ordinary names in Collada, for the top node and for a
  // joint.
  const Character named = gltf::read_gltf(
      folder.write("links.dae", dae_of("Top_$AssimpFbx$_Rotation", "Bone_$AssimpFbx$_Rotation")));
  EXPECT_TRUE(has_joint(named, "Bone_$AssimpFbx$_Rotation"));
  EXPECT_LT(both_ways(named.surface.vertices, {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}}), file_rounding);
}

// The converter's own output; checks its exit status.
std::string said_by_converter(const TemporaryFolder& folder, const std::string& arguments, int status) {
  const std::string command = "cd '" + folder.path().string() + "' && '" + FASCICLE_BINARY_DIR +
                              "/fascicle-convert' " + arguments + " 2> err";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), status) << arguments;
  return text_of(folder.path() / "err");
}

TEST(Converter, writes_nothing_but_a_glb_that_is_another_file) {
  const TemporaryFolder folder;
  const std::string good = fbx_of({});
  folder.write("man.fbx", good);
  fs::create_hard_link(folder.path() / "man.fbx", folder.path() / "same.glb");
  for (const char* out : {"man.fbx", "man", "man.gltf", "same.glb"}) {
    const std::string said = said_by_converter(folder, std::string("man.fbx ") + out, 2);
    EXPECT_NE(said.find(out), std::string::npos) << said;
    EXPECT_EQ(text_of(folder.path() / "man.fbx"), good) << out;
  }
  fs::create_directories(folder.path() / "taken.glb" / "by");
  EXPECT_NE(said_by_converter(folder, "man.fbx taken.glb", 4).find("taken.glb cannot be written"),
            std::string::npos);
  for (const auto& entry : fs::directory_iterator(folder.path()))
    EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << entry.path();
  EXPECT_EQ(said_by_converter(folder, "man.fbx man.glb", 0), "");
  EXPECT_TRUE(fs::exists(folder.path() / "man.glb"));
}

TEST(Converter, messages_name_the_file_once) {
  const TemporaryFolder folder;
  folder.write("noise.fbx", "noise");
  EXPECT_EQ(said_by_converter(folder, "noise.fbx noise.glb", 3).find("fascicle-convert: noise.fbx: "), 0u);
  const fs::path noise = folder.path() / "noise.fbx";
  try {
    gltf::read_gltf(noise);
    FAIL() << "noise was read";
  } catch (const base::SceneError& error) {
    const std::string what = error.what();
    EXPECT_EQ(what.find(noise.string() + ": cannot be read: "), 0u) << what;
    EXPECT_EQ(what.find(noise.string(), 1), std::string::npos) << what;
  }
}

// The error when `converter` runs in place of the real one, or with its limits.
std::string refusal_of(const fs::path& input, const gltf::Converter& converter) {
  try {
    gltf::convert_character(input, fs::path(input).replace_extension(".glb"), converter);
  } catch (const base::SceneError& error) {
    return error.what();
  }
  return "converted";
}

// Each name in this comment begins a search, which once went to the end of the file: half a minute for 4 MB.
TEST(Converter, searches_a_file_of_many_names_in_time_by_its_length) {
  const TemporaryFolder folder;
  std::string text = fbx_of({}) + ";";
  while (text.size() < 4'000'000) text += "LocalStop\"";
  EXPECT_EQ(refusal_of(folder.write("names.fbx", text + "\n"),
                       {.limits = {.seconds = 10.0, .bytes = std::uint64_t{4} << 30}}),
            "converted");
}

TEST(Converter, that_takes_too_long_or_too_much_is_said_to) {
  const TemporaryFolder folder;
  const fs::path hero = folder.write("hero.fbx", fbx_of({}));
  const auto said = [&](const std::string& script, const base::ProcessLimits& limits) {
    const fs::path program = folder.write("converter", "#!/bin/sh\n" + script + "\n");
    fs::permissions(program, fs::perms::owner_all);
    return refusal_of(hero, {program, limits});
  };
  constexpr std::uint64_t gigabyte = std::uint64_t{1} << 30;
  const std::string by_hand = ". Convert it with FBX2glTF, ";
  for (const auto& [script, words] :
       {std::pair{"while :; do :; done", "took longer to convert than the 0.3 s of processor time allowed"},
        std::pair{"exec 2>&-; sleep 600",
                  "was not converted: the converter got no processor time for 0.3 s; see what keeps this "
                  "machine busy"},
        std::pair{"exit 6", "cannot be read: it needs more than 1.5 GiB of memory"},
        std::pair{"kill -SEGV $$", "cannot be read: the converter crashed on it (signal 11)"}})
    EXPECT_EQ(said(script, {.seconds = 0.3, .bytes = 3 * gigabyte / 2})
                  .find(hero.string() + ": " + words + by_hand),
              0u)
        << said(script, {.seconds = 0.3, .bytes = 3 * gigabyte / 2});
  // What the system or a scheduler ends says nothing about the file.
  for (const auto& [script, words] : {std::pair{"kill -KILL $$", "was killed from outside (Killed)"},
                                      std::pair{"kill -TERM $$", "was killed from outside (Terminated)"}})
    try {
      ADD_FAILURE() << said(script, {});
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  // On a busy machine it gets little CPU time, and is waited for.
  EXPECT_NE(said("i=0; while [ $i -lt 10 ]; do i=$((i+1)); sleep 0.2; done; exit 6", {.seconds = 1.0})
                .find("more than 4 GiB of memory"),
            std::string::npos);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

// The real converter with less and less memory: if it runs out it says so, and never blames the file.
TEST(Converter, a_file_that_needs_more_memory_is_not_called_bad) {
  const TemporaryFolder folder;
  // 400,000 numbers, which become a text of 5 MB and several copies.
  std::string points, corners;
  constexpr int count = 399996;
  for (int k = 0; k < count; ++k) points += std::to_string(k % 1000) + " ";
  for (int k = 0; k < count / 3; ++k) corners += std::to_string(k) + " ";
  const fs::path large = folder.write(
      "large.dae",
      "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><library_geometries>"
      "<geometry id=\"g\"><mesh><source id=\"p\"><float_array id=\"a\" count=\"" +
          std::to_string(count) + "\">" + points +
          "</float_array><technique_common><accessor source=\"#a\" count=\"" + std::to_string(count / 3) +
          "\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>"
          "<param name=\"Z\" type=\"float\"/></accessor></technique_common></source><vertices id=\"v\">"
          "<input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles count=\"" +
          std::to_string(count / 9) + "\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>" +
          corners +
          "</p></triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene "
          "id=\"s\">"
          "<node id=\"n\"><instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes>"
          "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>");
  ASSERT_EQ(refusal_of(large, {}), "converted");
  bool is_refused = false;
  // With less, not even its libraries load.
  for (std::uint64_t megabytes = 256; megabytes >= 32; megabytes -= 4) {
    const std::string said = refusal_of(large, {{}, {.bytes = megabytes << 20}});
    if (said == "converted") continue;
    if (said.find("shared librar") != std::string::npos) break;
    is_refused = true;
    EXPECT_NE(said.find("it needs more than 0."), std::string::npos) << megabytes << " MiB: " << said;
  }
  EXPECT_TRUE(is_refused);
}

#endif

// Another converter would not help, so the message names none.
TEST(Converter, a_machine_without_room_for_the_result_is_not_the_files_fault) {
  const TemporaryFolder folder;
  folder.write("hero.fbx", fbx_of({}));
  const std::string command = "cd '" + folder.path().string() + "' && TMPDIR=/nowhere '" +
                              FASCICLE_BINARY_DIR + "/fascicle' inspect hero.fbx > out 2> err";
  EXPECT_NE(WEXITSTATUS(std::system(command.c_str())), 0);
  const std::string said = text_of(folder.path() / "err");
  for (const char* part : {"hero.fbx: ", "TMPDIR"}) EXPECT_NE(said.find(part), std::string::npos) << said;
  EXPECT_EQ(said.find("FBX2glTF"), std::string::npos) << said;
}

// A copy of the program without the helper next to it.
TEST(Fbx, without_the_converter_the_message_names_others) {
  const TemporaryFolder folder;
  folder.write("hero.fbx", fbx_of({}));
  fs::copy_file(fs::path(FASCICLE_BINARY_DIR) / "fascicle", folder.path() / "fascicle");
  const std::string in_folder = "cd '" + folder.path().string() + "' && ";
  const int status =
      std::system((in_folder + "PATH=/nowhere ./fascicle inspect hero.fbx > out 2> err").c_str());
  EXPECT_EQ(WEXITSTATUS(status), 3);
  const std::string said = text_of(folder.path() / "err");
  for (const char* part : {"hero.fbx: ", "fascicle-convert", "FBX2glTF", "export `hero.glb`"})
    EXPECT_NE(said.find(part), std::string::npos) << said;
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
}

}  // namespace
}  // namespace fascicle::tests
