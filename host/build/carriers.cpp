#include "host/build/carriers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "host/build/box_tree.h"
#include "host/build/embedding.h"
#include "host/build/measures.h"

namespace fascicle::build {

WeightRow weight_row(const SkinWeights& weights, std::uint32_t vertex) {
  WeightRow row;
  for (std::uint32_t k = weights.offset[vertex]; k < weights.offset[vertex + 1]; ++k)
    row.emplace_back(weights.joint[k], weights.weight[k]);
  std::sort(row.begin(), row.end());
  return row;
}

namespace {

// A carrier's edge over the extent of its riders: small, but no rider is farther away than 8 of its edges.
constexpr double carrier_of_extent = 0.25;
constexpr double smallest_of_diagonal = 5e-3;
// Barycentric weights below 8 that are multiples of 1 / carrier_steps are exact in floats, and so are their
// sums.
constexpr double carrier_steps = 2097152.0;  // 2^21
constexpr double misled_share = 0.1;
// Riders are alike if their weights round to the same multiples of 1 / steps.
constexpr double most_steps = 64.0, least_steps = 8.0;
constexpr std::size_t most_carriers = 3000;

// A regular tetrahedron at alternate corners of a cube.
std::array<std::uint32_t, 4> add_carrier(const Vector3d& middle, double side, const WeightRow& row,
                                         Body& body) {
  std::array<std::uint32_t, 4> corners{};
  const std::array<Vector3d, 4> at{Vector3d(1, 1, 1), Vector3d(-1, 1, -1), Vector3d(1, -1, -1),
                                   Vector3d(-1, -1, 1)};
  for (std::size_t c = 0; c < 4; ++c) {
    corners[c] = static_cast<std::uint32_t>(body.mesh.vertices.size());
    body.mesh.vertices.push_back(middle + side / 2.0 * at[c]);
    body.holding.push_back(Holding::carrier);
    for (const auto& [joint, w] : row) {
      body.skin.joint.push_back(joint);
      body.skin.weight.push_back(w);
    }
    body.skin.offset.push_back(static_cast<std::uint32_t>(body.skin.joint.size()));
  }
  body.mesh.tetrahedra.push_back(corners);
  return corners;
}

std::array<double, 4> rounded_weights(std::array<double, 4> weights) {
  double others = 0.0;
  for (std::size_t k = 1; k < 4; ++k) {
    weights[k] = std::round(weights[k] * carrier_steps) / carrier_steps;
    others += weights[k];
  }
  weights[0] = 1.0 - others;
  return weights;
}

// How much of a vertex's weight goes to other joints at the corners it rides on.
double share_of_others(const WeightRow& own, const std::array<std::uint32_t, 4>& corners,
                       const std::array<double, 4>& at, const SkinWeights& weights) {
  std::map<std::uint32_t, double> difference;
  for (const auto& [joint, w] : own) difference[joint] += w;
  for (std::size_t c = 0; c < 4; ++c)
    for (const auto& [joint, w] : weight_row(weights, corners[c])) difference[joint] -= at[c] * w;
  double sum = 0.0;
  for (const auto& [joint, d] : difference) sum += std::abs(d);
  return sum / 2.0;
}

// The riders of each carrier (welded vertices), by the row they share.
using Riders = std::map<WeightRow, std::vector<std::uint32_t>>;

WeightRow rounded_row(const WeightRow& row, double steps) {
  WeightRow rounded;
  for (const auto& [joint, w] : row)
    if (const double r = std::round(w * steps) / steps; r > 0.0) rounded.emplace_back(joint, r);
  return rounded.empty() ? row : rounded;
}

WeightRow mean_row(const SkinWeights& weights, const std::vector<std::uint32_t>& vertices) {
  std::map<std::uint32_t, double> sum;
  for (const std::uint32_t v : vertices)
    for (const auto& [joint, w] : weight_row(weights, v)) sum[joint] += w;
  std::vector<std::pair<double, std::uint32_t>> largest;
  for (const auto& [joint, w] : sum) largest.emplace_back(-w, joint);
  std::sort(largest.begin(), largest.end());
  largest.resize(std::min<std::size_t>(largest.size(), 8));
  double whole = 0.0;
  for (const auto& [w, joint] : largest) whole += w;
  WeightRow row;
  for (const auto& [w, joint] : largest) row.emplace_back(joint, w / whole);
  std::sort(row.begin(), row.end());
  return row;
}

// `steps` 0: only identical weights match.
Riders riders_of(const SkinWeights& weights, const std::vector<char>& rides, double steps) {
  Riders riders;
  for (std::uint32_t v = 0; v < rides.size(); ++v) {
    if (!rides[v]) continue;
    const WeightRow row = weight_row(weights, v);
    riders[steps > 0.0 ? rounded_row(row, steps) : row].push_back(v);
  }
  return riders;
}

// More than most_carriers only if even the coarsest steps make them.
Riders coarser_riders_of(const SkinWeights& weights, const std::vector<char>& rides) {
  Riders riders;
  for (double steps = most_steps; steps >= least_steps; steps /= 2.0) {
    riders = riders_of(weights, rides, steps);
    if (riders.size() <= most_carriers) break;
  }
  return riders;
}

}  // namespace

void seat_on_carriers(const WeldedSurface& welded, const SkinWeights& weights, const std::vector<char>& rides,
                      Sharing sharing, Body& body) {
  const BoundingBox all = box_around(welded.surface.vertices);
  std::vector<std::array<std::uint32_t, 4>> corners(rides.size());
  Riders riders = riders_of(weights, rides, 0.0);
  const bool are_many = riders.size() > most_carriers;
  if (are_many) riders = coarser_riders_of(weights, rides);
  for (const auto& [row, vertices] : riders) {
    std::vector<Vector3d> points;
    for (const std::uint32_t v : vertices) points.push_back(welded.surface.vertices[v]);
    const BoundingBox box = box_around(points);
    const double side = std::max(carrier_of_extent * (box.high - box.low).norm(),
                                 smallest_of_diagonal * (all.high - all.low).norm());
    const auto carrier =
        add_carrier((box.low + box.high) / 2.0, side,
                    sharing == Sharing::exact && !are_many ? row : mean_row(weights, vertices), body);
    for (const std::uint32_t v : vertices) corners[v] = carrier;
  }
  for (std::size_t k = 0; k < welded.of_vertex.size(); ++k) {
    const std::uint32_t v = welded.of_vertex[k];
    if (!rides[v]) continue;
    body.render.corners[k] = corners[v];
    body.render.weights[k] = rounded_weights(barycentric(body.mesh, corners[v], welded.surface.vertices[v]));
  }
}

std::vector<char> misled_riders(const WeldedSurface& welded, const SkinWeights& weights, const Body& body) {
  std::vector<char> is_misled(welded.surface.vertices.size(), 0);
  Measures measures(body);
  for (std::size_t k = 0; k < welded.of_vertex.size(); ++k) {
    const std::uint32_t v = welded.of_vertex[k];
    const auto& corners = body.render.corners[k];
    const auto& at = body.render.weights[k];
    if (share_of_others(weight_row(weights, v), corners, at, body.skin) < misled_share) continue;
    const auto nearest = static_cast<std::size_t>(std::max_element(at.begin(), at.end()) - at.begin());
    if (measures.follows(weights, v, welded.surface.vertices[v], measures.radii()[corners[nearest]]))
      is_misled[v] = 1;
  }
  return is_misled;
}

}  // namespace fascicle::build
