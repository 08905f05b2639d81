// How render vertices ride on the body.
#pragma once

#include <span>

#include "host/build/body.h"
#include "host/build/body_mesh.h"

namespace fascicle::build {

// Appends a render vertex placed on vertex `vertex` of the body. Its three unused corners name the same
// vertex, so that no vertex elsewhere can influence it.
inline void ride_on_vertex(RenderMesh& render, std::uint32_t vertex) {
  render.corners.push_back({vertex, vertex, vertex, vertex});
  render.weights.push_back({1.0, 0.0, 0.0, 0.0});
}

// How far a skin vertex may stick out of its tetrahedron: its least barycentric coordinate.
inline constexpr double least_barycentric = -0.05;

// The render mesh of a surface on the body that was made from it.
//
// A vertex of a kept skin is a vertex of the body. One in a cage rides on a tetrahedron by barycentric
// coordinates, rounded to multiples of 2^-23 that sum to 1. Even in floats, this reproduces the rest pose to
// rounding and keeps a rigid motion rigid. The tetrahedron is the vertex's `home` if it contains the vertex
// down to `least_barycentric` and is moved by the same joints. Otherwise it is the best tetrahedron nearby,
// which trades sticking out against a difference in joints: a thigh's vertex does not ride on the other
// thigh, even if it lies inside it.
//
// `body_weights` and `skin_weights` are those of the body and of the welded skin, or empty. How far vertices
// stick out goes to the report, with a warning if it is more than allowed.
RenderMesh embed_surface(const mesh::SurfaceMesh& surface, const WeldedSurface& welded, const BodyMesh& body,
                         const SkinWeights& body_weights, const SkinWeights& skin_weights, Report& report);

// The overlap of two vertices' weights, or of a vertex's weights and a tetrahedron's mean at `weights`: 1 if
// they are equal, 0 if they share no joint. `skin_a` and `skin_b` may be the same.
double weight_agreement(const SkinWeights& skin_a, std::uint32_t a, const SkinWeights& skin_b,
                        const std::array<std::uint32_t, 4>& corners, const std::array<double, 4>& weights);

// Barycentric coordinates of a point in a tetrahedron of positive volume; they sum to 1.
std::array<double, 4> barycentric(const mesh::TetMesh& mesh, const std::array<std::uint32_t, 4>& tetrahedron,
                                  const Vector3d& point);

}  // namespace fascicle::build
