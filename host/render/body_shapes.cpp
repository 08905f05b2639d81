#include "host/render/body_shapes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <Eigen/Dense>

#include "host/model/surroundings.h"
#include "host/render/colour.h"

namespace fascicle::render {

namespace {

using model::Model;

Vector3f at(std::span<const float> values, std::uint32_t k) {
  return {values[std::size_t{3} * k], values[std::size_t{3} * k + 1], values[std::size_t{3} * k + 2]};
}

// Rest positions in metres.
Vector3d rest_of(const Model& model, std::uint32_t i) {
  const auto& origin = model.rest_origin;
  return Vector3d(origin[0], origin[1], origin[2]) + model.unit * at(model.rest, i).cast<double>();
}

// For surfaces whose colour carries no information.
Vector3f paper_tone() {
  return colour(0xd2d0cc);
}

std::vector<Vector3f> smooth_normals(const Shape& shape, std::span<const std::uint32_t> normal_of) {
  std::vector<Vector3f> sum(shape.positions.size(), Vector3f::Zero());
  for (const auto& t : shape.triangles) {
    // The cross product's length is twice the area: large triangles count more.
    const Vector3f normal =
        (shape.positions[t[1]] - shape.positions[t[0]]).cross(shape.positions[t[2]] - shape.positions[t[0]]);
    for (const std::uint32_t corner : t) sum[normal_of[corner]] += normal;
  }
  std::vector<Vector3f> normals;
  for (std::size_t k = 0; k < shape.positions.size(); ++k) {
    const Vector3f& normal = sum[normal_of[k]];
    const float length = normal.norm();
    normals.push_back(length > 0.0f ? Vector3f(normal / length) : Vector3f(Vector3f::UnitY()));
  }
  return normals;
}

Eigen::Matrix3f edges_at(std::span<const float> positions, const std::uint32_t* corner) {
  Eigen::Matrix3f edges;
  for (int k = 0; k < 3; ++k) edges.col(k) = at(positions, corner[k + 1]) - at(positions, corner[0]);
  return edges;
}

}  // namespace

BodyDrawing::BodyDrawing(const Model& model, const DrawingOptions& options)
    : model_(model), options_(options) {
  draws_tetrahedra_ =
      options.tetrahedra || options.clip || options.mode == Mode::fibres || model.surface_triangle.empty();
  const model::Surroundings surroundings = model::surroundings_of(model);
  if (!draws_tetrahedra_) {
    creased_ = creased_surface(model);
    for (std::uint32_t s = 0; s < model.surface_count(); ++s)
      surface_layer_.push_back(layer_of_surface_vertex(model, s));
    for (const std::uint32_t s : creased_.vertex) is_beside_.push_back(surroundings.surface[s]);
    return;
  }
  faces_ = outer_faces(model, options.clip);
  // What carries a floor is a tetrahedron that may be larger than the body.
  std::erase_if(faces_, [&](const OuterFace& face) { return surroundings.vertices[face.corners[0]] != 0; });
  if (faces_.empty())
    throw std::invalid_argument(options.clip ? "--clip leaves no tetrahedron; choose a place inside the body"
                                             : "there are no tetrahedra to draw");
  double sum = 0.0;
  std::vector<char> on_face(model.vertex_count, 0);
  for (const OuterFace& face : faces_)
    for (std::size_t k = 0; k < 3; ++k) {
      sum += (rest_of(model, face.corners[k]) - rest_of(model, face.corners[(k + 1) % 3])).norm();
      on_face[face.corners[k]] = 1;
    }
  edge_ = sum / (3.0 * static_cast<double>(faces_.size()));
  if (options.mode != Mode::fibres) return;
  std::vector<std::uint32_t> place(model.vertex_count, 0);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (on_face[i] != 0 && at(model.fibre, i).squaredNorm() > 0.0f) {
      fibre_vertices_.push_back(i);
      place[i] = static_cast<std::uint32_t>(fibre_vertices_.size());
    }
  fibre_tetrahedra_.resize(fibre_vertices_.size());
  for (std::uint32_t t = 0; t < model.tetrahedron_count(); ++t)
    for (std::size_t c = 0; c < 4; ++c)
      if (const std::uint32_t k = place[model.tetrahedron[std::size_t{4} * t + c]]; k > 0)
        fibre_tetrahedra_[k - 1].push_back(t);
}

Legend BodyDrawing::legend() const {
  Legend legend;
  switch (options_.mode) {
    case Mode::shaded:
      break;
    case Mode::layers:
      for (std::size_t k = 0; k < model_.layers.size(); ++k)
        legend.entries.push_back({model_.layers[k].name, layer_colour(model_.layers[k].name, k)});
      break;
    case Mode::fibres:
      legend.entries = {{"x", direction_colour(Vector3f::UnitX())},
                        {"y", direction_colour(Vector3f::UnitY())},
                        {"z", direction_colour(Vector3f::UnitZ())}};
      break;
    case Mode::lag:
    case Mode::contact: {
      constexpr int stops = 17;
      legend.is_scale = true;
      for (int k = 0; k < stops; ++k)
        legend.entries.push_back({"", scale_colour(static_cast<float>(k) / (stops - 1))});
      std::array<char, 32> text{};
      std::snprintf(text.data(), text.size(), "%.3g mm", options_.lag_scale * 1e3);
      legend.entries.front().name = "0";
      legend.entries.back().name = text.data();
      break;
    }
  }
  return legend;
}

bool BodyDrawing::shows_fibres() const {
  return !fibre_vertices_.empty();
}

Vector3f BodyDrawing::lag_colour(float lag) const {
  if (lag < 0.0f) return paper_tone();
  return scale_colour(options_.lag_scale > 0.0 ? lag / static_cast<float>(options_.lag_scale) : 0.0f);
}

Vector3f BodyDrawing::vertex_colour(std::uint32_t vertex, std::span<const float> lag) const {
  switch (options_.mode) {
    case Mode::layers: {
      const std::uint32_t layer = model_.layer_of(vertex);
      return layer_colour(model_.layers[layer].name, layer);
    }
    case Mode::lag:
    case Mode::contact:
      return lag_colour(lag[vertex]);
    case Mode::fibres:
      return paper_tone();
    case Mode::shaded:
      break;
  }
  return skin_tone();
}

// The colours of the looks instead of the skin's.
void BodyDrawing::paint(Shape& shape) const {
  const Looks& looks = *options_.looks;
  shape.finish = Finish::painted;
  shape.looks = &looks;
  shape.colours.clear();
  for (const std::uint32_t s : creased_.vertex) {
    shape.colours.push_back(looks.colours.empty() ? Vector3f(Vector3f::Ones()) : looks.colours[s]);
    if (!looks.uvs.empty()) shape.uvs.push_back(looks.uvs[s]);
  }
  for (const auto& triangle : creased_.triangles)
    shape.paints.push_back(looks.paint_of_vertex[creased_.vertex[triangle[0]]]);
}

Shape BodyDrawing::surface(std::span<const float> positions, std::span<const float> lag,
                           std::span<const float> placed) const {
  Shape shape;
  shape.finish = options_.mode == Mode::shaded ? Finish::skin : Finish::plain;
  shape.blend_colours = options_.mode != Mode::layers;
  for (const std::uint32_t s : creased_.vertex) {
    Vector3f place = placed.empty() ? Vector3f(Vector3f::Zero()) : at(placed, s);
    float distance = 0.0f, most = lag.empty() ? 0.0f : -1.0f;
    for (std::size_t c = 0; c < 4; ++c) {
      const std::uint32_t vertex = model_.surface_vertex[std::size_t{4} * s + c];
      const float weight = model_.surface_weight[std::size_t{4} * s + c];
      if (placed.empty()) place += weight * at(positions, vertex);
      if (lag.empty()) continue;
      distance += weight * std::max(lag[vertex], 0.0f);
      if (weight > 0.0f) most = std::max(most, lag[vertex]);
    }
    if (most < 0.0f) distance = most;
    shape.positions.push_back(place);
    shape.colours.push_back(
        options_.mode == Mode::layers ? layer_colour(model_.layers[surface_layer_[s]].name, surface_layer_[s])
        : options_.mode == Mode::lag || options_.mode == Mode::contact ? lag_colour(distance)
                                                                       : skin_tone());
  }
  shape.triangles = creased_.triangles;
  shape.is_beside = is_beside_;
  shape.normals = smooth_normals(shape, creased_.normal);
  if (options_.looks != nullptr && options_.mode == Mode::shaded) paint(shape);
  return shape;
}

Shape BodyDrawing::faces(std::span<const float> positions, std::span<const float> lag) const {
  Shape shape;
  shape.finish = options_.mode == Mode::shaded ? Finish::skin : Finish::plain;
  shape.draw_edges = options_.mode != Mode::fibres;
  for (const OuterFace& face : faces_) {
    const std::uint32_t first = static_cast<std::uint32_t>(shape.positions.size());
    for (const std::uint32_t corner : face.corners) shape.positions.push_back(at(positions, corner));
    const Vector3f across = (shape.positions[first + 1] - shape.positions[first])
                                .cross(shape.positions[first + 2] - shape.positions[first]);
    const float length = across.norm();
    const Vector3f normal = length > 0.0f ? Vector3f(across / length) : Vector3f(Vector3f::UnitY());
    shape.normals.insert(shape.normals.end(), 3, normal);
    if (options_.mode == Mode::layers) {
      const std::uint32_t layer = layer_of_tetrahedron(model_, face.tetrahedron);
      shape.colours.insert(shape.colours.end(), 3, layer_colour(model_.layers[layer].name, layer));
    } else {
      for (const std::uint32_t corner : face.corners) shape.colours.push_back(vertex_colour(corner, lag));
    }
    shape.triangles.push_back({first, first + 1, first + 2});
  }
  return shape;
}

Shape BodyDrawing::fibre_lines(std::span<const float> positions, const Vector3f& eye) const {
  Shape shape;
  shape.finish = Finish::ink;
  shape.casts_shadow = false;
  const float half_length = 0.42f * static_cast<float>(edge_),
              half_width = 0.045f * static_cast<float>(edge_);
  for (std::size_t k = 0; k < fibre_vertices_.size(); ++k) {
    const std::uint32_t i = fibre_vertices_[k];
    // The fibre as the flesh carries it: the mean deformation of the tetrahedra around it.
    const Vector3f rest = at(model_.fibre, i);
    Vector3f direction = Vector3f::Zero();
    for (const std::uint32_t t : fibre_tetrahedra_[k]) {
      const std::uint32_t* corner = &model_.tetrahedron[std::size_t{4} * t];
      const Eigen::Matrix3f before = edges_at(model_.rest, corner), now = edges_at(positions, corner);
      direction += now * (before.inverse() * rest) * std::fabs(before.determinant());
    }
    if (!(direction.norm() > 0.0f) || !direction.allFinite()) continue;
    direction.normalize();
    const Vector3f to_eye = (eye - at(positions, i)).normalized();
    const Vector3f across = direction.cross(to_eye);
    if (across.norm() < 1e-3f) continue;  // seen end on
    const Vector3f side = across.normalized() * half_width;
    const Vector3f middle = at(positions, i) + to_eye * (0.3f * static_cast<float>(edge_));
    const std::uint32_t first = static_cast<std::uint32_t>(shape.positions.size());
    for (const float end : {-half_length, half_length})
      for (const float edge : {-1.0f, 1.0f})
        shape.positions.push_back(middle + end * direction + edge * side);
    shape.colours.insert(shape.colours.end(), 4, direction_colour(direction));
    shape.triangles.push_back({first, first + 1, first + 3});
    shape.triangles.push_back({first, first + 3, first + 2});
  }
  shape.normals.assign(shape.positions.size(), Vector3f::UnitY());
  return shape;
}

// Flesh inside flesh is hidden in the body. Its vertices are marked as if seen through what covers them:
// moved close to the eye and scaled down accordingly.
Shape BodyDrawing::contact_marks(std::span<const float> positions, std::span<const float> depths,
                                 const Vector3f& eye) const {
  constexpr std::uint32_t corners = 8;
  constexpr float size_of_body = 0.003f;
  Shape shape;
  shape.finish = Finish::ink;
  shape.casts_shadow = false;
  float nearest = std::numeric_limits<float>::infinity();
  for (std::uint32_t i = 0; i < model_.vertex_count; ++i)
    nearest = std::min(nearest, (at(positions, i) - eye).norm());
  const float radius = size_of_body * static_cast<float>(model::extent(model_));
  for (std::uint32_t i = 0; i < model_.vertex_count; ++i) {
    if (depths[i] < 0.0f) continue;
    const Vector3f to_mark = at(positions, i) - eye;
    const float share = 0.5f * nearest / to_mark.norm();
    if (!std::isfinite(share) || share <= 0.0f) continue;
    const Vector3f middle = eye + share * to_mark;
    const Vector3f side = to_mark.unitOrthogonal() * (share * radius), up = to_mark.normalized().cross(side);
    const std::uint32_t first = static_cast<std::uint32_t>(shape.positions.size());
    for (std::uint32_t k = 0; k < corners; ++k) {
      const float angle = 2.0f * std::numbers::pi_v<float> * static_cast<float>(k) / corners;
      shape.positions.push_back(middle + std::cos(angle) * side + std::sin(angle) * up);
      if (k >= 2) shape.triangles.push_back({first, first + k - 1, first + k});
    }
    shape.colours.insert(shape.colours.end(), corners, lag_colour(depths[i]));
  }
  shape.normals.assign(shape.positions.size(), Vector3f::UnitY());
  return shape;
}

std::vector<Shape> BodyDrawing::shapes(std::span<const float> positions, std::span<const float> lag,
                                       const Vector3f& eye, std::span<const float> placed) const {
  std::vector<Shape> result;
  result.push_back(draws_tetrahedra_ ? faces(positions, lag) : surface(positions, lag, placed));
  if (options_.mode == Mode::fibres) result.push_back(fibre_lines(positions, eye));
  if (options_.mode == Mode::contact) result.push_back(contact_marks(positions, lag, eye));
  return result;
}

}  // namespace fascicle::render
