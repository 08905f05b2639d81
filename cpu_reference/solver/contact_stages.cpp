#include "cpu_reference/solver/contact_stages.h"

#include <algorithm>
#include <vector>

#include "cpu_reference/solver/contact_meets.h"

namespace fascicle::cpu_reference {

namespace {

using model::Model;

bool box_holds(const ContactBox& box, const Place& x) {
  return x.x >= box.low.x && x.x <= box.high.x && x.y >= box.low.y && x.y <= box.high.y && x.z >= box.low.z &&
         x.z <= box.high.z;
}

bool is_found(const Model& model, const Fields& fields, std::uint32_t p) {
  return fields.contact_found[p] < model.contact_tetrahedron_count();
}

// The blocks of points that may have found tetrahedron t.
Range blocks_of(const Model& model, const Fields& fields, std::uint32_t t) {
  const std::uint32_t* blocks = fields.contact_blocks.data() + 2 * std::size_t{t / shader::contact_leaf};
  // Without a find the first block is the number of blocks, and the range empty.
  return {blocks[0], std::min(blocks[1], model.contact_block_count())};
}

// A block's points, if one of them may have found tetrahedron t.
Range points_of(const Model& model, const Fields& fields, std::uint32_t block, std::uint32_t t) {
  const std::uint32_t* range = fields.contact_range.data() + 2 * std::size_t{block};
  if (t < range[0] || t > range[1]) return {0, 0};
  return {block * shader::contact_block,
          std::min((block + 1) * shader::contact_block, static_cast<std::uint32_t>(model.contact.size()))};
}

// Calls use(point, weight) for each contact of a tetrahedron at vertex i.
template <class Use>
void for_each_contact_at(const Model& model, const Fields& fields, std::uint32_t i, const Use& use) {
  for (std::uint32_t e = model.contact_offset[i]; e < model.contact_offset[i + 1]; ++e) {
    const std::uint32_t t = model.contact_entry[e] / 4, corner = model.contact_entry[e] % 4;
    const Range blocks = blocks_of(model, fields, t);
    for (std::uint32_t block = blocks.first; block < blocks.last; ++block) {
      const Range points = points_of(model, fields, block, t);
      for (std::uint32_t p = points.first; p < points.last; ++p)
        if (fields.contact_found[p] == t) use(p, fields.contact_place[contact_place_stride * p + corner]);
    }
  }
}

}  // namespace

void contact_bound(const Model& model, const SubstepInput&, Fields& fields, Range range) {
  const auto place_of = [&](std::uint32_t i) { return position_of(fields, i); };
  for (std::uint32_t leaf = range.first; leaf < range.last; ++leaf)
    put_contact_box(fields.contact_box, leaf, contact_leaf_box(model, leaf, place_of));
}

void contact_enclose(const Model& model, const SubstepInput&, Fields& fields, Range range) {
  for (std::uint32_t branch = range.first; branch < range.last; ++branch)
    put_contact_box(fields.contact_branch_box, branch, contact_branch_box(model, branch, fields.contact_box));
}

namespace {

std::uint32_t found_in_leaf(const Model& model, Fields& fields, std::uint32_t p, const Place& x,
                            std::uint32_t leaf) {
  const std::uint32_t first = leaf * shader::contact_leaf,
                      end = std::min(first + shader::contact_leaf, model.contact_tetrahedron_count());
  const auto place_of = [&](std::uint32_t i) { return position_of(fields, i); };
  for (std::uint32_t t = first; t < end; ++t)
    if (contact_meets(model, fields, p, x, t, place_of)) return t;
  return shader::no_contact;
}

std::uint32_t found_by(const Model& model, Fields& fields, std::uint32_t p) {
  const Place x = position_of(fields, model.contact[p].vertex);
  const std::uint32_t leaves = model.contact_leaf_count();
  for (std::uint32_t branch = 0; branch < model.contact_branch_count(); ++branch) {
    if (!box_holds(contact_box_at(fields.contact_branch_box, branch), x) ||
        contact_is_near_at_rest(model, p, leaves + branch))
      continue;
    const std::uint32_t end = std::min((branch + 1) * shader::contact_branch, leaves);
    for (std::uint32_t leaf = branch * shader::contact_branch; leaf < end; ++leaf) {
      if (!box_holds(contact_box_at(fields.contact_box, leaf), x) || contact_is_near_at_rest(model, p, leaf))
        continue;
      const std::uint32_t found = found_in_leaf(model, fields, p, x, leaf);
      if (found != shader::no_contact) return found;
    }
  }
  return shader::no_contact;
}

}  // namespace

void contact_find(const Model& model, const SubstepInput&, Fields& fields, Range range) {
  for (std::uint32_t p = range.first; p < range.last; ++p)
    fields.contact_found[p] = found_by(model, fields, p);
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
    bool is_first = own == shader::no_contact || !is_found(model, fields, own);
    if (!is_first) sum = 1.0f;
    for_each_contact_at(model, fields, i, [&](std::uint32_t, float weight) {
      sum = is_first ? weight : sum + weight;
      is_first = false;
    });
    fields.contact_crowd[i] = sum;
  }
}

void contact_press(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  const auto load = [&](std::uint32_t i) {
    return kernel::contact_load<float>(model.mobility[i], fields.contact_crowd[i]);
  };
  for (std::uint32_t p = range.first; p < range.last; ++p) {
    Place impulse{0.0f, 0.0f, 0.0f};
    if (is_found(model, fields, p)) {
      const shader::ContactPoint& point = model.contact[p];
      const auto corner = corners_of(model, fields.contact_found[p]);
      const float* place = fields.contact_place.data() + contact_place_stride * p;
      const kernel::ContactWeights<float> weights{place[0], place[1], place[2], place[3]};
      const Place velocity = kernel::contact_velocity<float>(
          weights, velocity_of(fields, point.vertex), velocity_of(fields, corner[0]),
          velocity_of(fields, corner[1]), velocity_of(fields, corner[2]), velocity_of(fields, corner[3]));
      const float all =
          load(point.vertex) + kernel::contact_mean<float>(weights, load(corner[0]), load(corner[1]),
                                                           load(corner[2]), load(corner[3]));
      impulse = kernel::contact_impulse<float>({place_at(place + 4), place_at(place + 7)}, velocity,
                                               in.step.inverse_h, point.friction, all);
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
      const Place term = kernel::scaled_vector<float>(-weight, impulse_of(p));
      sum = is_first ? term : kernel::vector_sum<float>(sum, term);
      is_first = false;
    });
    if (!is_first) contact_apply(model, in, fields, i, sum);
  }
}

}  // namespace fascicle::cpu_reference
