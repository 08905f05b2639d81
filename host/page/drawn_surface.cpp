#include "host/page/drawn_surface.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "host/base/errors.h"
#include "host/render/model_surface.h"

namespace fascicle::page {

namespace {

DrawnSurface tetrahedra_surface(const model::Model& model) {
  DrawnSurface surface;
  surface.is_tetrahedra = true;
  for (const render::OuterFace& face : render::outer_faces(model)) {
    const auto first = static_cast<std::uint32_t>(surface.source.size());
    const auto number = static_cast<std::uint32_t>(surface.triangles.size());
    for (const std::uint32_t corner : face.corners) {
      surface.source.push_back(corner);
      surface.normal.push_back(number);
      surface.layer.push_back(render::layer_of_tetrahedron(model, face.tetrahedron));
    }
    surface.triangles.push_back({first, first + 1, first + 2});
  }
  return surface;
}

}  // namespace

DrawnSurface drawn_surface(const model::Model& model) {
  DrawnSurface surface;
  if (model.surface_triangle.empty()) {
    surface = tetrahedra_surface(model);
  } else {
    render::CreasedSurface creased = render::creased_surface(model);
    surface.source = std::move(creased.vertex);
    surface.normal = std::move(creased.normal);
    surface.triangles = std::move(creased.triangles);
    for (const std::uint32_t s : surface.source)
      surface.layer.push_back(render::layer_of_surface_vertex(model, s));
  }
  if (surface.triangles.empty())
    throw base::BakeError("the bake has neither a surface nor tetrahedra to show");
  return surface;
}

std::vector<TriangleGroup> group_triangles(DrawnSurface& surface, std::span<const std::uint32_t> numbers) {
  std::vector<std::uint32_t> order(surface.triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return numbers[a] < numbers[b]; });
  constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> met(surface.source.size(), none), normal_met(surface.triangles.size() * 3, none);
  DrawnSurface sorted;
  sorted.is_tetrahedra = surface.is_tetrahedra;
  std::vector<TriangleGroup> groups;
  std::uint32_t normals = 0;
  for (const std::uint32_t t : order) {
    if (groups.empty() || groups.back().number != numbers[t]) groups.push_back({numbers[t], 0});
    ++groups.back().count;
    std::array<std::uint32_t, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = surface.triangles[t][k];
      if (met[vertex] == none) {
        met[vertex] = static_cast<std::uint32_t>(sorted.source.size());
        std::uint32_t& normal = normal_met[surface.normal[vertex]];
        if (normal == none) normal = normals++;
        sorted.source.push_back(surface.source[vertex]);
        sorted.normal.push_back(normal);
        sorted.layer.push_back(surface.layer[vertex]);
      }
      triangle[k] = met[vertex];
    }
    sorted.triangles.push_back(triangle);
  }
  surface = std::move(sorted);
  return groups;
}

}  // namespace fascicle::page
