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

bool is_kept(const Model& model, std::size_t tetrahedron, const std::optional<Clip>& clip) {
  if (!clip) return true;
  for (std::size_t c = 0; c < 4; ++c) {
    const double place = rest_of(model, model.tetrahedron[4 * tetrahedron + c])[clip->axis];
    if (clip->keeps_below ? place < clip->place : place > clip->place) return true;
  }
  return false;
}

// The four sides of a tetrahedron of positive volume, corners turning left seen from outside.
constexpr std::array<std::array<std::size_t, 3>, 4> sides{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

// The layer that most of `layers` are; of equals the lowest.
std::uint32_t most_frequent(std::array<std::uint32_t, 4> layers) {
  std::sort(layers.begin(), layers.end());
  std::uint32_t best = layers[0];
  std::ptrdiff_t most = 0;
  for (const std::uint32_t layer : layers)
    if (const auto count = std::count(layers.begin(), layers.end(), layer); count > most) {
      most = count;
      best = layer;
    }
  return best;
}

Vector3f skin_tone() {
  return colour(0xe3ab8c);
}

// Of what has no meaning of its own.
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

Vector3f surface_rest(const Model& model, std::uint32_t s) {
  Vector3f place = Vector3f::Zero();
  for (std::size_t c = 0; c < 4; ++c)
    place += model.surface_weight[std::size_t{4} * s + c] *
             at(model.rest, model.surface_vertex[std::size_t{4} * s + c]);
  return place;
}

// Vertices of a seam have one place and several numbers; their normals must agree, or the seam shows.
std::vector<std::uint32_t> first_at_same_place(const Model& model) {
  std::map<std::array<float, 3>, std::uint32_t> first;
  std::vector<std::uint32_t> result;
  for (std::uint32_t s = 0; s < model.surface_count(); ++s) {
    const Vector3f place = surface_rest(model, s);
    result.push_back(first.try_emplace({place.x(), place.y(), place.z()}, s).first->second);
  }
  return result;
}

std::uint32_t heaviest_layer(const Model& model, std::uint32_t s) {
  std::vector<float> share(model.layers.size(), 0.0f);
  for (std::size_t c = 0; c < 4; ++c)
    share[model.layer_of(model.surface_vertex[std::size_t{4} * s + c])] +=
        model.surface_weight[std::size_t{4} * s + c];
  return static_cast<std::uint32_t>(std::max_element(share.begin(), share.end()) - share.begin());
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
  if (!draws_tetrahedra_) {
    split_at_creases();
    for (std::uint32_t s = 0; s < model.surface_count(); ++s)
      surface_layer_.push_back(heaviest_layer(model, s));
    return;
  }
  // A side that two kept tetrahedra share is inside.
  struct Side {
    std::array<std::uint32_t, 3> key;
    Face face;
  };
  std::vector<Side> all;
  for (std::uint32_t t = 0; t < model.tetrahedron_count(); ++t) {
    if (!is_kept(model, t, options.clip)) continue;
    const std::uint32_t* corner = &model.tetrahedron[std::size_t{4} * t];
    for (const auto& side : sides) {
      const std::array<std::uint32_t, 3> corners{corner[side[0]], corner[side[1]], corner[side[2]]};
      std::array<std::uint32_t, 3> key = corners;
      std::sort(key.begin(), key.end());
      all.push_back({key, {corners, t}});
    }
  }
  std::sort(all.begin(), all.end(), [](const Side& a, const Side& b) {
    return a.key != b.key ? a.key < b.key : a.face.tetrahedron < b.face.tetrahedron;
  });
  for (std::size_t k = 0; k < all.size();) {
    std::size_t end = k + 1;
    while (end < all.size() && all[end].key == all[k].key) ++end;
    if (end == k + 1) faces_.push_back(all[k].face);
    k = end;
  }
  if (faces_.empty())
    throw std::invalid_argument(options.clip ? "--clip leaves no tetrahedron; choose a place inside the body"
                                             : "there are no tetrahedra to draw");
  double sum = 0.0;
  std::vector<char> on_face(model.vertex_count, 0);
  for (const Face& face : faces_)
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

// A side where the rest shape bends by more than this is an edge of the shape, as a box's are.
constexpr float crease_cosine = 0.64f;  // 50 degrees

void BodyDrawing::split_at_creases() {
  const std::vector<std::uint32_t> place = first_at_same_place(model_);
  const std::vector<std::uint32_t>& corners = model_.surface_triangle;
  std::vector<Vector3f> normals;
  for (std::size_t t = 0; t < corners.size(); t += 3) {
    const Vector3f a = surface_rest(model_, corners[t]);
    normals.push_back((surface_rest(model_, corners[t + 1]) - a)
                          .cross(surface_rest(model_, corners[t + 2]) - a)
                          .normalized());
  }
  // Corners of triangles are joined across every side that is not a crease; what is joined has one normal.
  std::vector<std::uint32_t> parent(corners.size());
  for (std::uint32_t k = 0; k < parent.size(); ++k) parent[k] = k;
  const auto root = [&parent](std::uint32_t k) {
    while (parent[k] != k) k = parent[k] = parent[parent[k]];
    return k;
  };
  struct Side {
    std::array<std::uint32_t, 2> places;
    std::array<std::uint32_t, 2> corners;  // at the lower place, at the higher
  };
  std::vector<Side> all;
  for (std::uint32_t k = 0; k < corners.size(); ++k) {
    const std::uint32_t next = k % 3 == 2 ? k - 2 : k + 1;
    const std::uint32_t a = place[corners[k]], b = place[corners[next]];
    all.push_back(a < b ? Side{{a, b}, {k, next}} : Side{{b, a}, {next, k}});
  }
  std::sort(all.begin(), all.end(), [](const Side& a, const Side& b) {
    return a.places != b.places ? a.places < b.places : a.corners < b.corners;
  });
  for (std::size_t k = 1; k < all.size(); ++k) {
    const Side &a = all[k - 1], &b = all[k];
    if (a.places != b.places) continue;
    if (normals[a.corners[0] / 3].dot(normals[b.corners[0] / 3]) < crease_cosine) continue;
    for (std::size_t end = 0; end < 2; ++end) parent[root(b.corners[end])] = root(a.corners[end]);
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> drawn;  // render vertex, root
  std::map<std::uint32_t, std::uint32_t> normal;                           // root
  for (std::uint32_t k = 0; k < corners.size(); ++k) {
    const std::uint32_t group = root(k);
    const auto [entry, is_new] =
        drawn.try_emplace({corners[k], group}, static_cast<std::uint32_t>(drawn_vertex_.size()));
    if (is_new) {
      drawn_vertex_.push_back(corners[k]);
      normal_of_.push_back(
          normal.try_emplace(group, static_cast<std::uint32_t>(normal.size())).first->second);
    }
    if (k % 3 == 0) drawn_triangles_.push_back({});
    drawn_triangles_.back()[k % 3] = entry->second;
  }
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

// The looks' colours in place of the skin's.
void BodyDrawing::paint(Shape& shape) const {
  const Looks& looks = *options_.looks;
  shape.finish = Finish::painted;
  shape.looks = &looks;
  shape.colours.clear();
  for (const std::uint32_t s : drawn_vertex_) {
    shape.colours.push_back(looks.colours.empty() ? Vector3f(Vector3f::Ones()) : looks.colours[s]);
    if (!looks.uvs.empty()) shape.uvs.push_back(looks.uvs[s]);
  }
  for (const auto& triangle : drawn_triangles_)
    shape.paints.push_back(looks.paint_of_vertex[drawn_vertex_[triangle[0]]]);
}

Shape BodyDrawing::surface(std::span<const float> positions, std::span<const float> lag,
                           std::span<const float> placed) const {
  Shape shape;
  shape.finish = options_.mode == Mode::shaded ? Finish::skin : Finish::plain;
  shape.blend_colours = options_.mode != Mode::layers;
  for (const std::uint32_t s : drawn_vertex_) {
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
  shape.triangles = drawn_triangles_;
  shape.normals = smooth_normals(shape, normal_of_);
  if (options_.looks != nullptr && options_.mode == Mode::shaded) paint(shape);
  return shape;
}

Shape BodyDrawing::faces(std::span<const float> positions, std::span<const float> lag) const {
  Shape shape;
  shape.finish = options_.mode == Mode::shaded ? Finish::skin : Finish::plain;
  shape.draw_edges = options_.mode != Mode::fibres;
  for (const Face& face : faces_) {
    const std::uint32_t first = static_cast<std::uint32_t>(shape.positions.size());
    for (const std::uint32_t corner : face.corners) shape.positions.push_back(at(positions, corner));
    const Vector3f across = (shape.positions[first + 1] - shape.positions[first])
                                .cross(shape.positions[first + 2] - shape.positions[first]);
    const float length = across.norm();
    const Vector3f normal = length > 0.0f ? Vector3f(across / length) : Vector3f(Vector3f::UnitY());
    shape.normals.insert(shape.normals.end(), 3, normal);
    if (options_.mode == Mode::layers) {
      const std::uint32_t* corner = &model_.tetrahedron[std::size_t{4} * face.tetrahedron];
      const std::uint32_t layer = most_frequent({model_.layer_of(corner[0]), model_.layer_of(corner[1]),
                                                 model_.layer_of(corner[2]), model_.layer_of(corner[3])});
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
    // The line as the flesh carries it: the mean deformation of the tetrahedra around.
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

// Flesh in flesh is hidden in the body. Its vertices are marked as if seen through what lies before them:
// brought near to the eye, and made smaller by as much.
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
