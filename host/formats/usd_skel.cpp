#include "host/formats/usd_skel.h"

#include <algorithm>
#include <array>
#include <utility>

#include <Eigen/LU>

#include "host/base/errors.h"
#include "host/base/text.h"
#include "host/formats/character_file.h"
#include "host/formats/unique_names.h"
#include "host/formats/usd_text.h"
#include "host/gltf/gltf_file.h"
#include "host/rig/rig_math.h"

namespace fascicle::formats {

using Eigen::Matrix4d;
using Eigen::Vector3d;

namespace {

// Two bind poses of a joint count as equal if they differ by no more than this, relative to their size.
constexpr double same_pose = 1e-5;
constexpr const char* name_of_top = "top";

// USD uses row vectors, so its matrices are the transposes of ours.
std::string matrix_text(const Matrix4d& m) {
  std::string text = "(";
  for (Eigen::Index column = 0; column < 4; ++column) {
    text += column == 0 ? "(" : ", (";
    for (Eigen::Index row = 0; row < 4; ++row)
      text += (row == 0 ? "" : ", ") + base::number_text(m(row, column));
    text += ')';
  }
  return text + ')';
}

std::string matrix_list(const std::vector<Matrix4d>& matrices) {
  std::string text = "[";
  for (std::size_t i = 0; i < matrices.size(); ++i) text += (i == 0 ? "" : ", ") + matrix_text(matrices[i]);
  return text + ']';
}

// Each skeleton lists all joints with their paths and matrices. Small files can have many joints, long names
// and many skins that disagree.
constexpr std::size_t most_bytes = std::size_t{1} << 28u, bytes_of_joint = 800;

[[noreturn]] void refuse_skeletons() {
  throw base::BakeError("--usd-skel: the skeletons would take more than " +
                        base::number_text(std::uint64_t{most_bytes >> 20u}) + " MiB; leave the option out");
}

// Paths of the joints below `top`: names unique among siblings, in characters that paths allow.
std::vector<std::string> paths_of(const std::vector<rig::Joint>& skeleton, const std::string& top) {
  std::vector<std::string> paths;
  UniqueNames names;
  std::size_t bytes = 0;
  for (const rig::Joint& joint : skeleton) {
    const std::string above = joint.parent < 0 ? top : paths[static_cast<std::size_t>(joint.parent)] + '/';
    paths.push_back(names.take(above + identifier_of(joint.name.empty() ? "joint" : joint.name)));
    bytes += paths.back().size();
    if (bytes > most_bytes) refuse_skeletons();
  }
  return paths;
}

}  // namespace

UsdSkel::UsdSkel(const std::filesystem::path& character, const SurfaceObjects& surface, std::string path,
                 std::string materials)
    : surface_(surface),
      path_(std::move(path)),
      materials_(std::move(materials)),
      rig_(gltf::read_rig(character)),
      has_clip_(has_baked_clip(gltf::read_gltf_file(character).document)) {
  const std::vector<rig::Joint>& skeleton = rig_.character.skeleton;
  const auto is_root = [](const rig::Joint& joint) { return joint.parent < 0; };
  has_top_ = std::count_if(skeleton.begin(), skeleton.end(), is_root) > 1;
  tokens_ = paths_of(skeleton, has_top_ ? std::string(name_of_top) + '/' : "");
  for (const rig::Joint& joint : skeleton) {
    const Matrix4d& above =
        joint.parent < 0 ? rig_.character.root : rest_[static_cast<std::size_t>(joint.parent)];
    rest_.push_back(above * joint.rest_local);
  }
  bind_objects();
}

std::optional<Matrix4d> UsdSkel::bound(const gltf::RigPart& part, BindPose& pose) const {
  if (part.skin_joint.empty()) return Matrix4d::Identity();
  const auto top = static_cast<std::size_t>(std::min_element(part.skin_joint.begin(), part.skin_joint.end()) -
                                            part.skin_joint.begin());
  const std::size_t top_joint = part.skin_joint[top];
  const Matrix4d place = pose[top_joint].value_or(rest_[top_joint]) * part.inverse_bind[top];
  std::vector<std::uint32_t> added;
  for (std::size_t k = 0; k < part.skin_joint.size(); ++k) {
    std::optional<Matrix4d>& joint = pose[part.skin_joint[k]];
    if (!joint) {
      joint = place * part.inverse_bind[k].inverse();
      added.push_back(part.skin_joint[k]);
    }
    if ((*joint * part.inverse_bind[k] - place).norm() <= same_pose * place.norm()) continue;
    for (const std::uint32_t j : added) pose[j].reset();
    return std::nullopt;
  }
  return place;
}

void UsdSkel::bind_objects() {
  std::size_t bytes_of_one = bytes_of_joint * rest_.size();
  for (const std::string& token : tokens_) bytes_of_one += token.size();
  std::size_t vertex = 0, object = 0;
  for (const gltf::RigPart& part : rig_.parts) {
    if (object < surface_.objects.size() && vertex >= surface_.objects[object].first_vertex) {
      std::size_t s = 0;
      while (s < poses_.size() && !bound(part, poses_[s])) ++s;
      if (s == poses_.size()) {
        if ((s + 1) * bytes_of_one > most_bytes) refuse_skeletons();
        poses_.emplace_back(rest_.size());
        if (!bound(part, poses_[s]))
          throw base::BakeError("--usd-skel: the skin of \"" + surface_.objects[object].name +
                                "\" has two bind poses for one joint; leave the option out");
      }
      skeleton_of_.push_back(s);
      ++object;
    }
    raw_to_world_.push_back(bound(part, poses_[skeleton_of_.back()]).value_or(Matrix4d::Identity()));
    vertex += part.positions.size();
  }
  if (skeleton_of_.size() != surface_.objects.size() || rest_.empty())
    throw base::BakeError("--usd-skel: the character's file does not hold the surface's objects; bake again");
}

std::string UsdSkel::joint_list() const {
  std::string text =
      std::string("uniform token[] joints = [") + (has_top_ ? usd_string(name_of_top) + ", " : "");
  for (std::size_t j = 0; j < tokens_.size(); ++j) text += (j == 0 ? "" : ", ") + usd_string(tokens_[j]);
  return text + ']';
}

std::string UsdSkel::skeleton(std::size_t number, int level) const {
  const Matrix4d from_world = rig_.character.root.inverse();
  std::vector<Matrix4d> bind(has_top_ ? 1 : 0, Matrix4d::Identity());
  std::vector<Matrix4d> rest = bind;
  for (std::size_t j = 0; j < rest_.size(); ++j) {
    bind.push_back(from_world * poses_[number][j].value_or(rest_[j]));
    rest.push_back(rig_.character.skeleton[j].rest_local);
  }
  return usd_line(level, "def Skeleton \"Skeleton_" + std::to_string(number) + "\" (") +
         usd_line(level + 1, "prepend apiSchemas = [\"SkelBindingAPI\"]") + usd_line(level, ")") +
         usd_line(level, "{") + usd_line(level + 1, joint_list()) +
         usd_line(level + 1, "uniform matrix4d[] bindTransforms = " + matrix_list(bind)) +
         usd_line(level + 1, "uniform matrix4d[] restTransforms = " + matrix_list(rest)) +
         usd_line(level + 1, "rel skel:animationSource = <" + path_ + "/Motion>") + usd_line(level, "}");
}

void UsdSkel::write_motion(base::PartFile& file, const UsdTimes& times, int level) const {
  file.write(usd_line(level, "def SkelAnimation \"Motion\"") + usd_line(level, "{") +
             usd_line(level + 1, joint_list()));
  const auto samples = [&](const char* attribute, const std::vector<float>& at_top, const auto& value) {
    file.write(usd_line(level + 1, std::string(attribute) + ".timeSamples = {"));
    for (std::uint64_t k = 0; k <= times.frames; ++k) {
      std::vector<float> values;
      if (has_top_) values.assign(at_top.begin(), at_top.end());
      for (const rig::JointParts& parts : baked_parts(rig_, has_clip_, k, times.fps))
        for (const double v : value(parts)) values.push_back(static_cast<float>(v));
      file.write(usd_line(level + 2, base::number_text(times.first_number + k) + ": " +
                                         usd_tuples(values, at_top.size()) + ','));
    }
    file.write(usd_line(level + 1, "}"));
  };
  const auto triple = [](const Vector3d& v) { return std::array<double, 3>{v.x(), v.y(), v.z()}; };
  samples("float3[] translations", {0, 0, 0},
          [&](const rig::JointParts& p) { return triple(p.translation); });
  samples("quatf[] rotations", {1, 0, 0, 0}, [](const rig::JointParts& p) {
    const Eigen::Vector4d& q = p.rotation;
    return std::array<double, 4>{q[3], q[0], q[1], q[2]};
  });
  samples("half3[] scales", {1, 1, 1}, [&](const rig::JointParts& p) { return triple(p.scale); });
  file.write(usd_line(level, "}"));
}

std::string UsdSkel::mesh(std::size_t number, int level) const {
  const SurfaceObject& object = surface_.objects[number];
  const Matrix4d from_world = rig_.character.root.inverse();
  std::vector<float> points, weights;
  std::vector<std::uint32_t> joints;
  std::size_t width = 1, vertex = 0;
  const auto each_part = [&](const auto& use) {
    vertex = 0;
    for (std::size_t p = 0; p < rig_.parts.size(); vertex += rig_.parts[p].positions.size(), ++p)
      if (vertex >= object.first_vertex && vertex < object.first_vertex + object.vertex_count)
        use(rig_.parts[p], from_world * raw_to_world_[p]);
  };
  each_part([&](const gltf::RigPart& part, const Matrix4d&) {
    for (std::size_t i = 0; i + 1 < part.influence_offset.size(); ++i)
      width = std::max<std::size_t>(width, part.influence_offset[i + 1] - part.influence_offset[i]);
  });
  each_part([&](const gltf::RigPart& part, const Matrix4d& map) {
    const std::vector<Vector3d> places = gltf::shaped_positions(part, nullptr, 0.0);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Vector3d place = map.topLeftCorner<3, 3>() * places[i] + map.topRightCorner<3, 1>();
      for (const double x : {place.x(), place.y(), place.z()}) points.push_back(static_cast<float>(x));
      const std::size_t first = part.influence_offset[i], count = part.influence_offset[i + 1] - first;
      for (std::size_t k = 0; k < width; ++k) {
        joints.push_back(k < count ? part.skin_joint[part.slot[first + k]] + (has_top_ ? 1 : 0) : 0);
        weights.push_back(k < count ? static_cast<float>(part.weight[first + k]) : 0.0f);
      }
    }
  });
  const UsdMesh mesh = usd_mesh(surface_, object, materials_, "SkelBindingAPI", level);
  const auto primvar = [&](const std::string& declared, const std::string& values) {
    return usd_line(level + 1, declared + " = " + values + " (") +
           usd_line(level + 2, "elementSize = " + std::to_string(width)) +
           usd_line(level + 2, "interpolation = \"vertex\"") + usd_line(level + 1, ")");
  };
  std::string weight_list = "[";
  for (std::size_t i = 0; i < weights.size(); ++i)
    weight_list += (i == 0 ? "" : ", ") + base::number_text(weights[i]);
  return mesh.head + usd_line(level + 1, "point3f[] points = " + usd_tuples(points, 3)) +
         primvar("int[] primvars:skel:jointIndices", usd_numbers(joints)) +
         primvar("float[] primvars:skel:jointWeights", weight_list + ']') +
         usd_line(level + 1,
                  "matrix4d primvars:skel:geomBindTransform = " + matrix_text(Matrix4d::Identity())) +
         usd_line(level + 1, "rel skel:skeleton = <" + path_ + "/Skeleton_" +
                                 std::to_string(skeleton_of_[number]) + '>') +
         mesh.tail;
}

void UsdSkel::write(base::PartFile& file, const UsdTimes& times, int level) const {
  file.write(usd_line(level, "def SkelRoot \"" + path_.substr(path_.rfind('/') + 1) + "\"") +
             usd_line(level, "{") + usd_line(level + 1, "uniform token purpose = \"guide\"") +
             usd_line(level + 1, "matrix4d xformOp:transform = " + matrix_text(rig_.character.root)) +
             usd_line(level + 1, "uniform token[] xformOpOrder = [\"xformOp:transform\"]"));
  for (std::size_t s = 0; s < poses_.size(); ++s) file.write(skeleton(s, level + 1));
  write_motion(file, times, level + 1);
  // In a separate scope, because an object may have any name.
  file.write(usd_line(level + 1, "def Scope \"Meshes\"") + usd_line(level + 1, "{"));
  for (std::size_t k = 0; k < surface_.objects.size(); ++k) file.write(mesh(k, level + 2));
  file.write(usd_line(level + 1, "}") + usd_line(level, "}"));
}

}  // namespace fascicle::formats
