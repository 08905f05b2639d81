// How render vertices ride on the body.
#pragma once

#include <span>

#include "host/build/body.h"

namespace fascicle::build {

// Appends a render vertex that is vertex `vertex` of the body. Its three idle corners name the same vertex,
// so that no vertex elsewhere can reach it.
inline void ride_on_vertex(RenderMesh& render, std::uint32_t vertex) {
  render.corners.push_back({vertex, vertex, vertex, vertex});
  render.weights.push_back({1.0, 0.0, 0.0, 0.0});
}

// The render mesh of a surface whose welded vertices are the body's first ones. `welded` leads from each
// vertex of the surface to the body's vertex.
RenderMesh surface_render_mesh(const scene::SurfaceMesh& surface, std::span<const std::uint32_t> welded);

}  // namespace fascicle::build
