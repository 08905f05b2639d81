#include "host/studio/hand.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <stdexcept>

namespace fascicle::studio {

namespace {

// Initial guess: flesh that swings at 2 Hz. This is soft, because a first pull that is too weak does no harm.
constexpr double first_stiffness = 158.0;  // (2 pi 2 Hz)^2, 1/s^2
constexpr double least_stiffness = 10.0, most_stiffness = 4e6;
constexpr double most_moved = 1000.0;
// Decay of older frames' weight per frame, and the largest factor by which one frame may change an estimate.
constexpr double memory = 0.9, belief = 2.0;
// Weights of the previous estimates relative to the frames' data. They decide when nothing moves, because
// such frames carry no information.
constexpr double share_of_moved = 1e-3, share_of_stiffness = 1e-6;
// 1/s: natural frequency at which soft flesh approaches its target, critically damped.
constexpr double hand_pace = 12.0;
// Fractions of the remaining error that a frame corrects.
constexpr double share_of_soft = 0.3, share_of_stiff = 0.3;
// Limits on stiffness times frame time squared: below the first flesh counts as soft, above the second as
// stiff.
constexpr double soft_below = 0.3, stiff_above = 1.0;
// Fraction of the body's extent: the hand's longest pull.
constexpr double longest_pull = 0.3;
constexpr float least_share = 0.01f;

Vector3d rest_of(const model::Model& model, std::uint32_t i) {
  const float* p = &model.rest[3 * std::size_t{i}];
  return Vector3d(double{p[0]}, double{p[1]}, double{p[2]}) * model.unit;
}

Vector3d limited(const Vector3d& v, double most) {
  const double length = v.norm();
  return length > most ? Vector3d(v * (most / length)) : v;
}

}  // namespace

Held held_around(const model::Model& model, std::uint32_t vertex, double radius) {
  if (vertex >= model.vertex_count) throw std::invalid_argument("the model has no such vertex");
  const Vector3d centre = rest_of(model, vertex);
  std::vector<char> seen(model.vertex_count, 0);
  std::queue<std::uint32_t> next;
  next.push(vertex);
  seen[vertex] = 1;
  Held held;
  while (!next.empty()) {
    const std::uint32_t i = next.front();
    next.pop();
    const double x = (rest_of(model, i) - centre).norm() / radius;
    if (x >= 1.0 && i != vertex) continue;
    const double fall = i == vertex ? 1.0 : (1.0 - x * x) * (1.0 - x * x);
    const auto share = static_cast<float>(fall);
    if (!model.is_kinematic(i) && share >= least_share) held.emplace_back(i, share);
    for (std::uint32_t k = model.ring_offset[i]; k < model.ring_offset[i + 1]; ++k) {
      const std::uint32_t j = model.ring[k];
      if (seen[j] != 0) continue;
      seen[j] = 1;
      next.push(j);
    }
  }
  std::sort(held.begin(), held.end());
  return held;
}

model::Model with_hand(const model::Model& model, const Held& held) {
  model::Model result = model;
  const std::uint32_t number = result.force_count++;
  result.force_offset.assign(1, 0);
  result.force_index.clear();
  result.force_coefficient.clear();
  auto next = held.begin();
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (!model.force_offset.empty())
      for (std::uint32_t k = model.force_offset[i]; k < model.force_offset[i + 1]; ++k) {
        result.force_index.push_back(model.force_index[k]);
        result.force_coefficient.push_back(model.force_coefficient[k]);
      }
    if (next != held.end() && next->first == i) {
      result.force_index.push_back(number);
      result.force_coefficient.push_back(next->second);
      ++next;
    }
    result.force_offset.push_back(static_cast<std::uint32_t>(result.force_index.size()));
  }
  return result;
}

Hand::Hand(const model::Model& model, Held held, const model::Frame& frame, const Vector3d& place)
    : unit_(model.unit),
      held_(std::move(held)),
      reach_(longest_pull * model::extent(model)),
      stiffness_(first_stiffness) {
  for (const auto& [i, share] : held_) {
    share_ += double{share};
    mass_ += double{share} * model.mass[i];
  }
  still_ = middle(frame.positions, frame.origin);
  grip_ = place - still_;
  if (!frame.skinned.empty()) lag_ = still_ - middle(frame.skinned, frame.origin);
}

Vector3d Hand::mean(const std::vector<float>& values) const {
  Vector3d sum = Vector3d::Zero();
  for (const auto& [i, share] : held_) {
    const float* p = &values[3 * std::size_t{i}];
    sum += double{share} * Vector3d(double{p[0]}, double{p[1]}, double{p[2]});
  }
  return sum * (unit_ / share_);
}

Vector3d Hand::middle(const std::vector<float>& positions, const std::array<double, 3>& origin) const {
  return Vector3d(origin[0], origin[1], origin[2]) + mean(positions);
}

void Hand::move(const Vector3d& place) {
  wanted_ = place - grip_;
}

void Hand::push(const Vector3d& force) {
  wanted_.reset();
  acceleration_ = force / mass_;
}

// Least squares for pulled = m faster + K way.
void Hand::learn(const Vector3d& faster, const Vector3d& way, const Vector3d& pulled, double seconds) {
  const double square = seconds * seconds;
  const Vector3d spring = way / square;
  const auto add = [](double& sum, double value) { sum = memory * sum + value; };
  add(mass_mass_, faster.squaredNorm());
  add(mass_spring_, faster.dot(spring));
  add(spring_spring_, spring.squaredNorm());
  add(mass_pull_, faster.dot(pulled));
  add(spring_pull_, spring.dot(pulled));
  const double known = mass_mass_ + spring_spring_;
  if (!(known > 0.0)) return;
  const double mm = mass_mass_ + share_of_moved * known, ss = spring_spring_ + share_of_stiffness * known;
  const double mp = mass_pull_ + share_of_moved * known * moved_;
  const double sp = spring_pull_ + share_of_stiffness * known * stiffness_ * square;
  const double determinant = mm * ss - mass_spring_ * mass_spring_;
  if (!(determinant > 0.0)) return;
  const double moved = (mp * ss - sp * mass_spring_) / determinant;
  const double stiffness = (mm * sp - mass_spring_ * mp) / determinant / square;
  moved_ = std::clamp(std::clamp(moved, moved_ / belief, moved_ * belief), 1.0, most_moved);
  stiffness_ = std::clamp(std::clamp(stiffness, stiffness_ / belief, stiffness_ * belief), least_stiffness,
                          most_stiffness);
}

void Hand::see(const model::Frame& frame, double seconds) {
  const Vector3d pulled = (before_ + acceleration_) / 2.0;
  before_ = acceleration_;
  // Where the flesh would be without the hand.
  const Vector3d free = frame.skinned.empty() ? still_ : Vector3d(middle(frame.skinned, frame.origin) + lag_);
  const Vector3d of_free = free_ ? Vector3d((free - *free_) / seconds) : Vector3d(Vector3d::Zero());
  const Vector3d velocity = mean(frame.velocities) - of_free;
  const Vector3d way = middle(frame.positions, frame.origin) - free;
  if (free_ && wanted_) learn((velocity - velocity_) / seconds, way, pulled, seconds);
  free_ = free;
  velocity_ = velocity;
  if (!wanted_) return;
  const Vector3d wanted = limited(*wanted_ - free, reach_), missing = wanted - way;
  const double stiff = std::clamp(
      (stiffness_ / moved_ * seconds * seconds - soft_below) / (stiff_above - soft_below), 0.0, 1.0);
  const Vector3d of_soft = stiffness_ * (way + share_of_soft * missing) +
                           moved_ * (hand_pace * hand_pace * missing - 2.0 * hand_pace * velocity);
  const Vector3d of_stiff = acceleration_ + share_of_stiff * (stiffness_ * wanted - acceleration_);
  acceleration_ = (1.0 - stiff) * of_soft + stiff * of_stiff;
}

std::vector<shader::Force> Hand::forces(const model::Drive& drive, std::uint32_t forces_of_scene) const {
  std::vector<shader::Force> all;
  for (std::uint32_t s = 0; s < drive.substeps; ++s) {
    const auto first = drive.forces.begin() + static_cast<std::ptrdiff_t>(std::size_t{s} * forces_of_scene);
    all.insert(all.end(), first, first + static_cast<std::ptrdiff_t>(forces_of_scene));
    const double share = static_cast<double>(s + 1) / static_cast<double>(drive.substeps);
    const Vector3d a = (before_ + share * (acceleration_ - before_)) / unit_;
    all.push_back({static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2]), 0.0f});
  }
  return all;
}

}  // namespace fascicle::studio
