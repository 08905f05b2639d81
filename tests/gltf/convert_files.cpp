#include "tests/gltf/convert_files.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/rig/pose.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3d;
using rig::Character;
namespace fs = std::filesystem;

constexpr double ticks_a_second = 46186158000.0;

long long ticks_of(double seconds) {
  return std::llround(ticks_a_second * seconds);
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

double distance(const std::vector<Vector3d>& one, const std::vector<Vector3d>& other) {
  double largest = 0.0;
  for (const Vector3d& p : one) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vector3d& q : other) nearest = std::min(nearest, (p - q).norm());
    largest = std::max(largest, nearest);
  }
  return largest;
}

}  // namespace

std::string property(const std::string& name, double x, double y, double z) {
  std::ostringstream out;
  out << "P: \"" << name << "\", \"Vector3D\", \"Vector\", \"\"," << x << ',' << y << ',' << z << "\n";
  return out.str();
}

std::string span(double start, double stop) {
  return "Properties70: {\nP: \"LocalStart\", \"KTime\", \"Time\", \"\"," + std::to_string(ticks_of(start)) +
         "\nP: \"LocalStop\", \"KTime\", \"Time\", \"\"," + std::to_string(ticks_of(stop)) + "\n}\n";
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

std::string dae_of(const std::string& top, const std::string& joint) {
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

void replace(std::string& text, const std::string& part, const std::string& by) {
  const std::size_t at = text.find(part);
  ASSERT_NE(at, std::string::npos) << part;
  text.replace(at, part.size(), by);
}

std::string text_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

bool has_joint(const Character& character, const std::string& name) {
  return std::any_of(character.skeleton.begin(), character.skeleton.end(),
                     [&](const rig::Joint& joint) { return joint.name == name; });
}

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

double both_ways(const std::vector<Vector3d>& one, const std::vector<Vector3d>& other) {
  return std::max(distance(one, other), distance(other, one));
}

}  // namespace fascicle::tests
