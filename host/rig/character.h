// A rigged character: its render mesh, its skeleton and its clips. Metres, seconds, Y up.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/mesh/mesh.h"

namespace fascicle::rig {

using Eigen::Vector3d;

struct Joint {
  std::string name;
  std::int32_t parent = -1;  // index into Skeleton::joints, before the child
  Eigen::Matrix4d rest_local =
      Eigen::Matrix4d::Identity();  // the node's local transform while no channel moves it
  Eigen::Matrix4d inverse_bind =
      Eigen::Matrix4d::Identity();               // mesh space (metres, bind pose) to joint space
  Vector3d rest_translation = Vector3d::Zero();  // rest_local decomposed, for channels that move only one
                                                 // part
  Eigen::Vector4d rest_rotation{0, 0, 0, 1};     // x y z w
  Vector3d rest_scale = Vector3d::Ones();
  bool skins = false;  // false: an intermediate node that no vertex follows
};

enum class Interpolation { step, linear, cubic_spline };
enum class ChannelPath { translation, rotation, scale };

struct Channel {
  std::uint32_t joint = 0;
  ChannelPath path = ChannelPath::translation;
  Interpolation interpolation = Interpolation::linear;
  std::vector<double> times;   // s, ascending
  std::vector<double> values;  // 3 or 4 per key; cubic_spline: in-tangent, value, out-tangent
  // cubic_spline: nonzero if the interval after this key is interpolated linearly; empty: none is.
  std::vector<char> straight = {};
};

// The weights of a part's blend shapes over time.
struct WeightChannel {
  std::uint32_t node = 0;  // in the file: SurfacePart::node
  Interpolation interpolation = Interpolation::linear;
  std::vector<double> times;  // s, ascending
  // One per shape and key; cubic_spline: in-tangents, values, out-tangents. Never null. Channels of many
  // parts may share them: a baked surface.glb has as many shapes as keys.
  std::shared_ptr<const std::vector<double>> values;
};

struct Clip {
  std::string name;
  double duration = 0.0;  // s; the last key of any channel
  std::vector<Channel> channels;
  std::vector<WeightChannel> weights = {};
};

// Values painted on a character's vertices: a glTF attribute whose name begins with _ or COLOR_. 0 on
// primitives that lack it. _FIBER is a direction in the bind pose, like the positions.
struct PaintedAttribute {
  std::string name;
  std::uint32_t width = 1;     // numbers per vertex, 1 to 4
  std::vector<double> values;  // `width` per vertex of the surface
};

// A range of the surface's vertices and triangles that came from one primitive of the file. The parts cover
// the surface in order. Parts of one node are one object of the scene.
struct SurfacePart {
  std::string object;      // the node's name, or its mesh's, or "mesh N"
  std::string material;    // empty: none, or one without a name
  std::uint32_t node = 0;  // in the file
  std::uint32_t first_vertex = 0, vertex_count = 0;
  std::uint32_t first_triangle = 0, triangle_count = 0;
};

// A rigged character: the render mesh in its bind pose, its weights, its joints and its clips.
struct Character {
  mesh::SurfaceMesh surface;                         // metres, vertex order of the file, seams not welded
  std::vector<std::array<std::uint32_t, 8>> joints;  // per vertex: indices into skeleton
  std::vector<std::array<double, 8>> weights;        // per vertex: sums to 1
  std::vector<Joint> skeleton;                       // parents before children
  std::vector<Clip> clips;
  std::vector<PaintedAttribute> painted;
  std::vector<SurfacePart> parts;                      // none: the surface is one part without names
  Eigen::Matrix4d root = Eigen::Matrix4d::Identity();  // transform above the skeleton's roots
  std::vector<std::string> notes;                      // where the character differs from the file
};

}  // namespace fascicle::rig
