// The test of stage contact for a point and a tetrahedron, shared by its plain form (contact_stages.h) and
// CpuSolver's search (contact_search.h).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "cpu_reference/solver/fields.h"
#include "cpu_reference/solver/stages.h"
#include "host/model/contact_depth.h"
#include "host/model/contact_near.h"
#include "host/model/model.h"
#include "shaders/kernel/contact.inc"

namespace fascicle::cpu_reference {

using Place = kernel::Vector<float>;

// Floats per point in Fields::contact_place.
inline constexpr std::size_t contact_place_stride = 10;

inline Place place_at(const float* from) {
  return {from[0], from[1], from[2]};
}

inline float* put_place(float* to, const Place& v) {
  for (const float part : {v.x, v.y, v.z}) *to++ = part;
  return to;
}

inline Place velocity_of(const Fields& fields, std::uint32_t i) {
  return place_at(fields.velocities.data() + vector_stride * std::size_t{i});
}

inline Place position_of(const Fields& fields, std::uint32_t i) {
  return place_at(fields.vertices.data() + vertex_stride * std::size_t{i});
}

inline Place rest_sight(const model::Model& model, std::uint32_t i) {
  return place_at(model.rest.data() + 3 * std::size_t{i});
}

inline std::span<const std::uint32_t, 4> corners_of(const model::Model& model, std::uint32_t t) {
  return std::span<const std::uint32_t, 4>(model.contact_tetrahedron.data() + 4 * std::size_t{t}, 4);
}

struct ContactBox {
  Place low, high;
};

// An empty box. NaN extends no box.
inline constexpr ContactBox empty_contact_box{{3.0e38f, 3.0e38f, 3.0e38f}, {-3.0e38f, -3.0e38f, -3.0e38f}};

inline void grow(ContactBox& box, const ContactBox& other) {
  const auto lower = [](float& a, float b) { a = b < a ? b : a; };
  const auto higher = [](float& a, float b) { a = b > a ? b : a; };
  lower(box.low.x, other.low.x);
  lower(box.low.y, other.low.y);
  lower(box.low.z, other.low.z);
  higher(box.high.x, other.high.x);
  higher(box.high.y, other.high.y);
  higher(box.high.z, other.high.z);
}

// A box is stored as six floats.
inline ContactBox contact_box_at(const std::vector<float>& boxes, std::uint32_t number) {
  const float* from = boxes.data() + 6 * std::size_t{number};
  return {place_at(from), place_at(from + 3)};
}
inline void put_contact_box(std::vector<float>& boxes, std::uint32_t number, const ContactBox& box) {
  put_place(put_place(boxes.data() + 6 * std::size_t{number}, box.low), box.high);
}

// The box around the corners of a leaf's tetrahedra; place_of(i) is vertex i's position.
template <class PlaceOf>
ContactBox contact_leaf_box(const model::Model& model, std::uint32_t leaf, const PlaceOf& place_of) {
  const std::uint32_t first = leaf * shader::contact_leaf,
                      end = std::min(first + shader::contact_leaf, model.contact_tetrahedron_count());
  ContactBox box = empty_contact_box;
  for (std::uint32_t t = first; t < end; ++t)
    for (const std::uint32_t i : corners_of(model, t)) {
      const Place corner = place_of(i);
      grow(box, {corner, corner});
    }
  return box;
}

// The box around the boxes of a branch's leaves.
inline ContactBox contact_branch_box(const model::Model& model, std::uint32_t branch,
                                     const std::vector<float>& leaf_boxes) {
  const std::uint32_t first = branch * shader::contact_branch,
                      end = std::min(first + shader::contact_branch, model.contact_leaf_count());
  ContactBox box = empty_contact_box;
  for (std::uint32_t leaf = first; leaf < end; ++leaf) grow(box, contact_box_at(leaf_boxes, leaf));
  return box;
}

// Whether a whole box at rest (Model::contact_rest_box) is too near to point p to be met.
inline bool contact_is_near_at_rest(const model::Model& model, std::uint32_t p, std::uint32_t box) {
  const shader::ContactPoint& point = model.contact[p];
  if (point.near_count > 0) return false;
  const float* from = model.contact_rest_box.data() + 8 * std::size_t{box};
  return kernel::contact_is_near<float>(rest_sight(model, point.vertex), place_at(from), place_at(from + 4),
                                        point.margin);
}

// Applies the sum of its impulses to vertex i: in an explicit pass, in an iteration, to velocities.
inline void contact_apply(const model::Model& model, const SubstepInput& in, Fields& fields, std::uint32_t i,
                          const Place& sum) {
  const Place gain = kernel::contact_gain<float>(sum, model.mobility[i]);
  float* position = fields.vertices.data() + vertex_stride * std::size_t{i};
  put_place(position, kernel::contact_moved<float>(place_at(position), gain, in.step.h));
  float* velocity = fields.velocities.data() + vector_stride * std::size_t{i};
  put_place(velocity, kernel::contact_changed<float>(place_at(velocity), gain));
}

inline void contact_apply_yield(const model::Model& model, const SubstepInput& in, Fields& fields,
                                std::uint32_t i, const Place& sum) {
  if (model.is_kinematic(i)) return;
  const shader::Response& answer = in.responses[i];
  const Place move =
      kernel::contact_gain<float>(sum, kernel::contact_yielding<float>(model.mobility[i], answer.to_inertia));
  float* position = fields.vertices.data() + vertex_stride * std::size_t{i};
  put_place(position, kernel::contact_changed<float>(place_at(position), move));
  float* goal = fields.goals.data() + vector_stride * std::size_t{i};
  put_place(goal, kernel::contact_goal<float>(place_at(goal), move, answer.to_goal));
}

inline void contact_apply_rest(const model::Model& model, const SubstepInput&, Fields& fields,
                               std::uint32_t i, const Place& sum) {
  if (model.is_kinematic(i)) return;
  float* velocity = fields.velocities.data() + vector_stride * std::size_t{i};
  put_place(velocity, kernel::contact_changed<float>(place_at(velocity),
                                                     kernel::contact_gain<float>(sum, model.mobility[i])));
}

// Whether point p at `x` lies in tetrahedron t and may meet it; place_of(i) is vertex i's position. If so,
// writes its contact_place.
template <class PlaceOf>
bool contact_meets(const model::Model& model, Fields& fields, std::uint32_t p, const Place& x,
                   std::uint32_t t, const PlaceOf& place_of) {
  if (model.is_ignored_contact(p, t)) return false;
  const auto corner = corners_of(model, t);
  const Place a = place_of(corner[0]), b = place_of(corner[1]), c = place_of(corner[2]),
              d = place_of(corner[3]);
  if (!kernel::contact_is_in_box<float>(x, a, b, c, d)) return false;
  const auto volumes = kernel::contact_volumes<float>(x, a, b, c, d);
  if (!kernel::contact_is_inside<float>(volumes)) return false;
  const shader::ContactPoint& point = model.contact[p];
  const std::array<std::uint32_t, 5> all{point.vertex, corner[0], corner[1], corner[2], corner[3]};
  if (std::none_of(all.begin(), all.end(), [&](std::uint32_t i) { return model.mobility[i] > 0.0f; }))
    return false;
  const auto weights = kernel::contact_weights<float>(volumes);
  const Place apart = kernel::contact_apart<float>(
      weights, rest_sight(model, point.vertex), rest_sight(model, corner[0]), rest_sight(model, corner[1]),
      rest_sight(model, corner[2]), rest_sight(model, corner[3]));
  const float squared = kernel::inner_product<float>(apart, apart);
  const bool is_far = squared > point.margin * point.margin;
  const auto is_across_a_gap = [&](std::uint32_t i) { return model::is_across_a_gap(model, point, i); };
  if (!is_far && !std::all_of(corner.begin(), corner.end(), is_across_a_gap)) return false;
  const auto depth_of = [&](std::size_t k) { return model::contact_depth_of(model, p, corner[k]); };
  const float depth =
      kernel::contact_mean<float>(weights, depth_of(0), depth_of(1), depth_of(2), depth_of(3));
  const float pushed =
      is_far ? kernel::contact_depth_beyond<float>(depth, squared, point.margin) : depth - point.allowance;
  const auto push =
      kernel::contact_push<float>(volumes, pushed, depth_of(0), depth_of(1), depth_of(2), depth_of(3));
  float* to = fields.contact_place.data() + contact_place_stride * p;
  for (const float weight : {weights.a, weights.b, weights.c, weights.d}) *to++ = weight;
  put_place(put_place(to, push.push), push.normal);
  return true;
}

}  // namespace fascicle::cpu_reference
