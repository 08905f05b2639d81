#include "host/render/facets.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace fascicle::render {

namespace {

constexpr double least_depth = 1e-6;  // m in front of the camera
// m; cutting needs room for products.
constexpr double farthest_corner = 1e12;

// A corner of what is left of a triangle while it is cut.
struct CutCorner {
  Vector3d place;    // right, up, depth in the camera's axes
  Vector3d weights;  // of the triangle's corners
};

std::optional<FacetCorner> corner_at(const Vector3d& projected) {
  const auto place = to_grid(projected.x(), projected.y());
  if (!(projected.z() > least_depth) || !place) return std::nullopt;
  return FacetCorner{*place, static_cast<float>(1.0 / projected.z())};
}

// Half spaces that hold all that can be drawn: n . (right, up, depth) >= offset.
struct CutPlane {
  Vector3d normal;
  double offset;
};

std::array<CutPlane, 5> cut_planes(const Camera& camera) {
  // A pixel inside, so that rounding leads no corner out.
  const double far = farthest_place - 1.0, f = camera.focal;
  const double x = 0.5 * camera.width, y = 0.5 * camera.height;
  return {{{{0, 0, 1}, 1.001 * least_depth},
           {{-f, 0, far - x}, 0},
           {{f, 0, far + x}, 0},
           {{0, f, far - y}, 0},
           {{0, -f, far + y}, 0}}};
}

// The part of a convex polygon in a half space. Each new corner is computed from the kept side, so that
// triangles with a common side are cut at the same point.
std::vector<CutCorner> cut(const std::vector<CutCorner>& polygon, const CutPlane& plane) {
  std::vector<CutCorner> kept;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const CutCorner &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    const double at_a = plane.normal.dot(a.place) - plane.offset,
                 at_b = plane.normal.dot(b.place) - plane.offset;
    if (at_a >= 0.0) kept.push_back(a);
    if ((at_a >= 0.0) == (at_b >= 0.0)) continue;
    const CutCorner &in = at_a >= 0.0 ? a : b, &out = at_a >= 0.0 ? b : a;
    const double share = std::fabs(at_a >= 0.0 ? at_a : at_b) / (std::fabs(at_a) + std::fabs(at_b));
    kept.push_back(
        {in.place + share * (out.place - in.place), in.weights + share * (out.weights - in.weights)});
  }
  return kept;
}

class Projection {
 public:
  Projection(std::span<const Shape> shapes, const Camera& camera)
      : camera_(camera), planes_(cut_planes(camera)) {
    result_.shapes = shapes;
    result_.pieces.push_back(Matrix3f::Identity());
    result_.of_band.resize((camera.height + band_rows - 1) / band_rows);
    std::vector<std::optional<FacetCorner>> corners;
    for (std::uint32_t s = 0; s < shapes.size(); ++s) {
      corners.clear();
      for (const Vector3f& position : shapes[s].positions)
        corners.push_back(corner_at(camera.project(position.cast<double>())));
      for (std::uint32_t t = 0; t < shapes[s].triangles.size(); ++t, ++number_) {
        const auto& [a, b, c] = shapes[s].triangles[t];
        if (corners[a] && corners[b] && corners[c])
          add({{*corners[a], *corners[b], *corners[c]}, s, t});
        else
          add_pieces(s, t);
      }
    }
  }

  Facets take() { return std::move(result_); }

 private:
  void add(const Facet& facet) {
    const auto& [a, b, c] = facet.corners;
    const auto [low, high] = std::minmax({a.place.y, b.place.y, c.place.y});
    const std::int64_t rows = grid * band_rows;
    const std::int64_t first = std::max<std::int64_t>(0, low / rows);
    const std::int64_t last =
        std::min(static_cast<std::int64_t>(result_.of_band.size()) - 1, high < 0 ? -1 : high / rows);
    for (std::int64_t band = first; band <= last; ++band)
      result_.of_band[static_cast<std::size_t>(band)].push_back(
          static_cast<std::uint32_t>(result_.facets.size()));
    result_.facets.push_back(facet);
    result_.number.push_back(number_);
  }

  // A floor or a wall reaches past the camera; what is in front of it is drawn.
  void add_pieces(std::uint32_t shape, std::uint32_t triangle) {
    std::vector<CutCorner> polygon;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d position =
          result_.shapes[shape].positions[result_.shapes[shape].triangles[triangle][k]].cast<double>();
      if (!(position.cwiseAbs().maxCoeff() < farthest_corner) || !position.allFinite()) return;
      const Vector3d p = camera_.axes * (position - camera_.eye);
      polygon.push_back({{p.x(), p.y(), -p.z()}, Vector3d::Unit(static_cast<Eigen::Index>(k))});
    }
    for (const CutPlane& plane : planes_) polygon = cut(polygon, plane);
    std::vector<FacetCorner> corners;
    for (const CutCorner& one : polygon) {
      const Vector3d& p = one.place;
      const auto corner = corner_at({0.5 * camera_.width + camera_.focal * p.x() / p.z(),
                                     0.5 * camera_.height - camera_.focal * p.y() / p.z(), p.z()});
      if (!corner) return;
      corners.push_back(*corner);
    }
    for (std::size_t k = 2; k < polygon.size(); ++k) {
      Matrix3f piece;
      piece << polygon[0].weights.cast<float>(), polygon[k - 1].weights.cast<float>(),
          polygon[k].weights.cast<float>();
      add({{corners[0], corners[k - 1], corners[k]},
           shape,
           triangle,
           static_cast<std::uint32_t>(result_.pieces.size())});
      result_.pieces.push_back(piece);
    }
  }

  const Camera& camera_;
  const std::array<CutPlane, 5> planes_;
  Facets result_;
  std::uint32_t number_ = 0;
};

}  // namespace

Facets project(std::span<const Shape> shapes, const Camera& camera) {
  return Projection(shapes, camera).take();
}

Vector3f weights_at(const Facets& facets, const Facet& facet, const Edges& edges, const GridPoint& at) {
  // value / area times 1/distance, divided by their sum: undoes the perspective.
  Vector3f weights;
  for (std::size_t k = 0; k < 3; ++k)
    weights[static_cast<int>(k)] =
        std::max(0.0f, static_cast<float>(edges.value(k, at.x, at.y))) * facet.corners[k].nearness;
  weights /= weights.sum();
  return facet.piece == 0 ? weights : Vector3f(facets.pieces[facet.piece] * weights);
}

float share_of(const Facets& facets, const Facet& facet) {
  return facet.piece == 0 ? 1.0f : std::fabs(facets.pieces[facet.piece].determinant());
}

bool is_edge_of_triangle(const Facets& facets, const Facet& facet, std::size_t k) {
  if (facet.piece == 0) return true;
  const Matrix3f& piece = facets.pieces[facet.piece];
  // A corner on a side has exactly no weight of the corner opposite to it.
  const auto from = static_cast<Eigen::Index>((k + 1) % 3), to = static_cast<Eigen::Index>((k + 2) % 3);
  for (Eigen::Index c = 0; c < 3; ++c)
    if (piece(c, from) == 0.0f && piece(c, to) == 0.0f) return true;
  return false;
}

}  // namespace fascicle::render
