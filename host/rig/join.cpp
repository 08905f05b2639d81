#include "host/rig/join.h"

#include <algorithm>
#include <cstddef>

#include "host/base/errors.h"
#include "host/rig/paint.h"
#include "host/rig/pose_interpolation.h"
#include "host/rig/rig_math.h"

namespace fascicle::rig {
namespace {

Eigen::Matrix4d moved_by(const Vector3d& offset) {
  Eigen::Matrix4d map = Eigen::Matrix4d::Identity();
  map.topRightCorner<3, 1>() = offset;
  return map;
}

void add_skeleton(const Placed& placed, Character& all) {
  const Character& one = *placed.character;
  const auto first = static_cast<std::int32_t>(all.skeleton.size());
  const Eigen::Matrix4d back = moved_by(-placed.bind_offset);
  Joint top;
  top.name = placed.name;
  top.parent = placed.bearer;
  top.rest_translation = placed.at;
  top.rest_rotation = placed.turn;
  top.rest_local = placed.place * one.root;
  // What follows this joint is rigid in the character's own bind pose.
  top.inverse_bind = affine_inverse(one.root) * back;
  all.skeleton.push_back(top);
  for (Joint joint : one.skeleton) {
    joint.parent = joint.parent < 0 ? first : first + 1 + joint.parent;
    joint.inverse_bind = (joint.inverse_bind * back).eval();
    all.skeleton.push_back(std::move(joint));
  }
}

void add_skin(const Placed& placed, std::uint32_t first_joint, Character& all) {
  const Character& one = *placed.character;
  const auto first_vertex = static_cast<std::uint32_t>(all.surface.vertices.size());
  const auto first_triangle = static_cast<std::uint32_t>(all.surface.triangles.size());
  for (const Vector3d& p : one.surface.vertices) all.surface.vertices.push_back(p + placed.bind_offset);
  for (const auto& t : one.surface.triangles)
    all.surface.triangles.push_back({t[0] + first_vertex, t[1] + first_vertex, t[2] + first_vertex});
  for (std::array<std::uint32_t, 8> joints : one.joints) {
    for (std::uint32_t& joint : joints) joint += first_joint + 1;
    all.joints.push_back(joints);
  }
  all.weights.insert(all.weights.end(), one.weights.begin(), one.weights.end());
  for (SurfacePart part : one.parts) {
    part.node += placed.first_node;
    part.first_vertex += first_vertex;
    part.first_triangle += first_triangle;
    all.parts.push_back(std::move(part));
  }
  if (one.parts.empty())
    all.parts.push_back({.object = placed.name,
                         .material = {},
                         .node = placed.first_node,
                         .first_vertex = first_vertex,
                         .vertex_count = static_cast<std::uint32_t>(one.surface.vertices.size()),
                         .first_triangle = first_triangle,
                         .triangle_count = static_cast<std::uint32_t>(one.surface.triangles.size())});
}

void add_clip(const Placed& placed, std::uint32_t first_joint, Clip& all) {
  if (placed.clip == nullptr) return;
  const auto shift = [&](std::vector<double>& times) {
    for (double& time : times) time += placed.start;
    if (!times.empty()) all.duration = std::max(all.duration, times.back());
  };
  for (Channel channel : placed.clip->channels) {
    channel.joint += first_joint + 1;
    shift(channel.times);
    all.channels.push_back(std::move(channel));
  }
  for (WeightChannel channel : placed.clip->weights) {
    channel.node += placed.first_node;
    shift(channel.times);
    all.weights.push_back(std::move(channel));
  }
  all.duration = std::max(all.duration, placed.clip->duration + placed.start);
  all.name += (all.name.empty() ? "" : " + ") + placed.name + "/" + placed.clip->name;
}

// Characters that lack the attribute get value_elsewhere.
void add_painted(const Placed& placed, std::size_t first_vertex, Character& all) {
  for (PaintedAttribute one : placed.character->painted) {
    auto found = std::find_if(all.painted.begin(), all.painted.end(),
                              [&](const PaintedAttribute& a) { return a.name == one.name; });
    if (found == all.painted.end())
      found = all.painted.insert(all.painted.end(), PaintedAttribute{one.name, one.width, {}});
    if (find_paint_kind(one.name) != nullptr && found->width != one.width)
      throw base::SceneError("`" + one.name + "` has " + std::to_string(one.width) +
                             " numbers on character " + placed.name + " and " + std::to_string(found->width) +
                             " on another; paint the same count on both, or rename one of them");
    widen(*found, one.width);
    widen(one, found->width);
    found->values.resize(first_vertex * one.width, value_elsewhere(one.name));
    found->values.insert(found->values.end(), one.values.begin(), one.values.end());
  }
}

}  // namespace

void name_apart(Character& character, const std::string& name) {
  for (Joint& joint : character.skeleton) joint.name = name + "/" + joint.name;
  for (SurfacePart& part : character.parts) {
    part.object = name + "/" + part.object;
    if (!part.material.empty()) part.material = name + "/" + part.material;
  }
}

std::uint32_t node_count(const Character& character) {
  std::uint32_t count = 1;
  for (const SurfacePart& part : character.parts) count = std::max(count, part.node + 1);
  for (const Clip& clip : character.clips)
    for (const WeightChannel& channel : clip.weights) count = std::max(count, channel.node + 1);
  return count;
}

Character joined(std::span<const Placed> characters) {
  Character all;
  Clip clip;
  bool plays = false;
  for (const Placed& placed : characters) {
    const auto first_joint = static_cast<std::uint32_t>(all.skeleton.size());
    add_painted(placed, all.surface.vertices.size(), all);
    add_skeleton(placed, all);
    add_skin(placed, first_joint, all);
    add_clip(placed, first_joint, clip);
    plays = plays || placed.clip != nullptr;
    for (const std::string& note : placed.character->notes) all.notes.push_back(placed.name + ": " + note);
  }
  for (PaintedAttribute& painted : all.painted)
    painted.values.resize(all.surface.vertices.size() * painted.width, value_elsewhere(painted.name));
  if (plays) all.clips.push_back(std::move(clip));
  return all;
}

}  // namespace fascicle::rig
