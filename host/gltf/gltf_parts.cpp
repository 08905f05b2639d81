#include "host/gltf/gltf_parts.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "host/gltf/gltf_library.h"
#include "host/gltf/gltf_limits.h"
#include "host/rig/pose_interpolation.h"

namespace fascicle::gltf {
namespace {

std::vector<bool> nodes_in_scene(const tinygltf::Model& model) {
  std::vector<bool> is_in(model.nodes.size(), model.scenes.empty());
  if (model.scenes.empty()) return is_in;
  std::vector<int> stack = model.scenes[static_cast<std::size_t>(std::max(model.defaultScene, 0))].nodes;
  while (!stack.empty()) {
    const auto n = static_cast<std::size_t>(stack.back());
    stack.pop_back();
    if (is_in[n]) continue;
    is_in[n] = true;
    stack.insert(stack.end(), model.nodes[n].children.begin(), model.nodes[n].children.end());
  }
  return is_in;
}

bool is_of_triangles(const tinygltf::Primitive& primitive) {
  return primitive.mode == TINYGLTF_MODE_TRIANGLES || primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP ||
         primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN;
}

// Singular relative to a uniform scale of the same size; the same test as for a joint's rest pose.
bool is_flat(const Eigen::Matrix4d& m) {
  const Eigen::Matrix3d linear = m.topLeftCorner<3, 3>();
  const double size = linear.norm();
  return !m.allFinite() || !(std::abs(linear.determinant()) > 1e-12 * size * size * size);
}

void sort_unique(std::vector<int>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

std::vector<bool> marked_nodes(const nlohmann::json& document, std::size_t count) {
  std::vector<bool> is_marked(count, false);
  const auto nodes = document.find("nodes");
  if (nodes == document.end() || !nodes->is_array()) return is_marked;
  for (std::size_t n = 0; n < std::min(count, nodes->size()); ++n) {
    if (!(*nodes)[n].is_object()) continue;
    const auto extras = (*nodes)[n].find("extras");
    is_marked[n] = extras != (*nodes)[n].end() && extras->is_object() && extras->contains(carries_mark);
  }
  return is_marked;
}

constexpr std::size_t most_notes = 20;

class Finder {
 public:
  Finder(const std::filesystem::path& path, const tinygltf::Model& model, const nlohmann::json& document)
      : model_(model),
        limits_(path, model),
        parents_(node_parents(model)),
        is_in_(nodes_in_scene(model)),
        moves_(marked_nodes(document, model.nodes.size())) {}

  GltfParts run(Still still) {
    for (std::size_t n = 0; n < model_.nodes.size(); ++n)
      if (shows(n) && model_.nodes[n].skin >= 0) result_.skins.push_back(model_.nodes[n].skin);
    sort_unique(result_.skins);
    for (const int skin : result_.skins)
      for (const int joint : model_.skins[static_cast<std::size_t>(skin)].joints)
        moves_[static_cast<std::size_t>(joint)] = true;
    for (const tinygltf::Animation& animation : model_.animations)
      for (const auto& channel : animation.channels)
        if (channel.target_path != "weights") moves_[static_cast<std::size_t>(channel.target_node)] = true;
    take_what_moves();
    if (result_.parts.empty() && still == Still::carried) {
      for (std::size_t n = 0; n < model_.nodes.size(); ++n)
        if (shows(n)) moves_[topmost(n)] = true;
      result_.notes.clear();
      left_out_ = 0;
      take_what_moves();
    }
    sort_unique(result_.carriers);
    if (left_out_ > most_notes)
      result_.notes.push_back(std::to_string(left_out_ - most_notes) + " more meshes are left out");
    return std::move(result_);
  }

 private:
  bool shows(std::size_t node) const { return is_in_[node] && model_.nodes[node].mesh >= 0; }

  std::size_t topmost(std::size_t node) const {
    while (parents_[node] >= 0) node = static_cast<std::size_t>(parents_[node]);
    return node;
  }

  void take_what_moves() {
    hang_nodes();
    for (std::size_t n = 0; n < model_.nodes.size(); ++n) {
      if (!shows(n)) continue;
      GltfPart part;
      part.node = n;
      part.mesh = static_cast<std::size_t>(model_.nodes[n].mesh);
      part.skin = model_.nodes[n].skin;
      if (part.skin >= 0 || hang(part)) add(part);
    }
  }

  // How a node hangs from those above it.
  struct Hanging {
    int carrier = -1;  // the node itself, or the nearest above it that moves; -1: none
    Eigen::Matrix4d to_carrier = Eigen::Matrix4d::Identity(), to_world = Eigen::Matrix4d::Identity();
  };

  // Finds how each node hangs, from the topmost nodes down.
  void hang_nodes() {
    hanging_.assign(model_.nodes.size(), {});
    std::vector<std::size_t> stack;
    for (std::size_t n = 0; n < parents_.size(); ++n)
      if (parents_[n] < 0) stack.push_back(n);
    while (!stack.empty()) {
      const std::size_t n = stack.back();
      stack.pop_back();
      const Hanging above = parents_[n] < 0 ? Hanging() : hanging_[static_cast<std::size_t>(parents_[n])];
      const Eigen::Matrix4d own = node_transform(model_, n);
      hanging_[n].to_world = above.to_world * own;
      if (moves_[n]) {
        hanging_[n].carrier = static_cast<int>(n);
      } else if (above.carrier >= 0) {
        hanging_[n].carrier = above.carrier;
        hanging_[n].to_carrier = above.to_carrier * own;
      }
      for (const int child : model_.nodes[n].children) stack.push_back(static_cast<std::size_t>(child));
    }
  }

  // Finds the node that carries an unskinned part; false if the part is left out.
  bool hang(GltfPart& part) {
    const Hanging& hanging = hanging_[part.node];
    part.carrier = hanging.carrier;
    part.to_carrier = hanging.to_carrier;
    if (part.carrier < 0)
      return leave_out(part.node, "nothing moves it: no skin, joint or clip that moves its node");
    if (is_flat(hanging.to_world)) return leave_out(part.node, "its scale is zero in the rest pose");
    return true;
  }

  bool leave_out(std::size_t node, const std::string& why) {
    ++left_out_;
    if (result_.notes.size() == most_notes) return false;
    const std::string& name = model_.nodes[node].name;
    result_.notes.push_back("the mesh of node " + std::to_string(node) +
                            (name.empty() ? std::string() : " `" + name + "`") + " is left out: " + why);
    return false;
  }

  void add(GltfPart part) {
    const std::vector<tinygltf::Primitive>& primitives = model_.meshes[part.mesh].primitives;
    bool is_taken = false;
    for (std::size_t p = 0; p < primitives.size(); ++p) {
      if (part.skin < 0 && !is_of_triangles(primitives[p])) continue;
      part.primitive = p;
      limits_.add(part);
      result_.parts.push_back(part);
      is_taken = true;
    }
    if (!is_taken) {
      leave_out(part.node, "it has points or lines, no triangles");
    } else if (part.skin < 0) {
      result_.carriers.push_back(part.carrier);
    }
  }

  const tinygltf::Model& model_;
  PartLimits limits_;
  std::vector<int> parents_;
  std::vector<bool> is_in_;       // per node: in the default scene
  std::vector<bool> moves_;       // per node: a joint of a skin, marked, or animated by a clip
  std::vector<Hanging> hanging_;  // per node
  std::size_t left_out_ = 0;      // meshes
  GltfParts result_;
};

}  // namespace

GltfParts find_parts(const std::filesystem::path& path, const tinygltf::Model& model,
                     const nlohmann::json& document, Still still) {
  return Finder(path, model, document).run(still);
}

Eigen::Matrix4d node_transform(const tinygltf::Model& model, std::size_t number) {
  const tinygltf::Node& node = model.nodes[number];
  // Column-major, like Eigen's default.
  if (!node.matrix.empty()) return Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
  Eigen::Vector3d translation = Eigen::Vector3d::Zero(), scale = Eigen::Vector3d::Ones();
  Eigen::Vector4d rotation(0, 0, 0, 1);
  if (!node.translation.empty()) translation = Eigen::Map<const Eigen::Vector3d>(node.translation.data());
  if (!node.scale.empty()) scale = Eigen::Map<const Eigen::Vector3d>(node.scale.data());
  if (!node.rotation.empty()) rotation = Eigen::Map<const Eigen::Vector4d>(node.rotation.data());
  return rig::local_transform(translation, rotation, scale);
}

std::vector<int> node_parents(const tinygltf::Model& model) {
  std::vector<int> parents(model.nodes.size(), -1);
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    for (const int child : model.nodes[i].children)
      parents[static_cast<std::size_t>(child)] = static_cast<int>(i);
  }
  return parents;
}

}  // namespace fascicle::gltf
