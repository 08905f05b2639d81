// Body: all geometry is converted to one before it is numbered and flattened. It holds a tetrahedral mesh in
// metres, the render mesh that rides on it and, for a character, the skin weights of every vertex. Later
// stages do not depend on where a mesh came from.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/build/build.h"
#include "host/scene/scene.h"

namespace fascicle::build {

using scene::Vector3d;

// The mesh that is drawn, in its own vertex order. Each vertex is the weighted mean of four vertices of the
// body.
struct RenderMesh {
  std::vector<std::array<std::uint32_t, 4>> corners;
  std::vector<std::array<double, 4>> weights;  // each sums to 1
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

// Joints and weights of each vertex, CSR; at most 8 per vertex, summing to 1. Empty without a skeleton.
struct SkinWeights {
  std::vector<std::uint32_t> offset;
  std::vector<std::uint32_t> joint;
  std::vector<double> weight;
};

// A bone as a line segment in the bind pose, metres. `owners` are joints (-1: none): the bone's joint, its
// parent and the joint the bone leads to. A vertex with enough weight on one of them counts this bone as its
// own (Measures::nearest_bones). A bone of a scene without a skeleton has no owners and counts for every
// vertex.
struct Bone {
  Vector3d from, to;
  std::array<std::int32_t, 3> owners{-1, -1, -1};
};

// What a joint means for the vertices that follow it.
struct JointUse {
  std::string name;
  std::int32_t parent = -1;   // index of the next joint above
  std::int32_t bone = -1;     // the joint that is a bone, this one or an ancestor; -1: none
  bool is_kinematic = false;  // its flesh follows the skeleton
  // Its flesh does not, however far from a bone: it hangs on a trunk, or the scene simulates it.
  bool is_free = false;
};

// Why a vertex follows the skeleton whatever its layer: it lies under a rigid part of the skin, or it belongs
// to a rigid part's carrier (rigid_parts.h), a tetrahedron separate from the flesh.
enum class Holding : std::uint8_t { none, covered, carrier };

// One of several characters in a body.
struct BodyMember {
  std::uint32_t first_joint = 0;       // joints from here to the next member's move its vertices
  Vector3d offset = Vector3d::Zero();  // m: from its own bind pose to its place in the body
  bool is_rigid = false;               // all of its vertices follow the skeleton
};

struct Body {
  mesh::TetMesh mesh;
  std::vector<Holding> holding;  // per vertex; empty: none for all
  RenderMesh render;
  SkinWeights skin;
  std::uint32_t joint_count = 0;
  std::vector<JointUse> joints;  // joint_count, or empty: every joint is its own bone, none is kinematic
  std::vector<Bone> bones;
  mesh::SurfaceMesh skin_surface;              // a character's own skin, m, in its vertex order; else empty
  std::vector<rig::PaintedAttribute> painted;  // on its vertices
  std::vector<rig::SurfacePart> parts;         // of it
  std::vector<BodyMember> members;             // of several characters, ascending; else empty
};

// The number of the member that a vertex belongs to; 0 unless there are several.
std::size_t member_of(const Body& body, std::size_t vertex);
// Where a vertex lies in the bind pose of its own character, m.
Vector3d own_place(const Body& body, std::size_t vertex);
// The longest diagonal of a member's bounding box, or the whole body's, m.
double diagonal_of_member(const Body& body);

inline Holding holding_of(const Body& body, std::size_t vertex) {
  return body.holding.empty() ? Holding::none : body.holding[vertex];
}

// The bones of one character of the scene, as make_body chooses them: without the skin of floors, and of
// large parts that were requested to be rigid. If there would be none, without all rigid parts or without
// small parts, too, but not of a prop. Throws scene::SceneError.
struct BoneChoice;
BoneChoice bones_of(const rig::Character& character, const scene::Scene& scene, bool is_prop = false);

// Builds the body of a scene's geometry. Repairs and warnings go to the report. Throws scene::SceneError.
Body make_body(const scene::Scene& scene, Report& report, const BuildOptions& options);

}  // namespace fascicle::build
