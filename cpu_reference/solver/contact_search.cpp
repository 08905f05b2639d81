#include "cpu_reference/solver/contact_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "cpu_reference/solver/contact_meets.h"
#include "cpu_reference/solver/contact_stages.h"

namespace fascicle::cpu_reference {

namespace {

// Motions and distances are rounded; both are below 4 working units.
constexpr float rounding = 4e-6f;
// Distances are taken anew after so many substeps, and when so many points a block have come too near to a
// leaf to be left out. Neither changes a result.
constexpr std::uint64_t most_runs = 48;
constexpr std::uint64_t most_looked_at = 40;
constexpr std::uint64_t least_runs = 4;

// How far candidates are looked for, in margins. Farther ones would make longer lists, which hold for longer.
constexpr float reach_in_margins = 0.4f;

constexpr std::size_t sight_stride = 4;
constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr ContactBox no_box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};

bool overlap(const ContactBox& a, const ContactBox& b) {
  return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
         a.low.z <= b.high.z && b.low.z <= a.high.z;
}

bool holds(const ContactBox& box, const Place& x) {
  return overlap(box, {x, x});
}

float squared(float x, float y, float z) {
  return x * x + y * y + z * z;
}

// The square of the most by which two things in these boxes of motions may have moved against each other.
// What is no number is infinite.
float squared_motion(const ContactBox& a, const ContactBox& b) {
  ContactBox both = a;
  grow(both, b);
  const float square = squared(both.high.x - both.low.x, both.high.y - both.low.y, both.high.z - both.low.z);
  return square < infinity ? square : infinity;
}

// By how much something has moved. What is no number, now or then, may have moved by any amount.
Place motion_between(const Place& then, const Place& now) {
  Place by = kernel::subtract<float>(now, then);
  for (float* part : {&by.x, &by.y, &by.z})
    if (std::isnan(*part)) *part = infinity;
  return by;
}

float distance_to(const ContactBox& box, const Place& x) {
  const auto along = [](float low, float high, float at) { return std::max({low - at, at - high, 0.0f}); };
  return std::sqrt(squared(along(box.low.x, box.high.x, x.x), along(box.low.y, box.high.y, x.y),
                           along(box.low.z, box.high.z, x.z)));
}

// A plane that a face lies in; `at` grows outward.
struct Plane {
  Place normal;
  float at = 0.0f;
};

// The planes of a tetrahedron. A flat one has no inside, and its planes are rounding: then there are none.
struct Planes {
  std::array<Plane, 4> plane{};
  std::size_t count = 0;
};
Planes planes_of(const std::array<Place, 4>& corner) {
  constexpr std::array<std::array<std::size_t, 4>, 4> faces{
      {{1, 2, 3, 0}, {0, 3, 2, 1}, {0, 1, 3, 2}, {0, 2, 1, 3}}};
  Planes planes;
  for (const auto& [a, b, c, opposite] : faces) {
    Place normal = kernel::vector_area<float>(kernel::subtract<float>(corner[b], corner[a]),
                                              kernel::subtract<float>(corner[c], corner[a]));
    const float length = std::sqrt(kernel::inner_product<float>(normal, normal));
    const float inward =
        kernel::inner_product<float>(kernel::subtract<float>(corner[opposite], corner[a]), normal);
    if (!(std::abs(inward) > 1e-3f * length * std::sqrt(length))) continue;
    const float scale = (inward > 0.0f ? -1.0f : 1.0f) / length;
    normal = {normal.x * scale, normal.y * scale, normal.z * scale};
    planes.plane[planes.count++] = {normal, kernel::inner_product<float>(normal, corner[a])};
  }
  return planes;
}

// The bits of a number below 2^10 at every third place.
std::uint32_t spread(std::uint32_t number) {
  std::uint32_t bits = 0;
  for (unsigned b = 0; b < 10; ++b) bits |= (number >> b & 1U) << (3 * b);
  return bits;
}

// Points along Morton's curve through the rest shape.
std::vector<std::uint32_t> ordered_points(const model::Model& model) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> keyed;
  for (std::uint32_t p = 0; p < model.contact.size(); ++p) {
    std::uint32_t code = 0;
    for (unsigned a = 0; a < 3; ++a) {
      const float along = (model.rest[3 * std::size_t{model.contact[p].vertex} + a] + 1.0f) * 512.0f;
      code |= spread(static_cast<std::uint32_t>(std::clamp(along, 0.0f, 1023.0f))) << a;
    }
    keyed.emplace_back(code, p);
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<std::uint32_t> order;
  for (const auto& [code, p] : keyed) order.push_back(p);
  return order;
}

}  // namespace

ContactSearch::ContactSearch(const model::Model& model) : model_(model), order_(ordered_points(model)) {
  sights_.resize(sight_stride * model.vertex_count);
  blocks_.resize(model::parts_of(static_cast<std::uint32_t>(order_.size()), block_size));
  leaf_offset_.push_back(0);
  for (std::uint32_t leaf = 0; leaf < model.contact_leaf_count(); ++leaf) {
    const std::size_t first = std::size_t{4} * leaf * shader::contact_leaf,
                      end = std::min(first + std::size_t{4} * shader::contact_leaf,
                                     model.contact_tetrahedron.size());
    std::vector<std::uint32_t> corners(model.contact_tetrahedron.begin() + static_cast<std::ptrdiff_t>(first),
                                       model.contact_tetrahedron.begin() + static_cast<std::ptrdiff_t>(end));
    std::sort(corners.begin(), corners.end());
    leaf_vertex_.insert(leaf_vertex_.end(), corners.begin(), std::unique(corners.begin(), corners.end()));
    leaf_offset_.push_back(static_cast<std::uint32_t>(leaf_vertex_.size()));
  }
  for (std::vector<float>* boxes : {&leaf_box_, &leaf_box_then_, &leaf_motion_})
    boxes->resize(6 * std::size_t{model.contact_leaf_count()});
  branch_box_.resize(6 * std::size_t{model.contact_branch_count()});
}

void ContactSearch::run(const SubstepInput& in, Fields& fields, ThreadPool& pool) {
  if (is_due()) {
    has_distances_ = false;
    for (Block& block : blocks_) block = {};
    runs_since_ = 0;
  }
  ++runs_since_;
  look(in, fields, pool);
  find(fields, pool);
  press(in, fields);
}

bool ContactSearch::is_due() const {
  if (runs_since_ < least_runs) return false;
  std::uint64_t looked_at = 0;
  for (const Block& block : blocks_) looked_at += block.looked_at;
  return runs_since_ >= most_runs || looked_at > most_looked_at * runs_since_ * blocks_.size();
}

// Where everything is, and how far the leaves have moved since the distances were taken.
void ContactSearch::look(const SubstepInput& in, const Fields& fields, ThreadPool& pool) {
  pool.run(model_.vertex_count, [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t i = first; i < last; ++i)
      put_place(sights_.data() + sight_stride * i, contact_sight(model_, in, fields, i));
  });
  const bool takes_distances = !has_distances_;
  if (takes_distances) sights_then_ = sights_;
  has_distances_ = true;
  pool.run(model_.contact_leaf_count(), [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t leaf = first; leaf < last; ++leaf) {
      ContactBox box = no_box, motion = no_box;
      for (std::uint32_t k = leaf_offset_[leaf]; k < leaf_offset_[leaf + 1]; ++k) {
        const std::size_t at = sight_stride * leaf_vertex_[k];
        const Place x = place_at(sights_.data() + at);
        const Place by = motion_between(place_at(sights_then_.data() + at), x);
        grow(box, {x, x});
        grow(motion, {by, by});
      }
      put_contact_box(leaf_box_, leaf, box);
      if (takes_distances) put_contact_box(leaf_box_then_, leaf, box);
      put_contact_box(leaf_motion_, leaf, motion);
    }
  });
  for (std::uint32_t branch = 0; branch < model_.contact_branch_count(); ++branch)
    put_contact_box(branch_box_, branch, contact_branch_box(model_, branch, leaf_box_));
}

void ContactSearch::find(Fields& fields, ThreadPool& pool) {
  pool.run(static_cast<std::uint32_t>(blocks_.size()), [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t block = first; block < last; ++block) find_in_block(block, fields);
  });
}

Place ContactSearch::sight_of(std::uint32_t vertex) const {
  return place_at(sights_.data() + sight_stride * vertex);
}

// Since the distances were taken.
Place ContactSearch::motion_of(std::uint32_t vertex) const {
  return motion_between(place_at(sights_then_.data() + sight_stride * vertex), sight_of(vertex));
}

// Leaves come in ascending order, so that a point's first find is that of the lowest number.
void ContactSearch::find_in_block(std::uint32_t block, Fields& fields) {
  const auto count = static_cast<std::uint32_t>(order_.size());
  const std::uint32_t begin = block * block_size, end = std::min(begin + block_size, count);
  ContactBox box = no_box, motion = no_box;
  for (std::uint32_t k = begin; k < end; ++k) {
    const std::uint32_t vertex = model_.contact[order_[k]].vertex;
    const Place x = sight_of(vertex), by = motion_of(vertex);
    grow(box, {x, x});
    grow(motion, {by, by});
    fields.contact_found[order_[k]] = shader::no_contact;
  }
  std::vector<Pair>& pairs = blocks_[block].pairs;
  std::size_t at = 0;
  const std::uint32_t leaves = model_.contact_leaf_count();
  for (std::uint32_t branch = 0; branch < model_.contact_branch_count(); ++branch) {
    if (!overlap(box, contact_box_at(branch_box_, branch))) continue;
    const std::uint32_t last = std::min((branch + 1) * shader::contact_branch, leaves);
    for (std::uint32_t leaf = branch * shader::contact_branch; leaf < last; ++leaf) {
      if (!overlap(box, contact_box_at(leaf_box_, leaf))) continue;
      while (at < pairs.size() && pairs[at].leaf < leaf) ++at;
      if (at == pairs.size() || pairs[at].leaf != leaf)
        pairs.insert(pairs.begin() + static_cast<std::ptrdiff_t>(at), make_pair(block, leaf));
      const Pair& pair = pairs[at];
      const float nearest = pair.nearest;
      if (nearest > 0.0f && squared_motion(contact_box_at(leaf_motion_, leaf), motion) < nearest * nearest)
        continue;
      find_in_pair(block, pair, fields);
    }
  }
}

void ContactSearch::find_in_pair(std::uint32_t block, const Pair& pair, Fields& fields) {
  const auto place_of = [&](std::uint32_t i) { return sight_of(i); };
  const auto count = static_cast<std::uint32_t>(order_.size());
  const std::uint32_t begin = block * block_size, end = std::min(begin + block_size, count);
  const ContactBox box = contact_box_at(leaf_box_, pair.leaf),
                   motion = contact_box_at(leaf_motion_, pair.leaf);
  const std::uint32_t leaf_begin = pair.leaf * shader::contact_leaf,
                      leaf_size =
                          std::min(shader::contact_leaf, model_.contact_tetrahedron_count() - leaf_begin);
  for (std::uint32_t k = begin; k < end; ++k) {
    const std::uint32_t p = order_[k];
    if (fields.contact_found[p] != shader::no_contact) continue;
    const std::uint32_t vertex = model_.contact[p].vertex;
    const Place x = sight_of(vertex), by = motion_of(vertex);
    if (!holds(box, x)) continue;
    const float square = squared_motion(motion, {by, by});
    std::uint32_t found = shader::no_contact;
    const auto look_at = [&](std::uint32_t number) {
      ++blocks_[block].looked_at;
      if (leaf_begin + number < found && contact_meets(model_, fields, p, x, leaf_begin + number, place_of))
        found = leaf_begin + number;
    };
    if (!(square < pair.others * pair.others)) {
      for (std::uint32_t number = 0; number < leaf_size && found == shader::no_contact; ++number)
        look_at(number);
    } else {
      for (std::uint32_t c = pair.first[k - begin]; c < pair.first[k - begin + 1]; ++c) {
        const Candidate& candidate = pair.candidates[c];
        if (candidate.distance > 0.0f && square < candidate.distance * candidate.distance) break;
        look_at(candidate.number);
      }
    }
    fields.contact_found[p] = found;
  }
}

ContactSearch::Pair ContactSearch::make_pair(std::uint32_t block, std::uint32_t leaf) const {
  Pair pair;
  pair.leaf = leaf;
  const auto count = static_cast<std::uint32_t>(order_.size());
  const std::uint32_t begin = block * block_size, size = std::min(block_size, count - begin);
  const auto then = [&](std::uint32_t i) { return place_at(sights_then_.data() + sight_stride * i); };
  ContactBox box = no_box;
  float margin = 0.0f;
  for (std::uint32_t k = 0; k < size; ++k) {
    const shader::ContactPoint& point = model_.contact[order_[begin + k]];
    const Place x = then(point.vertex);
    grow(box, {x, x});
    margin = std::max(margin, point.margin);
  }
  const float reach = reach_in_margins * margin;
  pair.others = reach - rounding;
  pair.nearest = pair.others;
  std::array<std::vector<Candidate>, block_size> of_point;
  const std::uint32_t first = leaf * shader::contact_leaf,
                      last = std::min(first + shader::contact_leaf, model_.contact_tetrahedron_count());
  for (std::uint32_t t = first; t < last; ++t) {
    const auto corners = corners_of(model_, t);
    std::array<Place, 4> places{};
    ContactBox around = no_box;
    bool corner_moves = false;
    for (std::size_t c = 0; c < 4; ++c) {
      places[c] = then(corners[c]);
      grow(around, {places[c], places[c]});
      corner_moves = corner_moves || model_.mobility[corners[c]] > 0.0f;
    }
    const ContactBox grown{{around.low.x - reach, around.low.y - reach, around.low.z - reach},
                           {around.high.x + reach, around.high.y + reach, around.high.z + reach}};
    if (!overlap(grown, box)) continue;
    Planes planes;
    bool has_planes = false;
    for (std::uint32_t k = 0; k < size; ++k) {
      const shader::ContactPoint& point = model_.contact[order_[begin + k]];
      if (!corner_moves && !(model_.mobility[point.vertex] > 0.0f)) continue;
      const Place x = then(point.vertex);
      if (!holds(grown, x)) continue;
      const auto is_near = [&](std::uint32_t i) {
        const Place apart = kernel::subtract<float>(rest_sight(model_, i), rest_sight(model_, point.vertex));
        return squared(apart.x, apart.y, apart.z) < 0.99f * (point.margin * point.margin);
      };
      if (point.near_count == 0 && std::all_of(corners.begin(), corners.end(), is_near)) continue;
      if (!has_planes) planes = planes_of(places);
      has_planes = true;
      float distance = distance_to(around, x);
      for (std::size_t f = 0; f < planes.count; ++f)
        distance =
            std::max(distance, kernel::inner_product<float>(planes.plane[f].normal, x) - planes.plane[f].at);
      // What is no number is no distance.
      distance = distance < infinity ? distance - rounding : 0.0f;
      if (distance >= pair.others) continue;
      of_point[k].push_back({t - first, distance});
    }
  }
  for (std::uint32_t k = 0; k < block_size; ++k) {
    std::sort(of_point[k].begin(), of_point[k].end(),
              [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
    if (!of_point[k].empty()) pair.nearest = std::min(pair.nearest, of_point[k].front().distance);
    pair.candidates.insert(pair.candidates.end(), of_point[k].begin(), of_point[k].end());
    pair.first[k + 1] = static_cast<std::uint16_t>(pair.candidates.size());
  }
  return pair;
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
    put_place(sum, is_first ? term : kernel::vector_sum<float>(place_at(sum), term));
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
      add(corners_of(model_, t)[k], kernel::scaled_vector<float>(-weights_of(p)[k], impulse_of(p)));
  for (const std::uint32_t i : touched_) {
    float* sum = fields.pressed.data() + vector_stride * std::size_t{i};
    sum[3] = 0.0f;
    put_place(sum, kernel::contact_acceleration<float>(place_at(sum), model_.mobility[i], in.step.inverse_h));
  }
}

}  // namespace fascicle::cpu_reference
