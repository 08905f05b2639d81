#include "cpu_reference/contact_search.h"

#include <algorithm>
#include <array>
#include <limits>

#include "cpu_reference/contact_meets.h"
#include "cpu_reference/contact_stages.h"

namespace fascicle::cpu_reference {

namespace {

// Vertices, and points, that one piece of work takes.
constexpr std::uint32_t part_size = 256;
// The lists' reach in margins: farther ones are longer and hold for longer.
constexpr float reach_in_margins = 0.75f;
// Motions and distances are rounded; both are below 4 working units.
constexpr float rounding = 2e-6f;

constexpr std::size_t sight_stride = 4;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr ContactBox no_box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};

// Along the axis where the two are farthest apart; below 0 within the box.
float distance_to(const ContactBox& box, const float* x) {
  const auto along = [](float low, float high, float at) { return std::max(low - at, at - high); };
  return std::max({along(box.low.x, box.high.x, x[0]), along(box.low.y, box.high.y, x[1]),
                   along(box.low.z, box.high.z, x[2])});
}

float squared_distance(const float* a, const float* b) {
  const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

}  // namespace

ContactSearch::ContactSearch(const model::Model& model) : model_(model) {
  float margin = 0.0f;
  for (const shader::ContactPoint& point : model.contact) margin = std::max(margin, point.margin);
  reach_ = reach_in_margins * margin;
  sights_.resize(sight_stride * model.vertex_count);
  motions_.resize(6 * std::size_t{model::parts_of(model.vertex_count, part_size)});
  const std::uint32_t parts = model::parts_of(static_cast<std::uint32_t>(model.contact.size()), part_size);
  lists_.resize(parts);
  first_.resize(std::size_t{parts} * (part_size + 1));
}

void ContactSearch::run(const SubstepInput& in, Fields& fields, ThreadPool& pool) {
  look(in, fields, pool);
  motion_ = motion();
  // Not a number, as of a body that left the numbers, is no known motion.
  if (!(motion_ <= reach_)) {
    renew(pool);
    motion_ = 0.0f;
  }
  find(fields, pool);
  press(in, fields);
}

// Where everything is, and how each part of the body has moved since the lists were made.
void ContactSearch::look(const SubstepInput& in, const Fields& fields, ThreadPool& pool) {
  pool.run(model::parts_of(model_.vertex_count, part_size), [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t part = first; part < last; ++part) {
      ContactBox moved = no_box;
      const std::uint32_t end = std::min((part + 1) * part_size, model_.vertex_count);
      for (std::uint32_t i = part * part_size; i < end; ++i) {
        float* to = sights_.data() + sight_stride * i;
        put_place(to, contact_sight(model_, in, fields, i));
        if (sights_then_.empty()) continue;
        const float* then = sights_then_.data() + sight_stride * i;
        // What is no number passes all comparisons by: it is caught here.
        Place by{to[0] - then[0], to[1] - then[1], to[2] - then[2]};
        if (!(by.x + by.y + by.z < infinity)) by = {infinity, infinity, infinity};
        grow(moved, {by, by});
      }
      put_contact_box(motions_, part, moved);
    }
  });
}

// The most by which two vertices may have moved against each other along an axis since the lists were made.
float ContactSearch::motion() const {
  if (sights_then_.empty()) return infinity;
  ContactBox moved = no_box;
  for (std::uint32_t part = 0; 6 * std::size_t{part} < motions_.size(); ++part)
    grow(moved, contact_box_at(motions_, part));
  return std::max({moved.high.x - moved.low.x, moved.high.y - moved.low.y, moved.high.z - moved.low.z}) +
         rounding;
}

void ContactSearch::renew(ThreadPool& pool) {
  ++renewals_;
  sights_then_ = sights_;
  std::vector<float> leaves(6 * std::size_t{model_.contact_leaf_count()}),
      branches(6 * std::size_t{model_.contact_branch_count()});
  const auto place_of = [&](std::uint32_t i) { return place_at(sights_.data() + sight_stride * i); };
  pool.run(model_.contact_leaf_count(), [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t leaf = first; leaf < last; ++leaf)
      put_contact_box(leaves, leaf, contact_leaf_box(model_, leaf, place_of));
  });
  for (std::uint32_t branch = 0; branch < model_.contact_branch_count(); ++branch)
    put_contact_box(branches, branch, contact_branch_box(model_, branch, leaves));
  const auto count = static_cast<std::uint32_t>(model_.contact.size());
  pool.run(static_cast<std::uint32_t>(lists_.size()), [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t part = first; part < last; ++part) {
      lists_[part].clear();
      std::uint32_t* begin = first_.data() + std::size_t{part} * (part_size + 1);
      *begin++ = 0;
      for (std::uint32_t p = part * part_size; p < std::min((part + 1) * part_size, count); ++p) {
        list_candidates(p, leaves, branches, lists_[part]);
        *begin++ = static_cast<std::uint32_t>(lists_[part].size());
      }
    }
  });
}

// Those nearest to touching first: until they may touch, none of the others does.
void ContactSearch::list_candidates(std::uint32_t point, const std::vector<float>& leaf_boxes,
                                    const std::vector<float>& branch_boxes,
                                    std::vector<Candidate>& list) const {
  const shader::ContactPoint& of = model_.contact[point];
  const float* x = sights_.data() + sight_stride * of.vertex;
  const float* rest = model_.rest.data() + 3 * std::size_t{of.vertex};
  const float least_square = 0.99f * (of.margin * of.margin);
  const bool can_move = model_.mobility[of.vertex] > 0.0f;
  const std::uint32_t leaves = model_.contact_leaf_count();
  const float reach = reach_ + rounding;
  const std::size_t first = list.size();
  for (std::uint32_t branch = 0; branch < model_.contact_branch_count(); ++branch) {
    if (distance_to(contact_box_at(branch_boxes, branch), x) > reach ||
        contact_is_near_at_rest(model_, point, leaves + branch))
      continue;
    const std::uint32_t last_leaf = std::min((branch + 1) * shader::contact_branch, leaves);
    for (std::uint32_t leaf = branch * shader::contact_branch; leaf < last_leaf; ++leaf) {
      if (distance_to(contact_box_at(leaf_boxes, leaf), x) > reach ||
          contact_is_near_at_rest(model_, point, leaf))
        continue;
      const std::uint32_t end =
          std::min((leaf + 1) * shader::contact_leaf, model_.contact_tetrahedron_count());
      for (std::uint32_t t = leaf * shader::contact_leaf; t < end; ++t) {
        ContactBox box = no_box;
        bool is_near = of.near_count == 0, moves = can_move;
        for (const std::uint32_t i : corners_of(model_, t)) {
          const float* corner = sights_.data() + sight_stride * i;
          grow(box, {place_at(corner), place_at(corner)});
          is_near = is_near && squared_distance(model_.rest.data() + 3 * std::size_t{i}, rest) < least_square;
          moves = moves || model_.mobility[i] > 0.0f;
        }
        const float distance = distance_to(box, x);
        if (distance <= reach && !is_near && moves) list.push_back({t, distance - rounding});
      }
    }
  }
  std::sort(list.begin() + static_cast<std::ptrdiff_t>(first), list.end(),
            [](const Candidate& a, const Candidate& b) {
              return a.distance != b.distance ? a.distance < b.distance : a.tetrahedron < b.tetrahedron;
            });
}

void ContactSearch::find(Fields& fields, ThreadPool& pool) {
  const auto place_of = [&](std::uint32_t i) { return place_at(sights_.data() + sight_stride * i); };
  const auto count = static_cast<std::uint32_t>(model_.contact.size());
  pool.run(static_cast<std::uint32_t>(lists_.size()), [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t part = first; part < last; ++part) {
      const std::uint32_t* begin = first_.data() + std::size_t{part} * (part_size + 1);
      for (std::uint32_t p = part * part_size; p < std::min((part + 1) * part_size, count); ++p, ++begin) {
        std::uint32_t found = shader::no_contact;
        const Candidate *candidate = lists_[part].data() + begin[0], *end = lists_[part].data() + begin[1];
        for (; candidate != end && candidate->distance <= motion_; ++candidate)
          if (candidate->tetrahedron < found &&
              contact_meets(model_, fields, p, place_of(model_.contact[p].vertex), candidate->tetrahedron,
                            place_of))
            found = candidate->tetrahedron;
        fields.contact_found[p] = found;
      }
    }
  });
}

// There are few contacts: one thread takes them tetrahedron by tetrahedron, which for every vertex is the
// order in which contact_crowd and contact add.
void ContactSearch::press(const SubstepInput& in, Fields& fields) {
  found_.clear();
  for (std::uint32_t p = 0; p < model_.contact.size(); ++p)
    if (fields.contact_found[p] != shader::no_contact) found_.push_back({fields.contact_found[p], p});
  std::sort(found_.begin(), found_.end());
  for (const std::uint32_t i : touched_)
    put_place(fields.pressed.data() + vector_stride * std::size_t{i}, {0.0f, 0.0f, 0.0f});
  touched_.clear();

  std::vector<float>& crowd = fields.contact_crowd;
  const auto weights_of = [&](std::uint32_t p) {
    return fields.contact_place.data() + contact_place_stride * p;
  };
  for (const auto& [t, p] : found_)
    for (const std::uint32_t i : corners_of(model_, t)) crowd[i] = 0.0f;
  for (const auto& [t, p] : found_) crowd[model_.contact[p].vertex] = 1.0f;
  for (const auto& [t, p] : found_)
    for (std::size_t k = 0; k < 4; ++k) crowd[corners_of(model_, t)[k]] += weights_of(p)[k];
  for (const auto& [t, p] : found_) contact_press(model_, in, fields, {p, p + 1});

  // Until the last loop `pressed` holds sums, and its fourth number tells whether there is one.
  const auto add = [&](std::uint32_t i, const Place& term) {
    float* sum = fields.pressed.data() + vector_stride * std::size_t{i};
    const bool is_first = sum[3] == 0.0f;
    put_place(sum, is_first ? term : kernel::contact_add<float>(place_at(sum), term));
    if (!is_first) return;
    sum[3] = 1.0f;
    touched_.push_back(i);
  };
  const auto impulse_of = [&](std::uint32_t p) {
    return place_at(fields.contact_impulse.data() + 3 * std::size_t{p});
  };
  for (const auto& [t, p] : found_) add(model_.contact[p].vertex, impulse_of(p));
  for (const auto& [t, p] : found_)
    for (std::size_t k = 0; k < 4; ++k)
      add(corners_of(model_, t)[k], kernel::contact_term<float>(-weights_of(p)[k], impulse_of(p)));
  for (const std::uint32_t i : touched_) {
    float* sum = fields.pressed.data() + vector_stride * std::size_t{i};
    sum[3] = 0.0f;
    put_place(sum, kernel::contact_acceleration<float>(place_at(sum), model_.mobility[i], in.step.inverse_h));
  }
}

}  // namespace fascicle::cpu_reference
