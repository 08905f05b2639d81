#include "host/build/ties.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "host/build/boundary.h"
#include "host/build/message.h"
#include "host/build/points.h"
#include "host/build/surface_search.h"

namespace fascicle::build {

namespace {

using Eigen::Vector3d;
using model::Model;

// In working units. Anything lower is within the rounding of positions.
constexpr double lowest_tie = 0x1p-16;

// Normal of a triangle, as long as twice its area.
Vector3d area_of(const mesh::SurfaceMesh& surface, std::uint32_t triangle) {
  const auto& [a, b, c] = surface.triangles[triangle];
  return (surface.vertices[b] - surface.vertices[a]).cross(surface.vertices[c] - surface.vertices[a]);
}

// The distance of s from the plane of a triangle, on either side.
double height_over(const mesh::SurfaceMesh& below, std::uint32_t triangle, std::uint32_t s) {
  const Vector3d n = area_of(below, triangle);
  return std::abs(n.dot(below.vertices[s] - below.vertices[below.triangles[triangle][0]])) / n.norm();
}

// For each vertex, the triangles it is a corner of.
std::vector<std::vector<std::uint32_t>> triangles_of_vertices(const mesh::SurfaceMesh& surface) {
  std::vector<std::vector<std::uint32_t>> triangles(surface.vertices.size());
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    for (const std::uint32_t corner : surface.triangles[t]) triangles[corner].push_back(t);
  return triangles;
}

// Oriented towards s. If the nearest place is an edge or a corner, takes the triangle there over which s
// stands highest; among those that differ only by rounding, the first.
shader::Tie tie_of(std::uint32_t s, const mesh::SurfaceMesh& below, const SurfaceSearch& search,
                   const std::vector<std::vector<std::uint32_t>>& triangles_of) {
  const SurfacePoint place = search.nearest(below.vertices[s]);
  std::uint32_t best = place.triangle;
  double highest = height_over(below, best, s);
  const std::array<std::uint32_t, 3> near = below.triangles[place.triangle];
  for (std::size_t k = 0; k < 3; ++k) {
    for (const std::uint32_t t : triangles_of[near[k]]) {
      const bool at_place = std::all_of(near.begin(), near.end(), [&](std::uint32_t corner) {
        const auto& other = below.triangles[t];
        const std::size_t which =
            static_cast<std::size_t>(std::find(near.begin(), near.end(), corner) - near.begin());
        return !(place.weights[which] > 0.0) || std::find(other.begin(), other.end(), corner) != other.end();
      });
      if (!at_place || !(height_over(below, t, s) > highest * (1.0 + 1e-9))) continue;
      best = t;
      highest = height_over(below, t, s);
    }
  }
  const auto& [a, b, c] = below.triangles[best];
  const bool faces = area_of(below, best).dot(below.vertices[s] - below.vertices[a]) > 0.0;
  return {s, a, faces ? b : c, faces ? c : b, 0.0f, 0.0f, 0.0f, static_cast<float>(highest)};
}

std::array<std::uint32_t, 3> corners_of(const shader::Tie& tie) {
  return {tie.corner_a, tie.corner_b, tie.corner_c};
}

// The corners' mobilities, and for each vertex the ties that act on it, with the share times w_i / w_s.
void write_coefficients(Model& model) {
  const std::size_t n = model.vertex_count;
  std::vector<std::uint32_t> ties_at(n, 0);  // n_j
  for (const shader::Tie& tie : model.tie)
    for (const std::uint32_t j : corners_of(tie)) ++ties_at[j];
  std::vector<std::vector<std::pair<std::uint32_t, float>>> of_vertex(n);
  for (std::uint32_t t = 0; t < model.tie.size(); ++t) {
    shader::Tie& tie = model.tie[t];
    const auto ratio = [&](std::uint32_t i) {
      return model.is_kinematic(i) ? 0.0 : model.mass[tie.sliding] / model.mass[i];
    };
    const auto mobility = [&](std::uint32_t j) { return model::as_factor(ties_at[j] * ratio(j)); };
    tie.mobility_a = mobility(tie.corner_a);
    tie.mobility_b = mobility(tie.corner_b);
    tie.mobility_c = mobility(tie.corner_c);
    const auto add = [&](std::uint32_t i) {
      const float coefficient = model::as_factor(tie_share * ratio(i));
      if (coefficient != 0.0f) of_vertex[i].emplace_back(t, coefficient);
    };
    add(tie.sliding);
    for (const std::uint32_t j : corners_of(tie)) add(j);
  }
  model.tie_offset.push_back(0);
  for (const auto& entries : of_vertex) {
    for (const auto& [tie, coefficient] : entries) {
      model.tie_index.push_back(tie);
      model.tie_coefficient.push_back(coefficient);
    }
    model.tie_offset.push_back(static_cast<std::uint32_t>(model.tie_index.size()));
  }
}

void refuse_layers_on_nothing(const scene::Scene& scene, const Model& model) {
  for (std::uint32_t l = 0; l < scene.layers.size(); ++l) {
    if (!scene.layers[l].sliding) continue;
    bool has_vertex = false, slides_on_flesh = false;
    for (std::uint32_t i = 0; i < model.vertex_count; ++i) has_vertex = has_vertex || model.layer_of(i) == l;
    for (const shader::Tie& tie : model.tie) {
      if (model.layer_of(tie.sliding) != l) continue;
      for (const std::uint32_t j : corners_of(tie))
        slides_on_flesh = slides_on_flesh || !model.is_kinematic(j);
    }
    if (has_vertex && !slides_on_flesh)
      fail(scene.source,
           "layers." + scene.layers[l].name +
               ".sliding: none of its free vertices lies on free flesh of another layer, so there is "
               "nothing to slide on; widen one of the two, or remove sliding");
  }
}

void warn_of_loose_parts(const Model& model, const std::vector<char>& slides, Report& report) {
  const Parts parts = connected_parts({model.ring_offset, model.ring});
  std::vector<char> held(parts.count, 0), skin(parts.count, 0);
  std::vector<std::uint32_t> lowest(parts.count, model.vertex_count);
  bool some = false;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const std::uint32_t p = parts.of_vertex[i];
    some = some || model.is_kinematic(i);
    held[p] = held[p] || model.is_kinematic(i);
    skin[p] = skin[p] || slides[i];
    lowest[p] = std::min(lowest[p], model.source_vertex[i]);
  }
  std::vector<std::uint32_t> loose;
  for (std::uint32_t p = 0; p < parts.count; ++p)
    if (skin[p] && !held[p]) loose.push_back(lowest[p]);
  std::sort(loose.begin(), loose.end());
  if (some && !loose.empty())
    warn_of_flesh(
        report,
        counted(loose.size(), "part of the sliding layers has", "parts of the sliding layers have") +
            " no vertex that is pinned or moved by bones: a layer that does not close around the body slides "
            "off it (vertex " +
            list_of(loose) + ")",
        loose);
}

}  // namespace

std::vector<char> of_sliding_layers(const scene::Scene& scene, const Model& model) {
  std::vector<char> slides;
  if (std::none_of(scene.layers.begin(), scene.layers.end(), [](const scene::Layer& l) { return l.sliding; }))
    return slides;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    slides.push_back(scene.layers[model.layer_of(i)].sliding);
  return slides;
}

std::vector<std::array<std::uint32_t, 3>> triangles_below(const Model& model,
                                                          const std::vector<char>& slides) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  if (slides.empty()) return triangles;
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4) {
    std::array<std::uint32_t, 3> triangle{};
    std::size_t corners = 0;
    for (std::size_t k = t; k < t + 4; ++k)
      if (!slides[model.tetrahedron[k]] && corners++ < 3) triangle[corners - 1] = model.tetrahedron[k];
    if (corners == 3) triangles.push_back(triangle);
  }
  return triangles;
}

OneRings without_sliding_pairs(const OneRings& rings, const Model& model, const std::vector<char>& slides,
                               const std::vector<char>& keeps) {
  const auto holds = [&](std::uint32_t i) {
    return model.is_kinematic(i) || (!keeps.empty() && keeps[i] != 0);
  };
  OneRings cut;
  cut.offset.push_back(0);
  for (std::uint32_t i = 0; i < rings.size(); ++i) {
    for (const std::uint32_t j : rings[i])
      if (slides[i] == slides[j] || holds(i) || holds(j)) cut.neighbour.push_back(j);
    cut.offset.push_back(static_cast<std::uint32_t>(cut.neighbour.size()));
  }
  return cut;
}

std::vector<Vector3d> sheet_normals(const OneRings& rings, const RestState& state, const Model& model,
                                    const std::vector<char>& slides, const std::string& source) {
  if (slides.empty()) return {};
  std::vector<Vector3d> normals(rings.size(), Vector3d::Zero());
  std::vector<char> in_sheet(rings.size(), 0);  // on the surface, in a layer that slides
  for (const auto& triangle : boundary_triangles(model, source)) {
    const auto& [a, b, c] = triangle;
    for (const std::uint32_t v : triangle) in_sheet[v] = slides[v];
    if (!slides[a] || !slides[b] || !slides[c]) continue;
    const Vector3d p = rest_at(state, b) - rest_at(state, a), q = rest_at(state, c) - rest_at(state, a);
    const Vector3d n(p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]);
    for (const std::uint32_t v : triangle) normals[v] += n;
  }
  for (std::uint32_t r = 0; r < rings.size(); ++r) {
    Vector3d& n = normals[r];
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const bool is_sheet =
        in_sheet[r] && !model.is_kinematic(r) && length > 0.0 &&
        std::all_of(rings[r].begin(), rings[r].end(), [&](std::uint32_t i) { return in_sheet[i] != 0; });
    n = is_sheet ? Vector3d(n / length) : Vector3d::Zero();
  }
  return normals;
}

void write_ties(const scene::Scene& scene, Model& model, Report& report) {
  const std::vector<char> slides = of_sliding_layers(scene, model);
  if (slides.empty()) return;
  mesh::SurfaceMesh below{{}, triangles_below(model, slides)};
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) below.vertices.push_back(vector_at(model.rest, i));
  std::vector<std::uint32_t> too_low;
  if (!below.triangles.empty()) {
    const SurfaceSearch search(below);
    const std::vector<std::vector<std::uint32_t>> triangles_of = triangles_of_vertices(below);
    for (std::uint32_t s = 0; s < model.vertex_count; ++s) {
      if (!slides[s] || model.is_kinematic(s)) continue;
      const shader::Tie tie = tie_of(s, below, search, triangles_of);
      if (!(double{tie.rest_height} >= lowest_tie))
        too_low.push_back(model.source_vertex[s]);
      else
        model.tie.push_back(tie);
    }
  }
  refuse_layers_on_nothing(scene, model);
  if (!model.tie.empty()) write_coefficients(model);
  std::sort(too_low.begin(), too_low.end());
  if (!too_low.empty())
    warn_of_flesh(report,
                  counted(too_low.size(), "vertex of a sliding layer is", "vertices of sliding layers are") +
                      " too close to the flesh below to be tied to it (vertex " + list_of(too_low) + ")",
                  too_low);
  warn_of_loose_parts(model, slides, report);
}

}  // namespace fascicle::build
