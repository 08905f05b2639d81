#include "cpu_reference/oracle/oracle_contact.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "host/model/contact_depth.h"
#include "host/model/contact_near.h"

namespace fascicle::cpu_reference {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

// The smallest gradient of depth that gives a way out.
constexpr double least_gradient = 0.1;
// A vertex shares its mass between as many contacts as its coefficients add up to; in an explicit pass,
// between at least two.
constexpr double least_crowd = 2.0;
// The most by which settling changes a corner's velocity, as a multiple of the contact's change.
constexpr double most_settling = 4.0;
// The part of the depth that an iteration of the implicit integrator removes: a share at most, and a rate per
// second.
constexpr double most_depth_share = 0.5, depth_rate = 180.0;
// A contact at least this share of its margin deep is held fully, a shallower one less.
constexpr double full_depth = 1.0 / 32.0;

// Columns: the edges from the first corner.
Matrix3d edges_of(const std::array<std::uint32_t, 4>& corners, const Points& places) {
  Matrix3d edges;
  for (int k = 0; k < 3; ++k) edges.col(k) = places[corners[std::size_t(k) + 1]] - places[corners[0]];
  return edges;
}

}  // namespace

Contacts::Contacts(const model::Model& model) : model_(model), rest_(points_of(model.rest)) {
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    mobility_.push_back(model.is_kinematic(i) ? 0.0 : 1.0 / model.mass[i]);
}

std::optional<Contacts::Pair> Contacts::pair_of(std::uint32_t point, std::uint32_t tetrahedron,
                                                const Points& places) const {
  if (model_.is_ignored_contact(point, tetrahedron)) return std::nullopt;
  Pair pair{};
  pair.point = point;
  pair.tetrahedron = tetrahedron;
  for (std::size_t k = 0; k < 4; ++k) pair.corners[k] = model_.contact_tetrahedron[4 * tetrahedron + k];
  const shader::ContactPoint& of = model_.contact[point];
  const Matrix3d edges = edges_of(pair.corners, places);
  if (!(edges.determinant() > 0.0)) return std::nullopt;
  const Matrix3d inverse = edges.inverse();
  const Vector3d in_edges = inverse * (places[of.vertex] - places[pair.corners[0]]);
  pair.weights << 1.0 - in_edges.sum(), in_edges;
  if (pair.weights.minCoeff() < 0.0) return std::nullopt;

  bool can_move = mobility_[of.vertex] > 0.0;
  Vector3d apart = -rest_[of.vertex];
  Vector4d depths;
  bool is_across_a_gap = true;
  for (int k = 0; k < 4; ++k) {
    const std::uint32_t i = pair.corners[std::size_t(k)];
    can_move = can_move || mobility_[i] > 0.0;
    apart += pair.weights[k] * rest_[i];
    depths[k] = double{model::contact_depth_of(model_, point, i)};
    is_across_a_gap = is_across_a_gap && model::is_across_a_gap(model_, of, i);
  }
  const bool is_far = apart.norm() > double(of.margin);
  if (!can_move || !(is_far || is_across_a_gap)) return std::nullopt;

  const double depth = pair.weights.dot(depths);
  const double pushed =
      is_far ? std::min(depth, (apart.norm() - double(of.margin)) / 2.0) : depth - double(of.allowance);
  const Vector3d gradient = inverse.transpose() * (depths.tail<3>() - Vector3d::Constant(depths[0]));
  pair.push = pair.normal = Vector3d::Zero();
  if (pushed > 0.0 && gradient.norm() >= least_gradient) {
    pair.push = -pushed / std::max(1.0, gradient.squaredNorm()) * gradient;
    pair.normal = -gradient.normalized();
  }
  return pair;
}

std::vector<Contacts::Pair> Contacts::found_at(const Points& places) const {
  std::vector<Pair> pairs;
  const std::uint32_t tetrahedra = model_.contact_tetrahedron_count();
  std::vector<Eigen::AlignedBox3d> boxes(tetrahedra);
  for (std::uint32_t t = 0; t < tetrahedra; ++t)
    for (std::size_t k = 0; k < 4; ++k) boxes[t].extend(places[model_.contact_tetrahedron[4 * t + k]]);
  for (std::uint32_t p = 0; p < model_.contact.size(); ++p)
    for (std::uint32_t t = 0; t < tetrahedra; ++t) {
      if (!boxes[t].contains(places[model_.contact[p].vertex])) continue;
      const std::optional<Pair> pair = pair_of(p, t, places);
      if (!pair) continue;
      pairs.push_back(*pair);
      break;
    }
  return pairs;
}

std::vector<double> Contacts::loads(const std::vector<Pair>& pairs, const std::vector<double>& mobility,
                                    double least) const {
  std::vector<double> crowd(mobility.size(), 0.0);
  for (const Pair& pair : pairs) {
    crowd[model_.contact[pair.point].vertex] += 1.0;
    for (int k = 0; k < 4; ++k) crowd[pair.corners[std::size_t(k)]] += pair.weights[k];
  }
  for (std::size_t i = 0; i < crowd.size(); ++i) crowd[i] = mobility[i] * std::max(least, crowd[i]);
  return crowd;
}

// The point's value minus that at its place in the tetrahedron.
Vector3d Contacts::difference(const Pair& pair, const Points& of) const {
  Vector3d there = Vector3d::Zero();
  for (int k = 0; k < 4; ++k) there += pair.weights[k] * of[pair.corners[std::size_t(k)]];
  return of[model_.contact[pair.point].vertex] - there;
}

double Contacts::load_of(const Pair& pair, const std::vector<double>& loads) const {
  double load = loads[model_.contact[pair.point].vertex];
  for (int k = 0; k < 4; ++k) load += pair.weights[k] * loads[pair.corners[std::size_t(k)]];
  return load;
}

// The impulse, before division by the load, that moves the point by `wanted` along n if it would otherwise
// move by `moved`.
Vector3d Contacts::push_of(const Pair& pair, const Vector3d& moved, double wanted) const {
  const double along = moved.dot(pair.normal);
  const double pushed = std::max(0.0, wanted - along);
  const Vector3d sliding = moved - along * pair.normal;
  Vector3d impulse = pushed * pair.normal;
  if (sliding.norm() > 0.0)
    impulse -= std::min(1.0, double(model_.contact[pair.point].friction) * pushed / sliding.norm()) * sliding;
  return impulse;
}

void Contacts::give(const Pair& pair, const Vector3d& impulse, const std::vector<double>& mobility,
                    Points& gains) const {
  const std::uint32_t s = model_.contact[pair.point].vertex;
  gains[s] += mobility[s] * impulse;
  for (int k = 0; k < 4; ++k) {
    const std::uint32_t i = pair.corners[std::size_t(k)];
    gains[i] -= pair.weights[k] * mobility[i] * impulse;
  }
}

Points Contacts::velocity_gains(const std::vector<Pair>& pairs, const Points& v, double h) const {
  const std::vector<double> all = loads(pairs, mobility_, least_crowd);
  Points gains(v.size(), Vector3d::Zero());
  for (const Pair& pair : pairs)
    if (const double load = load_of(pair, all); load > 0.0)
      give(pair, push_of(pair, difference(pair, v), pair.push.dot(pair.normal) / h) / load, mobility_, gains);
  return gains;
}

Points Contacts::held_moves(std::vector<Pair>& pairs, const Points& moved,
                            const std::vector<double>& yielding, double step) const {
  const std::vector<double> all = loads(pairs, yielding, 1.0);
  const double depth_share = std::min(most_depth_share, depth_rate * step);
  Points moves(moved.size(), Vector3d::Zero());
  for (Pair& pair : pairs) {
    pair.presses = false;
    const double load = load_of(pair, all);
    if (!(load > 0.0)) continue;
    const double full = full_depth * double(model_.contact[pair.point].margin);
    const Vector3d impulse = std::min(1.0, pair.push.norm() / full) / load *
                             push_of(pair, difference(pair, moved), depth_share * pair.push.dot(pair.normal));
    pair.presses = impulse.dot(pair.normal) > 0.0;
    give(pair, impulse, yielding, moves);
  }
  return moves;
}

Points Contacts::settling_gains(const std::vector<Pair>& pairs, const Points& v, const Points& v_before,
                                double history) const {
  const std::vector<double> all = loads(pairs, mobility_, 0.0);
  Points gains(v.size(), Vector3d::Zero());
  for (const Pair& pair : pairs) {
    double load = load_of(pair, all);
    for (int k = 0; k < 4; ++k)
      load = std::max(load, pair.weights[k] * mobility_[pair.corners[std::size_t(k)]] / most_settling);
    if (!pair.presses || !(load > 0.0)) continue;
    // The next substep continues with v + history (v - v_before).
    const double rest = history / (1.0 + history) * difference(pair, v_before).dot(pair.normal);
    give(pair, (rest - difference(pair, v).dot(pair.normal)) / load * pair.normal, mobility_, gains);
  }
  return gains;
}

}  // namespace fascicle::cpu_reference
