#include "host/studio/hand.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <stdexcept>

namespace fascicle::studio {

namespace {

// Where nothing is known yet flesh is taken to be as soft as swings twice a second: a first pull that is too
// weak does no harm.
constexpr double first_stiffness = 158.0;  // (2 pi 2 Hz)^2, 1/s^2
constexpr double most_stiffness = 4e6;     // (2 pi 318 Hz)^2
// A frame's pull tells more of the flesh's inertia than of its stiffness: what it seems to be stiffer by in
// one frame is believed by so much.
constexpr double belief = 1.5;
// 1/s: how fast what moves relative to the hand is slowed down.
constexpr double braking = 8.0;
// Shares of the body's extent: further than that no hand pulls.
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
  if (vertex >= model.vertex_count) throw std::invalid_argument("the hand's vertex is none of the model's");
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

Vector3d Hand::middle(const std::vector<float>& positions, const std::array<double, 3>& origin) const {
  Vector3d sum = Vector3d::Zero();
  for (const auto& [i, share] : held_) {
    const float* p = &positions[3 * std::size_t{i}];
    sum += double{share} * Vector3d(double{p[0]}, double{p[1]}, double{p[2]});
  }
  return Vector3d(origin[0], origin[1], origin[2]) + sum * (unit_ / share_);
}

void Hand::move(const Vector3d& place) {
  wanted_ = place - grip_;
}

void Hand::push(const Vector3d& force) {
  wanted_.reset();
  acceleration_ = force / mass_;
}

void Hand::see(const model::Frame& frame, double seconds) {
  if (!wanted_) return;
  // Where the flesh would be if nobody pulled.
  const Vector3d free = frame.skinned.empty() ? still_ : Vector3d(middle(frame.skinned, frame.origin) + lag_);
  const Vector3d gone = middle(frame.positions, frame.origin) - free;
  const Vector3d velocity = (gone - last_) / seconds;
  last_ = gone;
  const double pulled = acceleration_.norm();
  if (pulled > 0.0) {
    // Along the pull; what has hardly moved yet seems as stiff as can be.
    const double along = gone.dot(acceleration_) / pulled;
    const double seen = along > 0.0 ? pulled / along : most_stiffness;
    stiffness_ = std::clamp(seen, stiffness_ / belief, stiffness_ * belief);
    stiffness_ = std::clamp(stiffness_, first_stiffness / 16.0, most_stiffness);
  }
  const Vector3d way = limited(*wanted_ - free, reach_);
  acceleration_ = stiffness_ * way - braking * velocity;
}

std::vector<shader::Force> Hand::forces(const model::Drive& drive, std::uint32_t forces_of_scene) const {
  const Vector3d a = acceleration_ / unit_;
  const shader::Force own{static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2]), 0.0f};
  std::vector<shader::Force> all;
  for (std::uint32_t s = 0; s < drive.substeps; ++s) {
    const auto first = drive.forces.begin() + static_cast<std::ptrdiff_t>(std::size_t{s} * forces_of_scene);
    all.insert(all.end(), first, first + static_cast<std::ptrdiff_t>(forces_of_scene));
    all.push_back(own);
  }
  return all;
}

}  // namespace fascicle::studio
