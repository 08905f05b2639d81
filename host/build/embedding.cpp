#include "host/build/embedding.h"

namespace fascicle::build {

RenderMesh surface_render_mesh(const scene::SurfaceMesh& surface, std::span<const std::uint32_t> welded) {
  RenderMesh render;
  render.triangles = surface.triangles;
  render.corners.reserve(surface.vertices.size());
  render.weights.reserve(surface.vertices.size());
  for (const std::uint32_t vertex : welded) ride_on_vertex(render, vertex);
  return render;
}

}  // namespace fascicle::build
