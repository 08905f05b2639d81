#include "host/build/embedding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

#include "host/build/box_tree.h"
#include "host/build/message.h"

namespace fascicle::build {

namespace {

constexpr double steps_of_one = 8388608.0;  // 2^23: multiples up to 2 are floats, and so are their sums
// A vertex leaves its home if the agreement between their joints is below this.
constexpr double enough_agreement = 0.5;
// A tetrahedron with this share of the best agreement nearby moves with the vertex.
constexpr double enough_part = 0.25;
// Below this agreement, the skin does not move with its own joints.
constexpr double little_agreement = 0.1;
// The cost in agreement of sticking out by a whole barycentric coordinate: at -0.25 the right limb is as bad
// as a place inside the wrong one.
constexpr double cost_of_sticking_out = 4.0;
// The search radius for another tetrahedron, in longest edges of the home.
constexpr double search_edges = 1.5;

using Corners = std::array<std::uint32_t, 4>;
using Weights = std::array<double, 4>;

double least(const Weights& weights) {
  return *std::min_element(weights.begin(), weights.end());
}

// An approximation of the nearest place in the tetrahedron: negative weights are clipped.
Weights inside(Weights weights) {
  double sum = 0.0;
  for (double& w : weights) sum += w = std::max(w, 0.0);
  for (double& w : weights) w /= sum;
  return weights;
}

// Rounded to steps; the largest takes the remainder to 1.
Weights rounded(Weights weights) {
  const auto largest =
      static_cast<std::size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  double others = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    if (k == largest) continue;
    weights[k] = std::round(weights[k] * steps_of_one) / steps_of_one;
    others += weights[k];
  }
  weights[largest] = 1.0 - others;
  return weights;
}

double longest_edge(const mesh::TetMesh& mesh, const Corners& t) {
  double longest = 0.0;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < a; ++b)
      longest = std::max(longest, (mesh.vertices[t[a]] - mesh.vertices[t[b]]).norm());
  return longest;
}

struct Seat {
  std::uint32_t tetrahedron = 0;
  Weights weights{};
  double agreement = 0.0;
};

// Finds the tetrahedra that skin vertices ride on.
class Seating {
 public:
  Seating(const mesh::TetMesh& mesh, const SkinWeights& body_weights, const SkinWeights& skin_weights)
      : mesh_(mesh), body_weights_(body_weights), skin_weights_(skin_weights) {}

  Seat seat(std::uint32_t vertex, const Vector3d& point, std::uint32_t home) {
    const Seat at_home = seat_on(vertex, point, home);
    if (least(at_home.weights) >= least_barycentric && at_home.agreement >= enough_agreement) return at_home;
    return best_near(vertex, point, at_home);
  }

 private:
  Seat seat_on(std::uint32_t vertex, const Vector3d& point, std::uint32_t tetrahedron) const {
    const Corners& corners = mesh_.tetrahedra[tetrahedron];
    Seat seat{tetrahedron, barycentric(mesh_, corners, point), 1.0};
    if (!skin_weights_.offset.empty())
      seat.agreement = weight_agreement(skin_weights_, vertex, body_weights_, corners, inside(seat.weights));
    return seat;
  }

  Seat best_near(std::uint32_t vertex, const Vector3d& point, const Seat& at_home) {
    if (!tree_) {
      std::vector<BoundingBox> boxes;
      boxes.reserve(mesh_.tetrahedra.size());
      for (const Corners& t : mesh_.tetrahedra)
        boxes.push_back(box_around(std::array{mesh_.vertices[t[0]], mesh_.vertices[t[1]],
                                              mesh_.vertices[t[2]], mesh_.vertices[t[3]]}));
      tree_.emplace(boxes);
    }
    const double reach = search_edges * longest_edge(mesh_, mesh_.tetrahedra[at_home.tetrahedron]);
    std::vector<Seat> seats{at_home};
    tree_->visit_near(point, reach * reach, [&](std::uint32_t tetrahedron) {
      seats.push_back(seat_on(vertex, point, tetrahedron));
      return reach * reach;
    });
    // If nothing nearby has the vertex's joints (an eye in a head), agreement is relative to the best.
    double most = 0.0;
    for (const Seat& s : seats) most = std::max(most, s.agreement);
    const auto part = [&](const Seat& s) { return most > 0.0 ? s.agreement / most : 1.0; };
    // A place that contains the vertex comes first. Sticking out of a limb beats riding on another only if
    // the vertex's own limb does not contain it and everything that does moves with entirely different
    // joints.
    const auto holds = [](const Seat& s) { return least(s.weights) >= least_barycentric; };
    const bool is_held = holds(at_home) || std::any_of(seats.begin(), seats.end(), [&](const Seat& s) {
                           return holds(s) && part(s) >= enough_part;
                         });
    if (is_held) std::erase_if(seats, [&](const Seat& s) { return !holds(s); });
    const auto worth = [&](const Seat& s) {
      return part(s) - cost_of_sticking_out * std::max(0.0, -least(s.weights));
    };
    // Ties go to the home, then to the lowest number.
    return *std::min_element(seats.begin(), seats.end(), [&](const Seat& a, const Seat& b) {
      const double worth_a = worth(a), worth_b = worth(b);
      if (worth_a != worth_b) return worth_a > worth_b;
      const bool home_a = a.tetrahedron == at_home.tetrahedron, home_b = b.tetrahedron == at_home.tetrahedron;
      return home_a != home_b ? home_a : a.tetrahedron < b.tetrahedron;
    });
  }

  const mesh::TetMesh& mesh_;
  const SkinWeights& body_weights_;
  const SkinWeights& skin_weights_;
  std::optional<BoxTree> tree_;  // most bodies never need it
};

}  // namespace

std::array<double, 4> barycentric(const mesh::TetMesh& mesh, const Corners& tetrahedron,
                                  const Vector3d& point) {
  const Vector3d& origin = mesh.vertices[tetrahedron[0]];
  const Vector3d a = mesh.vertices[tetrahedron[1]] - origin, b = mesh.vertices[tetrahedron[2]] - origin,
                 c = mesh.vertices[tetrahedron[3]] - origin, p = point - origin;
  const double volume = a.cross(b).dot(c);
  const double of_a = p.cross(b).dot(c) / volume;
  const double of_b = a.cross(p).dot(c) / volume;
  const double of_c = a.cross(b).dot(p) / volume;
  return {1.0 - of_a - of_b - of_c, of_a, of_b, of_c};
}

double weight_agreement(const SkinWeights& skin_a, std::uint32_t a, const SkinWeights& skin_b,
                        const Corners& corners, const Weights& weights) {
  double common = 0.0;
  for (std::uint32_t k = skin_a.offset[a]; k < skin_a.offset[a + 1]; ++k) {
    double share = 0.0;
    for (std::size_t c = 0; c < 4; ++c)
      for (std::uint32_t m = skin_b.offset[corners[c]]; m < skin_b.offset[corners[c] + 1]; ++m)
        if (skin_b.joint[m] == skin_a.joint[k]) share += weights[c] * skin_b.weight[m];
    common += std::min(share, skin_a.weight[k]);
  }
  return common;
}

RenderMesh embed_surface(const mesh::SurfaceMesh& surface, const WeldedSurface& welded, const BodyMesh& body,
                         const SkinWeights& body_weights, const SkinWeights& skin_weights, Report& report) {
  RenderMesh render;
  render.triangles = surface.triangles;
  render.corners.reserve(surface.vertices.size());
  render.weights.reserve(surface.vertices.size());
  if (body.keeps_skin) {
    for (const std::uint32_t vertex : welded.of_vertex) ride_on_vertex(render, vertex);
    return render;
  }

  Seating seating(body.mesh, body_weights, skin_weights);
  std::vector<Seat> seats;
  seats.reserve(welded.surface.vertices.size());
  for (std::uint32_t v = 0; v < welded.surface.vertices.size(); ++v)
    seats.push_back(seating.seat(v, welded.surface.vertices[v], body.home[v]));

  std::vector<std::uint32_t> outside, astray;
  for (std::uint32_t v = 0; v < welded.of_vertex.size(); ++v) {
    const Seat& seat = seats[welded.of_vertex[v]];
    render.corners.push_back(body.mesh.tetrahedra[seat.tetrahedron]);
    render.weights.push_back(rounded(seat.weights));
    report.fill.least_barycentric = std::min(report.fill.least_barycentric, least(seat.weights));
    report.fill.riders_outside += least(seat.weights) < 0.0 ? 1u : 0u;
    if (least(seat.weights) < least_barycentric) outside.push_back(number_in_file(welded, v));
    if (seat.agreement < little_agreement) astray.push_back(number_in_file(welded, v));
  }
  if (!outside.empty())
    warn_of_flesh(report, counted(outside.size(), "vertex of the skin sticks", "vertices of the skin stick") +
                              " out of the cage, by up to " + std::to_string(-report.fill.least_barycentric) +
                              " of a tetrahedron's height (vertex " + list_of(outside) +
                              " of the file); use a smaller resolution (edge length)");
  if (!astray.empty())
    warn_of_flesh(
        report,
        counted(astray.size(), "vertex of the skin follows", "vertices of the skin follow") +
            " flesh that other joints move (vertex " + list_of(astray) +
            " of the file); one part may lie inside another, or the cage is too coarse to tell them apart");
  return render;
}

}  // namespace fascicle::build
