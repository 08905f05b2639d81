#include "host/cli/rest_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>

#include "host/formats/surface.h"
#include "host/model/surroundings.h"
#include "host/render/body_shapes.h"
#include "host/render/camera.h"
#include "host/render/model_surface.h"
#include "host/render/render.h"
#include "host/render/shape.h"

namespace fascicle::cli {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

// For each vertex, the first one at the same position.
std::vector<std::uint32_t> welded(const std::vector<float>& positions) {
  std::map<std::array<float, 3>, std::uint32_t> first;
  std::vector<std::uint32_t> numbers(positions.size() / 3);
  for (std::uint32_t i = 0; i < numbers.size(); ++i)
    numbers[i] = first.emplace(std::array{positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]}, i)
                     .first->second;
  return numbers;
}

// Edges that belong to a single triangle.
std::vector<Edge> open_edges(const std::vector<std::uint32_t>& weld,
                             const std::vector<std::uint32_t>& triangles) {
  std::map<Edge, std::uint32_t> uses;
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = weld[triangles[t + k]], b = weld[triangles[t + (k + 1) % 3]];
      if (a != b) ++uses[std::minmax(a, b)];
    }
  std::vector<Edge> open;
  for (const auto& [edge, count] : uses)
    if (count == 1) open.push_back(edge);
  return open;
}

// Faces that belong to a single tetrahedron, oriented outward.
std::vector<std::uint32_t> outer_faces(const model::Model& model) {
  constexpr std::array<std::array<std::size_t, 3>, 4> sides{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
  std::map<std::array<std::uint32_t, 3>, std::array<std::uint32_t, 3>> faces;
  for (std::size_t t = 0; t + 3 < model.tetrahedron.size(); t += 4)
    for (const auto& side : sides) {
      const std::array<std::uint32_t, 3> face{model.tetrahedron[t + side[0]], model.tetrahedron[t + side[1]],
                                              model.tetrahedron[t + side[2]]};
      std::array<std::uint32_t, 3> key = face;
      std::sort(key.begin(), key.end());
      if (const auto [at, is_new] = faces.emplace(key, face); !is_new) faces.erase(at);
    }
  std::vector<std::uint32_t> list;
  for (const auto& [key, face] : faces) list.insert(list.end(), face.begin(), face.end());
  return list;
}

Eigen::Vector3f point(const std::vector<float>& positions, std::uint32_t i) {
  return {positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]};
}

// A band along each edge, facing the camera and slightly in front of the edge.
render::Shape bands(const std::vector<float>& positions, const std::vector<Edge>& edges,
                    const Eigen::Vector3f& eye, float width) {
  render::Shape shape;
  shape.finish = render::Finish::ink;
  shape.casts_shadow = false;
  for (const auto& [a, b] : edges) {
    const Eigen::Vector3f from = point(positions, a), to = point(positions, b);
    const Eigen::Vector3f ahead = (eye - 0.5f * (from + to)).normalized();
    const Eigen::Vector3f side = width * (to - from).cross(ahead).normalized();
    if (!side.allFinite()) continue;
    const auto first = static_cast<std::uint32_t>(shape.positions.size());
    for (const Eigen::Vector3f& corner : {Eigen::Vector3f(from - side), Eigen::Vector3f(from + side),
                                          Eigen::Vector3f(to + side), Eigen::Vector3f(to - side)}) {
      shape.positions.push_back(corner + 2.0f * width * ahead);
      shape.colours.emplace_back(0.75f, 0.03f, 0.02f);
    }
    shape.triangles.push_back({first, first + 1, first + 2});
    shape.triangles.push_back({first, first + 2, first + 3});
  }
  return shape;
}

// Cuts through the middle of the body, across its thinnest axis, and removes the half facing the camera.
render::Clip middle_clip(const Eigen::AlignedBox3d& box, const Eigen::Matrix3d& axes) {
  render::Clip clip;
  box.sizes().minCoeff(&clip.axis);
  clip.place = box.center()[clip.axis];
  clip.keeps_below = axes(2, clip.axis) >= 0.0;
  return clip;
}

}  // namespace

ShellCounts count_shell(const std::vector<float>& positions, const std::vector<std::uint32_t>& triangles) {
  const std::vector<std::uint32_t> weld = welded(positions);
  std::vector<std::uint32_t> part(weld.size());
  std::iota(part.begin(), part.end(), 0U);
  const auto root = [&part](std::uint32_t i) {
    while (part[i] != i) i = part[i] = part[part[i]];
    return i;
  };
  std::vector<bool> is_used(weld.size(), false);
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t i = weld[triangles[t + k]];
      is_used[i] = true;
      part[root(i)] = root(weld[triangles[t]]);
    }
  ShellCounts counts;
  counts.triangles = triangles.size() / 3;
  counts.open_edges = open_edges(weld, triangles).size();
  for (std::uint32_t i = 0; i < weld.size(); ++i) {
    counts.vertices += is_used[i] ? 1 : 0;
    counts.parts += is_used[i] && root(i) == i ? 1 : 0;
  }
  return counts;
}

RestPictures draw_rest(const model::Model& model, const render::Looks* looks, unsigned height,
                       unsigned threads) {
  const std::vector<float> body = formats::world_positions(model.rest, model.unit, model.rest_origin);
  const std::vector<float> skin =
      formats::world_positions(formats::embed(model, model.rest), model.unit, model.rest_origin);
  // Count only vertices of outer faces, so that the body's counts are those of a surface.
  const std::vector<std::uint32_t> faces = outer_faces(model);
  RestPictures pictures;
  pictures.skin = count_shell(skin, model.surface_triangle);
  pictures.body = count_shell(body, faces);

  const render::View view{35.0, 10.0};
  const Eigen::Matrix3d axes = render::camera_axes(view);
  const std::vector<char> is_beside = model::surroundings_of(model).vertices;
  Eigen::AlignedBox3d box, seen;
  std::vector<Eigen::Vector3d> places;
  for (std::uint32_t i = 0; i < body.size() / 3; ++i) {
    if (is_beside[i] != 0) continue;
    places.emplace_back(point(body, i).cast<double>());
    box.extend(places.back());
    seen.extend(Eigen::Vector3d(axes * places.back()));
  }
  const double aspect = seen.sizes().y() > 0.0 ? seen.sizes().x() / seen.sizes().y() : 1.0;
  const auto width = static_cast<unsigned>(std::lround(std::clamp(aspect, 0.6, 1.78) * height));
  render::CameraFit fit(view, width, height);
  for (const Eigen::Vector3d& place : places) fit.include(place);
  const render::Camera camera = fit.camera();
  render::Backdrop backdrop;
  backdrop.ground = box.min().y();
  const Eigen::Vector3f eye = camera.eye.cast<float>();
  const std::vector<float> no_lag(model.vertex_count, 0.0f);
  const auto draw = [&](const render::DrawingOptions& options, const std::vector<Edge>& marked) {
    const render::BodyDrawing drawing(model, options);
    std::vector<render::Shape> shapes = drawing.shapes(body, no_lag, eye);
    if (!marked.empty())
      shapes.push_back(bands(skin, marked, eye, static_cast<float>(0.0018 * box.diagonal().norm())));
    pictures.layers = drawing.legend();
    return render::render(shapes, camera, backdrop, threads);
  };
  render::DrawingOptions options;
  options.looks = looks;
  pictures.before = draw(options, open_edges(welded(skin), model.surface_triangle));
  options.tetrahedra = true;
  pictures.after = draw(options, {});
  options.mode = render::Mode::layers;
  options.clip = middle_clip(box, axes);
  pictures.cut = draw(options, {});
  return pictures;
}

}  // namespace fascicle::cli
