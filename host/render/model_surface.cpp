#include "host/render/model_surface.h"

#include <algorithm>
#include <map>
#include <utility>

#include <Eigen/Dense>

#include "host/render/image.h"

namespace fascicle::render {

namespace {

using model::Model;

Vector3f vector_at(std::span<const float> values, std::uint32_t k) {
  return {values[std::size_t{3} * k], values[std::size_t{3} * k + 1], values[std::size_t{3} * k + 2]};
}

// m
double rest_along(const Model& model, std::uint32_t i, int axis) {
  return model.rest_origin[static_cast<std::size_t>(axis)] +
         model.unit * double{vector_at(model.rest, i)[axis]};
}

bool is_kept(const Model& model, std::size_t tetrahedron, const std::optional<Clip>& clip) {
  if (!clip) return true;
  for (std::size_t c = 0; c < 4; ++c) {
    const double place = rest_along(model, model.tetrahedron[4 * tetrahedron + c], clip->axis);
    if (clip->keeps_below ? place < clip->place : place > clip->place) return true;
  }
  return false;
}

// The four faces of a tetrahedron of positive volume, corners counter-clockwise seen from outside.
constexpr std::array<std::array<std::size_t, 3>, 4> sides{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

// The most frequent of `layers`; in a tie, the lowest.
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

Vector3f surface_rest(const Model& model, std::uint32_t s) {
  Vector3f place = Vector3f::Zero();
  for (std::size_t c = 0; c < 4; ++c)
    place += model.surface_weight[std::size_t{4} * s + c] *
             vector_at(model.rest, model.surface_vertex[std::size_t{4} * s + c]);
  return place;
}

// Vertices along a seam share a place but not a number; their normals must agree, or the seam shows.
std::vector<std::uint32_t> first_at_same_place(const Model& model) {
  std::map<std::array<float, 3>, std::uint32_t> first;
  std::vector<std::uint32_t> result;
  for (std::uint32_t s = 0; s < model.surface_count(); ++s) {
    const Vector3f place = surface_rest(model, s);
    result.push_back(first.try_emplace({place.x(), place.y(), place.z()}, s).first->second);
  }
  return result;
}

// An edge where the rest shape bends by more than this is a sharp edge, like those of a box.
constexpr float crease_cosine = 0.64f;  // 50 degrees

}  // namespace

CreasedSurface creased_surface(const Model& model) {
  CreasedSurface surface;
  const std::vector<std::uint32_t> place = first_at_same_place(model);
  const std::vector<std::uint32_t>& corners = model.surface_triangle;
  std::vector<Vector3f> normals;
  for (std::size_t t = 0; t < corners.size(); t += 3) {
    const Vector3f a = surface_rest(model, corners[t]);
    normals.push_back((surface_rest(model, corners[t + 1]) - a)
                          .cross(surface_rest(model, corners[t + 2]) - a)
                          .normalized());
  }
  // Joins corners of triangles across every edge that is not a crease; joined corners share a normal.
  std::vector<std::uint32_t> parent(corners.size());
  for (std::uint32_t k = 0; k < parent.size(); ++k) parent[k] = k;
  const auto root = [&parent](std::uint32_t k) {
    while (parent[k] != k) k = parent[k] = parent[parent[k]];
    return k;
  };
  struct Side {
    std::array<std::uint32_t, 2> places;
    std::array<std::uint32_t, 2> corners;  // at the lower-numbered place, at the higher-numbered
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
        drawn.try_emplace({corners[k], group}, static_cast<std::uint32_t>(surface.vertex.size()));
    if (is_new) {
      surface.vertex.push_back(corners[k]);
      surface.normal.push_back(
          normal.try_emplace(group, static_cast<std::uint32_t>(normal.size())).first->second);
    }
    if (k % 3 == 0) surface.triangles.push_back({});
    surface.triangles.back()[k % 3] = entry->second;
  }
  return surface;
}

std::vector<OuterFace> outer_faces(const Model& model, const std::optional<Clip>& clip) {
  std::vector<OuterFace> faces;
  // A face shared by two kept tetrahedra is inside.
  struct Side {
    std::array<std::uint32_t, 3> key;
    OuterFace face;
  };
  std::vector<Side> all;
  for (std::uint32_t t = 0; t < model.tetrahedron_count(); ++t) {
    if (!is_kept(model, t, clip)) continue;
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
    if (end == k + 1) faces.push_back(all[k].face);
    k = end;
  }
  return faces;
}

std::uint32_t layer_of_surface_vertex(const Model& model, std::uint32_t s) {
  std::vector<float> share(model.layers.size(), 0.0f);
  for (std::size_t c = 0; c < 4; ++c)
    share[model.layer_of(model.surface_vertex[std::size_t{4} * s + c])] +=
        model.surface_weight[std::size_t{4} * s + c];
  return static_cast<std::uint32_t>(std::max_element(share.begin(), share.end()) - share.begin());
}

std::uint32_t layer_of_tetrahedron(const Model& model, std::uint32_t t) {
  const std::uint32_t* corner = &model.tetrahedron[std::size_t{4} * t];
  return most_frequent({model.layer_of(corner[0]), model.layer_of(corner[1]), model.layer_of(corner[2]),
                        model.layer_of(corner[3])});
}

}  // namespace fascicle::render
