#include "cpu_reference/solver/contact_stages.h"

#include <algorithm>
#include <span>
#include <utility>
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

// The lowest point from `from` on that has found tetrahedron t; no_contact if there is none.
std::uint32_t point_from(const Model& model, const Fields& fields, std::uint32_t t, std::uint32_t from) {
  std::uint32_t lowest = shader::no_contact;
  for (std::uint32_t p = fields.contact_first[t]; p < model.contact.size(); p = fields.contact_next[p])
    if (p >= from) lowest = std::min(lowest, p);
  return lowest;
}

// Calls use(point, weight) for each contact of a tetrahedron at vertex i.
template <class Use>
void for_each_contact_at(const Model& model, const Fields& fields, std::uint32_t i, const Use& use) {
  for (std::uint32_t e = model.contact_offset[i]; e < model.contact_offset[i + 1]; ++e) {
    const std::uint32_t t = model.contact_entry[e] / 4, corner = model.contact_entry[e] % 4;
    for (std::uint32_t p = point_from(model, fields, t, 0); p != shader::no_contact;
         p = point_from(model, fields, t, p + 1))
      use(p, fields.contact_place[contact_place_stride * p + corner]);
  }
}

}  // namespace

void contact_bound(const Model& model, const SubstepInput&, Fields& fields, Range range) {
  const auto place_of = [&](std::uint32_t i) { return position_of(fields, i); };
  for (std::uint32_t leaf = range.first; leaf < range.last; ++leaf) {
    put_contact_box(fields.contact_box, leaf, contact_leaf_box(model, leaf, place_of));
    const std::uint32_t first = leaf * shader::contact_leaf,
                        end = std::min(first + shader::contact_leaf, model.contact_tetrahedron_count());
    std::fill(fields.contact_first.begin() + first, fields.contact_first.begin() + end, shader::no_contact);
  }
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

void contact_chain(const Model& model, const SubstepInput&, Fields& fields, Range range) {
  for (std::uint32_t p = range.first; p < range.last; ++p)
    if (is_found(model, fields, p))
      fields.contact_next[p] = std::exchange(fields.contact_first[fields.contact_found[p]], p);
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

namespace {

// A found contact.
struct Pair {
  std::uint32_t point_vertex;
  std::span<const std::uint32_t, 4> corner;
  kernel::ContactWeights<float> weights;
  Place push, normal;
};
Pair pair_of(const Model& model, const Fields& fields, std::uint32_t p) {
  const float* place = fields.contact_place.data() + contact_place_stride * p;
  return {model.contact[p].vertex,
          corners_of(model, fields.contact_found[p]),
          {place[0], place[1], place[2], place[3]},
          place_at(place + 4),
          place_at(place + 7)};
}

// The point's value relative to its place in the tetrahedron; vector_of(i) is vertex i's value.
template <class VectorOf>
Place between(const Pair& pair, const VectorOf& vector_of) {
  return kernel::contact_velocity<float>(pair.weights, vector_of(pair.point_vertex),
                                         vector_of(pair.corner[0]), vector_of(pair.corner[1]),
                                         vector_of(pair.corner[2]), vector_of(pair.corner[3]));
}

template <class LoadOf>
float load_of_all(const Pair& pair, const LoadOf& load) {
  return load(pair.point_vertex) + kernel::contact_mean<float>(pair.weights, load(pair.corner[0]),
                                                               load(pair.corner[1]), load(pair.corner[2]),
                                                               load(pair.corner[3]));
}

void put_impulse(Fields& fields, std::uint32_t p, const Place& impulse) {
  put_place(fields.contact_impulse.data() + 3 * std::size_t{p}, impulse);
}

Place impulse_of(const Fields& fields, std::uint32_t p) {
  return place_at(fields.contact_impulse.data() + 3 * std::size_t{p});
}

}  // namespace

void contact_press(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  const auto load = [&](std::uint32_t i) {
    return kernel::contact_load<float>(model.mobility[i], fields.contact_crowd[i]);
  };
  for (std::uint32_t p = range.first; p < range.last; ++p) {
    Place impulse{0.0f, 0.0f, 0.0f};
    if (is_found(model, fields, p)) {
      const Pair pair = pair_of(model, fields, p);
      const Place velocity = between(pair, [&](std::uint32_t i) { return velocity_of(fields, i); });
      impulse = kernel::contact_impulse<float>({pair.push, pair.normal}, velocity, in.step.inverse_h,
                                               model.contact[p].friction, load_of_all(pair, load));
    }
    put_impulse(fields, p, impulse);
  }
}

void contact_hold(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  const auto part = [&](std::uint32_t i) {
    return kernel::contact_part<float>(
        kernel::contact_yielding<float>(model.mobility[i], in.responses[i].to_inertia),
        fields.contact_crowd[i]);
  };
  const auto way = [&](std::uint32_t i) {
    return kernel::subtract<float>(position_of(fields, i),
                                   place_at(fields.positions_before.data() + vector_stride * std::size_t{i}));
  };
  for (std::uint32_t p = range.first; p < range.last; ++p) {
    Place impulse{0.0f, 0.0f, 0.0f};
    if (is_found(model, fields, p)) {
      const Pair pair = pair_of(model, fields, p);
      const shader::ContactPoint& point = model.contact[p];
      impulse =
          kernel::contact_hold_impulse<float>({pair.push, pair.normal}, between(pair, way), in.implicit.step,
                                              point.margin, point.friction, load_of_all(pair, part));
    }
    put_impulse(fields, p, impulse);
  }
}

void contact_settle(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  const auto part = [&](std::uint32_t i) { return model.mobility[i] * fields.contact_crowd[i]; };
  const auto velocity_before = [&](std::uint32_t i) {
    return place_at(fields.velocities_before.data() + vector_stride * std::size_t{i});
  };
  for (std::uint32_t p = range.first; p < range.last; ++p) {
    if (!is_found(model, fields, p)) continue;
    const Pair pair = pair_of(model, fields, p);
    const Place velocity = between(pair, [&](std::uint32_t i) { return velocity_of(fields, i); });
    const float load = kernel::contact_settled_load<float>(
        load_of_all(pair, part), pair.weights, model.mobility[pair.corner[0]], model.mobility[pair.corner[1]],
        model.mobility[pair.corner[2]], model.mobility[pair.corner[3]]);
    put_impulse(fields, p,
                kernel::contact_settling<float>(impulse_of(fields, p), pair.normal, velocity,
                                                between(pair, velocity_before), in.implicit.settled, load));
  }
}

namespace {

// Calls apply(model, in, fields, i, sum) for each vertex of the range that takes part in a contact.
template <class Apply>
void apply_sums(const Model& model, const SubstepInput& in, Fields& fields, Range range, const Apply& apply) {
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    Place sum{0.0f, 0.0f, 0.0f};
    bool is_first = true;
    const std::uint32_t own = model.contact_number[i];
    if (own != shader::no_contact && is_found(model, fields, own)) {
      sum = impulse_of(fields, own);
      is_first = false;
    }
    for_each_contact_at(model, fields, i, [&](std::uint32_t p, float weight) {
      const Place term = kernel::scaled_vector<float>(-weight, impulse_of(fields, p));
      sum = is_first ? term : kernel::vector_sum<float>(sum, term);
      is_first = false;
    });
    if (!is_first) apply(model, in, fields, i, sum);
  }
}

}  // namespace

void contact(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  apply_sums(model, in, fields, range, contact_apply);
}

void contact_yield(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  apply_sums(model, in, fields, range, contact_apply_yield);
}

void contact_rest(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  apply_sums(model, in, fields, range, contact_apply_rest);
}

}  // namespace fascicle::cpu_reference
