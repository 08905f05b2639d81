#include "cpu_reference/contact_stages.h"

#include <algorithm>
#include <array>
#include <span>

#include "shaders/kernel/contact.inc"

namespace fascicle::cpu_reference {

namespace {

using Place = kernel::Vector<float>;
using model::Model;

Place place_at(const float* from) {
  return {from[0], from[1], from[2]};
}

float* put_place(float* to, const Place& v) {
  for (const float part : {v.x, v.y, v.z}) *to++ = part;
  return to;
}

Place velocity_of(const Fields& fields, std::uint32_t i) {
  return place_at(fields.velocities.data() + vector_stride * std::size_t{i});
}

Place sight(const Model& model, const SubstepInput& in, const Fields& fields, std::uint32_t i) {
  const Place x = place_at(fields.vertices.data() + vertex_stride * std::size_t{i});
  return model.is_implicit() ? kernel::contact_ahead<float>(x, velocity_of(fields, i), in.step.h) : x;
}

Place rest_place(const Model& model, std::uint32_t i) {
  return place_at(model.rest.data() + 3 * std::size_t{i});
}

struct Box {
  Place low, high;
};

void grow(Box& box, const Box& other) {
  const auto lower = [](float& a, float b) { a = b < a ? b : a; };
  const auto higher = [](float& a, float b) { a = b > a ? b : a; };
  lower(box.low.x, other.low.x);
  lower(box.low.y, other.low.y);
  lower(box.low.z, other.low.z);
  higher(box.high.x, other.high.x);
  higher(box.high.y, other.high.y);
  higher(box.high.z, other.high.z);
}

Box box_at(const std::vector<float>& boxes, std::uint32_t number) {
  const float* from = boxes.data() + 6 * std::size_t{number};
  return {place_at(from), place_at(from + 3)};
}

void put_box(std::vector<float>& boxes, std::uint32_t number, const Box& box) {
  put_place(put_place(boxes.data() + 6 * std::size_t{number}, box.low), box.high);
}

bool box_holds(const Box& box, const ContactSight& x) {
  return x.x >= box.low.x && x.x <= box.high.x && x.y >= box.low.y && x.y <= box.high.y && x.z >= box.low.z &&
         x.z <= box.high.z;
}

std::span<const std::uint32_t, 4> corners_of(const Model& model, std::uint32_t t) {
  return std::span<const std::uint32_t, 4>(model.contact_tetrahedron.data() + 4 * std::size_t{t}, 4);
}

bool is_found(const Model& model, const Fields& fields, std::uint32_t p) {
  return fields.contact_found[p] < model.contact_tetrahedron_count();
}

// The points that may have found tetrahedron t.
Range points_of(const Model& model, const Fields& fields, std::uint32_t t) {
  const std::uint32_t* blocks = fields.contact_blocks.data() + 2 * std::size_t{t / shader::contact_leaf};
  const auto count = static_cast<std::uint32_t>(model.contact.size());
  // Without a find the first block is the number of blocks, and the range empty.
  return {std::min(blocks[0], model.contact_block_count()) * shader::contact_block,
          std::min(std::min(blocks[1], model.contact_block_count()) * shader::contact_block, count)};
}

// Calls use(point, weight) for each contact of a tetrahedron at vertex i.
template <class Use>
void for_each_contact_at(const Model& model, const Fields& fields, std::uint32_t i, const Use& use) {
  for (std::uint32_t e = model.contact_offset[i]; e < model.contact_offset[i + 1]; ++e) {
    const std::uint32_t t = model.contact_entry[e] / 4, corner = model.contact_entry[e] % 4;
    const Range points = points_of(model, fields, t);
    for (std::uint32_t p = points.first; p < points.last; ++p)
      if (fields.contact_found[p] == t) use(p, fields.contact_place[10 * std::size_t{p} + corner]);
  }
}

bool is_across_a_gap(const Model& model, const shader::ContactPoint& point, std::uint32_t vertex) {
  const auto first = model.contact_near.begin() + point.first_near;
  return std::binary_search(first, first + point.near_count, vertex);
}

}  // namespace

ContactSight contact_sight(const Model& model, const SubstepInput& in, const Fields& fields,
                           std::uint32_t i) {
  const Place x = sight(model, in, fields, i);
  return {x.x, x.y, x.z};
}

bool contact_is_near_at_rest(const Model& model, std::uint32_t p, std::uint32_t box) {
  const shader::ContactPoint& point = model.contact[p];
  if (point.near_count > 0) return false;
  const float* from = model.contact_rest_box.data() + 8 * std::size_t{box};
  return kernel::contact_is_near<float>(rest_place(model, point.vertex), place_at(from), place_at(from + 4),
                                        point.margin);
}

bool contact_meets(const Model& model, const SubstepInput& in, Fields& fields, std::uint32_t p,
                   const ContactSight& x, std::uint32_t t) {
  const shader::ContactPoint& point = model.contact[p];
  const auto [a, b, c, d] = std::array{corners_of(model, t)[0], corners_of(model, t)[1],
                                       corners_of(model, t)[2], corners_of(model, t)[3]};
  const auto volumes = kernel::contact_volumes<float>(
      {x.x, x.y, x.z}, sight(model, in, fields, a), sight(model, in, fields, b), sight(model, in, fields, c),
      sight(model, in, fields, d));
  if (!kernel::contact_is_inside<float>(volumes)) return false;
  const std::array<std::uint32_t, 5> all{point.vertex, a, b, c, d};
  if (std::none_of(all.begin(), all.end(), [&](std::uint32_t i) { return model.mobility[i] > 0.0f; }))
    return false;
  const auto weights = kernel::contact_weights<float>(volumes);
  const Place apart =
      kernel::contact_apart<float>(weights, rest_place(model, point.vertex), rest_place(model, a),
                                   rest_place(model, b), rest_place(model, c), rest_place(model, d));
  const float squared = kernel::contact_along<float>(apart, apart);
  const bool is_far = squared > point.margin * point.margin;
  if (!is_far && !std::all_of(all.begin() + 1, all.end(),
                              [&](std::uint32_t i) { return is_across_a_gap(model, point, i); }))
    return false;
  const std::vector<float>& depths = model.contact_depth;
  const float depth = kernel::contact_mean<float>(weights, depths[a], depths[b], depths[c], depths[d]);
  const float pushed =
      is_far ? kernel::contact_depth_beyond<float>(depth, squared, point.margin) : depth - point.allowance;
  const auto push = kernel::contact_push<float>(volumes, pushed, depths[a], depths[b], depths[c], depths[d]);
  float* to = fields.contact_place.data() + 10 * std::size_t{p};
  for (const float weight : {weights.a, weights.b, weights.c, weights.d}) *to++ = weight;
  put_place(put_place(to, push.push), push.normal);
  return true;
}

void contact_bound(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  for (std::uint32_t leaf = range.first; leaf < range.last; ++leaf) {
    const std::uint32_t first = leaf * shader::contact_leaf,
                        end = std::min(first + shader::contact_leaf, model.contact_tetrahedron_count());
    const Place x = sight(model, in, fields, corners_of(model, first)[0]);
    Box box{x, x};
    for (std::uint32_t t = first; t < end; ++t)
      for (const std::uint32_t i : corners_of(model, t)) {
        const Place corner = sight(model, in, fields, i);
        grow(box, {corner, corner});
      }
    put_box(fields.contact_box, leaf, box);
  }
}

void contact_enclose(const Model& model, const SubstepInput&, Fields& fields, Range range) {
  for (std::uint32_t branch = range.first; branch < range.last; ++branch) {
    const std::uint32_t first = branch * shader::contact_branch,
                        end = std::min(first + shader::contact_branch, model.contact_leaf_count());
    Box box = box_at(fields.contact_box, first);
    for (std::uint32_t leaf = first + 1; leaf < end; ++leaf) grow(box, box_at(fields.contact_box, leaf));
    put_box(fields.contact_branch_box, branch, box);
  }
}

namespace {

std::uint32_t found_in_leaf(const Model& model, const SubstepInput& in, Fields& fields, std::uint32_t p,
                            const ContactSight& x, std::uint32_t leaf) {
  const std::uint32_t first = leaf * shader::contact_leaf,
                      end = std::min(first + shader::contact_leaf, model.contact_tetrahedron_count());
  for (std::uint32_t t = first; t < end; ++t)
    if (contact_meets(model, in, fields, p, x, t)) return t;
  return shader::no_contact;
}

std::uint32_t found_by(const Model& model, const SubstepInput& in, Fields& fields, std::uint32_t p) {
  const ContactSight x = contact_sight(model, in, fields, model.contact[p].vertex);
  const std::uint32_t leaves = model.contact_leaf_count();
  for (std::uint32_t branch = 0; branch < model.contact_branch_count(); ++branch) {
    if (!box_holds(box_at(fields.contact_branch_box, branch), x) ||
        contact_is_near_at_rest(model, p, leaves + branch))
      continue;
    const std::uint32_t end = std::min((branch + 1) * shader::contact_branch, leaves);
    for (std::uint32_t leaf = branch * shader::contact_branch; leaf < end; ++leaf) {
      if (!box_holds(box_at(fields.contact_box, leaf), x) || contact_is_near_at_rest(model, p, leaf))
        continue;
      const std::uint32_t found = found_in_leaf(model, in, fields, p, x, leaf);
      if (found != shader::no_contact) return found;
    }
  }
  return shader::no_contact;
}

}  // namespace

void contact_find(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  for (std::uint32_t p = range.first; p < range.last; ++p)
    fields.contact_found[p] = found_by(model, in, fields, p);
}

void contact_survey(const Model& model, const SubstepInput&, Fields& fields, Range range) {
  const auto count = static_cast<std::uint32_t>(model.contact.size());
  for (std::uint32_t block = range.first; block < range.last; ++block) {
    std::uint32_t lowest = shader::no_contact, highest = 0;
    const std::uint32_t end = std::min((block + 1) * shader::contact_block, count);
    for (std::uint32_t p = block * shader::contact_block; p < end; ++p) {
      if (!is_found(model, fields, p)) continue;
      lowest = std::min(lowest, fields.contact_found[p]);
      highest = std::max(highest, fields.contact_found[p]);
    }
    fields.contact_range[2 * std::size_t{block}] = lowest;
    fields.contact_range[2 * std::size_t{block} + 1] = highest;
  }
}

void contact_locate(const Model& model, const SubstepInput&, Fields& fields, Range range) {
  const std::uint32_t blocks = model.contact_block_count();
  for (std::uint32_t leaf = range.first; leaf < range.last; ++leaf) {
    const std::uint32_t first = leaf * shader::contact_leaf;
    std::uint32_t from = blocks, to = 0;
    for (std::uint32_t block = 0; block < blocks; ++block) {
      const std::uint32_t* found = fields.contact_range.data() + 2 * std::size_t{block};
      if (found[0] >= first + shader::contact_leaf || found[1] < first) continue;
      if (from == blocks) from = block;
      to = block + 1;
    }
    fields.contact_blocks[2 * std::size_t{leaf}] = from;
    fields.contact_blocks[2 * std::size_t{leaf} + 1] = to;
  }
}

void contact_crowd(const Model& model, const SubstepInput&, Fields& fields, Range range) {
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    float sum = 0.0f;
    const std::uint32_t own = model.contact_number[i];
    if (own != shader::no_contact && is_found(model, fields, own)) sum = 1.0f;
    for_each_contact_at(model, fields, i, [&](std::uint32_t, float weight) { sum += weight; });
    fields.contact_crowd[i] = sum;
  }
}

void contact_press(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  const auto load = [&](std::uint32_t i) {
    return kernel::contact_load<float>(model.mobility[i], fields.contact_crowd[i]);
  };
  const float strength = model.is_implicit() ? shader::contact_strength_implicit : shader::contact_strength;
  for (std::uint32_t p = range.first; p < range.last; ++p) {
    Place impulse{0.0f, 0.0f, 0.0f};
    if (is_found(model, fields, p)) {
      const shader::ContactPoint& point = model.contact[p];
      const auto corner = corners_of(model, fields.contact_found[p]);
      const float* place = fields.contact_place.data() + 10 * std::size_t{p};
      const kernel::ContactWeights<float> weights{place[0], place[1], place[2], place[3]};
      const Place of_flesh = kernel::contact_apart<float>(
          weights, {0.0f, 0.0f, 0.0f}, velocity_of(fields, corner[0]), velocity_of(fields, corner[1]),
          velocity_of(fields, corner[2]), velocity_of(fields, corner[3]));
      const Place velocity = kernel::subtract<float>(velocity_of(fields, point.vertex), of_flesh);
      const float all =
          load(point.vertex) + kernel::contact_mean<float>(weights, load(corner[0]), load(corner[1]),
                                                           load(corner[2]), load(corner[3]));
      impulse = kernel::contact_impulse<float>({place_at(place + 4), place_at(place + 7)}, velocity,
                                               strength * in.step.inverse_h, point.friction, all);
    }
    put_place(fields.contact_impulse.data() + 3 * std::size_t{p}, impulse);
  }
}

void contact(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    Place sum{0.0f, 0.0f, 0.0f};
    bool is_first = true;
    const auto impulse_of = [&](std::uint32_t p) {
      return place_at(fields.contact_impulse.data() + 3 * std::size_t{p});
    };
    const std::uint32_t own = model.contact_number[i];
    if (own != shader::no_contact && is_found(model, fields, own)) {
      sum = impulse_of(own);
      is_first = false;
    }
    for_each_contact_at(model, fields, i, [&](std::uint32_t p, float weight) {
      const Place term = kernel::contact_term<float>(-weight, impulse_of(p));
      sum = is_first ? term : kernel::contact_add<float>(sum, term);
      is_first = false;
    });
    put_place(fields.pressed.data() + vector_stride * std::size_t{i},
              kernel::contact_acceleration<float>(sum, model.mobility[i], in.step.inverse_h));
  }
}

}  // namespace fascicle::cpu_reference
