#include "host/model/surroundings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "host/base/flat.h"

namespace fascicle::model {

namespace {

using RestPlace = std::array<double, 3>;

// A banner that is as tall as its bearer is part of the picture.
constexpr double least_length = 2.0;

class PlaceBox {
 public:
  void extend(const RestPlace& p) {
    for (std::size_t a = 0; a < 3; ++a) {
      low_[a] = std::min(low_[a], p[a]);
      high_[a] = std::max(high_[a], p[a]);
    }
  }
  double diagonal() const { return std::hypot(high_[0] - low_[0], high_[1] - low_[1], high_[2] - low_[2]); }
  RestPlace middle() const {
    return {(low_[0] + high_[0]) / 2.0, (low_[1] + high_[1]) / 2.0, (low_[2] + high_[2]) / 2.0};
  }
  // Along its two longest axes.
  bool spans(const RestPlace& p) const {
    std::size_t shortest = 0;
    for (std::size_t a = 1; a < 3; ++a)
      if (high_[a] - low_[a] < high_[shortest] - low_[shortest]) shortest = a;
    for (std::size_t a = 0; a < 3; ++a)
      if (a != shortest && !(low_[a] <= p[a] && p[a] <= high_[a])) return false;
    return true;
  }

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  RestPlace low_{infinity, infinity, infinity}, high_{-infinity, -infinity, -infinity};
};

struct RenderPart {
  std::vector<std::uint32_t> vertices;
  std::vector<RestPlace> places;
  PlaceBox box;
  bool follows = true;  // the skeleton moves every vertex
};

// At rest, working units.
std::vector<RestPlace> places_of(const Model& model) {
  std::vector<RestPlace> places(model.surface_count(), RestPlace{0.0, 0.0, 0.0});
  for (std::size_t k = 0; k < model.surface_vertex.size(); ++k)
    for (std::size_t a = 0; a < 3; ++a)
      places[k / 4][a] +=
          double{model.surface_weight[k]} * double{model.rest[3 * std::size_t{model.surface_vertex[k]} + a]};
  return places;
}

// Of vertices that triangles have: others may lie anywhere.
std::vector<RenderPart> parts_of(const Model& model) {
  const std::vector<RestPlace> places = places_of(model);
  std::map<std::array<float, 3>, std::uint32_t> first;  // floats: the two sides of a seam differ by rounding
  std::vector<std::uint32_t> parent;
  for (const RestPlace& p : places) {
    const std::array<float, 3> rounded{static_cast<float>(p[0]), static_cast<float>(p[1]),
                                       static_cast<float>(p[2])};
    parent.push_back(first.try_emplace(rounded, static_cast<std::uint32_t>(parent.size())).first->second);
  }
  const auto root = [&parent](std::uint32_t k) {
    while (parent[k] != k) k = parent[k] = parent[parent[k]];
    return k;
  };
  std::vector<char> is_drawn(places.size(), 0);
  for (std::size_t k = 0; k < model.surface_triangle.size(); ++k) {
    is_drawn[model.surface_triangle[k]] = 1;
    parent[root(model.surface_triangle[k])] = root(model.surface_triangle[k - k % 3]);
  }
  std::vector<RenderPart> parts;
  std::map<std::uint32_t, std::size_t> part_of;  // root, part
  for (std::uint32_t s = 0; s < places.size(); ++s) {
    if (is_drawn[s] == 0) continue;
    const auto [entry, is_new] = part_of.try_emplace(root(s), parts.size());
    if (is_new) parts.emplace_back();
    RenderPart& part = parts[entry->second];
    part.vertices.push_back(s);
    part.places.push_back(places[s]);
    part.box.extend(places[s]);
    for (std::size_t c = 0; c < 4; ++c)
      part.follows = part.follows && model.is_kinematic(model.surface_vertex[4 * std::size_t{s} + c]);
  }
  return parts;
}

}  // namespace

Surroundings surroundings_of(const Model& model) {
  Surroundings result{std::vector<char>(model.surface_count(), 0), std::vector<char>(model.vertex_count, 0)};
  const std::vector<RenderPart> parts = parts_of(model);
  PlaceBox rest;
  bool has_flesh = false;
  std::vector<const RenderPart*> sheets;
  for (const RenderPart& part : parts) {
    has_flesh = has_flesh || !part.follows;
    if (part.follows && base::is_flat(part.places))
      sheets.push_back(&part);
    else
      for (const RestPlace& p : part.places) rest.extend(p);
  }
  if (!has_flesh) return result;
  for (const RenderPart* sheet : sheets) {
    // A wing is beside the body, and a floor below it.
    if (!sheet->box.spans(rest.middle())) continue;
    if (!(sheet->box.diagonal() > least_length * rest.diagonal())) continue;
    for (const std::uint32_t s : sheet->vertices) {
      result.surface[s] = 1;
      for (std::size_t c = 0; c < 4; ++c) result.vertices[model.surface_vertex[4 * std::size_t{s} + c]] = 1;
    }
  }
  return result;
}

}  // namespace fascicle::model
