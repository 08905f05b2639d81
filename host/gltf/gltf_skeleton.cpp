#include "host/gltf/gltf_skeleton.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include <Eigen/LU>

#include "host/gltf/gltf_decode.h"
#include "host/gltf/gltf_library.h"
#include "host/gltf/gltf_limits.h"
#include "host/rig/pose.h"
#include "host/rig/pose_interpolation.h"
#include "host/rig/rig_math.h"

namespace fascicle::gltf {

using Eigen::Vector3d;
namespace {

rig::Joint make_joint(const tinygltf::Node& node) {
  rig::Joint joint;
  joint.name = node.name;
  if (!node.matrix.empty()) {
    joint.rest_local =
        Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());  // column-major, like Eigen's default
    joint.rest_translation = joint.rest_local.topRightCorner<3, 1>();
    return joint;
  }
  if (!node.translation.empty()) joint.rest_translation = Eigen::Map<const Vector3d>(node.translation.data());
  if (!node.scale.empty()) joint.rest_scale = Eigen::Map<const Vector3d>(node.scale.data());
  if (!node.rotation.empty()) {
    const std::vector<double>& q = node.rotation;
    const double length = std::sqrt(((q[0] * q[0] + q[1] * q[1]) + q[2] * q[2]) + q[3] * q[3]);
    for (int c = 0; c < 4; ++c) joint.rest_rotation[c] = q[static_cast<std::size_t>(c)] / length;
  }
  joint.rest_local = rig::local_transform(joint.rest_translation, joint.rest_rotation, joint.rest_scale);
  return joint;
}

// The skeleton's nodes, parents before children. The nodes above it are multiplied into `root`.
std::vector<int> skeleton_nodes(const tinygltf::Model& model, const std::vector<bool>& is_joint,
                                Eigen::Matrix4d& root) {
  const std::vector<int> parents = node_parents(model);
  const std::size_t count = model.nodes.size();
  std::vector<bool> is_moved(count, false), is_needed(count, false);
  for (const tinygltf::Animation& animation : model.animations) {
    for (const auto& channel : animation.channels)
      if (channel.target_path != "weights") is_moved[static_cast<std::size_t>(channel.target_node)] = true;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!is_joint[i]) continue;
    for (int n = static_cast<int>(i); n >= 0 && !is_needed[static_cast<std::size_t>(n)];
         n = parents[static_cast<std::size_t>(n)]) {
      is_needed[static_cast<std::size_t>(n)] = true;
    }
  }
  const auto needed_of = [&](const std::vector<int>& nodes) {
    std::vector<int> result;
    for (const int n : nodes) {
      if (is_needed[static_cast<std::size_t>(n)]) result.push_back(n);
    }
    return result;
  };

  std::vector<int> tops;
  for (std::size_t i = 0; i < count; ++i) {
    if (is_needed[i] && parents[i] < 0) tops.push_back(static_cast<int>(i));
  }
  while (tops.size() == 1) {
    const auto top = static_cast<std::size_t>(tops.front());
    if (is_joint[top] || is_moved[top]) break;
    root = (root * make_joint(model.nodes[top]).rest_local).eval();
    tops = needed_of(model.nodes[top].children);
  }

  std::vector<int> order, stack(tops.rbegin(), tops.rend());
  while (!stack.empty()) {
    const int n = stack.back();
    stack.pop_back();
    order.push_back(n);
    const std::vector<int> children = needed_of(model.nodes[static_cast<std::size_t>(n)].children);
    stack.insert(stack.end(), children.rbegin(), children.rend());
  }
  return order;
}

rig::Interpolation interpolation_of(const tinygltf::AnimationSampler& sampler) {
  return sampler.interpolation == "STEP"          ? rig::Interpolation::step
         : sampler.interpolation == "CUBICSPLINE" ? rig::Interpolation::cubic_spline
                                                  : rig::Interpolation::linear;
}

std::vector<double> read_times(const std::filesystem::path& path, const tinygltf::Model& model,
                               int accessor) {
  std::vector<double> times = accessor_numbers(path, model, accessor);
  for (std::size_t k = 1; k < times.size(); ++k) {
    if (!(times[k] > times[k - 1])) {
      gltf_error(path, "/accessors/" + std::to_string(accessor),
                 "key " + std::to_string(k) + " is not later than the one before");
    }
  }
  return times;
}

rig::Channel read_channel(const std::filesystem::path& path, const tinygltf::Model& model,
                          const tinygltf::AnimationSampler& sampler, const std::string& target_path) {
  rig::Channel channel;
  channel.path = target_path == "translation" ? rig::ChannelPath::translation
                 : target_path == "rotation"  ? rig::ChannelPath::rotation
                                              : rig::ChannelPath::scale;
  channel.interpolation = interpolation_of(sampler);
  channel.times = read_times(path, model, sampler.input);
  channel.values = accessor_numbers(path, model, sampler.output);
  if (channel.path == rig::ChannelPath::rotation) {
    const bool is_spline = channel.interpolation == rig::Interpolation::cubic_spline;
    for (std::size_t k = 0; k < channel.times.size(); ++k) {
      const double* q = channel.values.data() + (is_spline ? (3 * k + 1) * 4 : k * 4);
      const double square = ((q[0] * q[0] + q[1] * q[1]) + q[2] * q[2]) + q[3] * q[3];
      if (!(square > 0.25 && square < 4.0)) {
        gltf_error(path, "/accessors/" + std::to_string(sampler.output),
                   "key " + std::to_string(k) + " is not a quaternion of length 1");
      }
    }
  }
  return channel;
}

}  // namespace

std::vector<std::int32_t> read_skeleton(const std::filesystem::path& path, const tinygltf::Model& model,
                                        const GltfParts& parts, rig::Character& character) {
  const std::vector<int> parents = node_parents(model);
  std::vector<bool> is_joint(model.nodes.size(), false);
  for (const int s : parts.skins)
    for (const int n : model.skins[static_cast<std::size_t>(s)].joints)
      is_joint[static_cast<std::size_t>(n)] = true;
  for (const int n : parts.carriers) is_joint[static_cast<std::size_t>(n)] = true;
  const std::vector<int> nodes = skeleton_nodes(model, is_joint, character.root);
  std::vector<std::int32_t> joint_of(model.nodes.size(), -1);
  for (std::size_t j = 0; j < nodes.size(); ++j)
    joint_of[static_cast<std::size_t>(nodes[j])] = static_cast<std::int32_t>(j);

  for (const int n : nodes) {
    rig::Joint joint = make_joint(model.nodes[static_cast<std::size_t>(n)]);
    if (joint.name.empty()) joint.name = "node " + std::to_string(n);
    const int parent = parents[static_cast<std::size_t>(n)];
    joint.parent = parent < 0 ? -1 : joint_of[static_cast<std::size_t>(parent)];
    joint.skins = is_joint[static_cast<std::size_t>(n)];
    character.skeleton.push_back(std::move(joint));
  }

  const std::vector<Eigen::Matrix4d> rest = rig::joint_transforms_at(character, nullptr, 0.0);
  for (std::size_t j = 0; j < rest.size(); ++j) {
    const Eigen::Matrix3d linear = rest[j].topLeftCorner<3, 3>();
    const double size = linear.norm();
    // Relative to a uniform scale of the same size: 1e-12 is flat for any purpose, and too close to singular
    // to invert in double precision.
    if (!rest[j].allFinite() || !(std::abs(linear.determinant()) > 1e-12 * size * size * size)) {
      gltf_error(path, "/nodes/" + std::to_string(nodes[j]),
                 "the joint has a scale of zero in its rest pose; give it another scale");
    }
    character.skeleton[j].inverse_bind = rig::affine_inverse(rest[j]);
  }

  std::vector<bool> is_shown(model.nodes.size(), false);
  for (const GltfPart& part : parts.parts) is_shown[part.node] = true;
  KeyLimits limits(path, model);
  std::map<int, std::shared_ptr<const std::vector<double>>> weights_of;  // by accessor
  for (std::size_t a = 0; a < model.animations.size(); ++a) {
    const tinygltf::Animation& animation = model.animations[a];
    rig::Clip clip;
    clip.name = animation.name;
    for (const tinygltf::AnimationChannel& source : animation.channels) {
      const auto node = static_cast<std::size_t>(source.target_node);
      const auto& sampler = animation.samplers[static_cast<std::size_t>(source.sampler)];
      if (source.target_path == "weights") {
        if (!is_shown[node]) continue;
        limits.add(a, sampler.input);
        auto& values = weights_of[sampler.output];
        if (values == nullptr) {
          limits.add(a, sampler.output);
          values = std::make_shared<const std::vector<double>>(accessor_numbers(path, model, sampler.output));
        }
        rig::WeightChannel channel{.node = static_cast<std::uint32_t>(node),
                                   .interpolation = interpolation_of(sampler),
                                   .times = read_times(path, model, sampler.input),
                                   .values = values};
        clip.duration = std::max(clip.duration, channel.times.back());
        clip.weights.push_back(std::move(channel));
        continue;
      }
      if (joint_of[node] < 0) continue;
      limits.add(a, sampler.input);
      limits.add(a, sampler.output);
      rig::Channel channel = read_channel(path, model, sampler, source.target_path);
      channel.joint = static_cast<std::uint32_t>(joint_of[node]);
      clip.duration = std::max(clip.duration, channel.times.back());
      clip.channels.push_back(std::move(channel));
    }
    character.clips.push_back(std::move(clip));
  }
  return joint_of;
}

}  // namespace fascicle::gltf
