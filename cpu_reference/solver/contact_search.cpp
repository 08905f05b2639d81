#include "cpu_reference/solver/contact_search.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "cpu_reference/solver/contact_stages.h"
#include "host/model/contact_near.h"
#include "host/model/contact_order.h"

namespace fascicle::cpu_reference {

namespace {

static_assert(shader::contact_leaf == contact_boxes_together &&
              shader::contact_branch == contact_boxes_together);

constexpr std::size_t sight_stride = 4;

// Writes one of the boxes processed together.
void put_box(float* boxes, std::uint32_t number, const float* low, const float* high) {
  for (std::size_t a = 0; a < 3; ++a) {
    boxes[a * contact_boxes_together + number] = low[a];
    boxes[(a + 3) * contact_boxes_together + number] = high[a];
  }
}

LineVector<float> empty_boxes(std::uint32_t groups) {
  LineVector<float> boxes(std::size_t{groups} * contact_boxes_stride);
  for (std::size_t k = 0; k < boxes.size(); ++k)
    boxes[k] = (k % contact_boxes_stride < contact_boxes_stride / 2 ? 1.0f : -1.0f) *
               std::numeric_limits<float>::infinity();
  return boxes;
}

// Calls use(k) for all of `count`. Small counts are not worth waking threads.
template <class Use>
void run_over(std::size_t count, ThreadPool& pool, const Use& use) {
  constexpr std::size_t few = 128;
  const auto run = [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t k = first; k < last; ++k) use(k);
  };
  if (count < few)
    run(0, static_cast<std::uint32_t>(count));
  else
    pool.run(static_cast<std::uint32_t>(count), run);
}

// Calls use(index) for each bit that is set, ascending.
template <class Use>
void for_each_bit(std::uint32_t bits, const Use& use) {
  for (; bits != 0; bits &= bits - 1) use(static_cast<std::uint32_t>(std::countr_zero(bits)));
}

}  // namespace

struct ContactSearch::Sight {
  std::uint32_t block;
  ContactBounds bounds;
  PointBits open;  // points without a contact so far
  // As in ContactLook.
  alignas(64) std::array<float, 3 * block_size> points;
};

ContactSearch::ContactSearch(const model::Model& model, const ContactLanes& lanes,
                             std::shared_ptr<const ContactRest> rest)
    : model_(model), lanes_(lanes), rest_(std::move(rest)) {
  sights_.resize(sight_stride * model.vertex_count);
  place_.assign(model.vertex_count, nothing);
  // Without previous positions, everything may have moved anywhere.
  sights_before_.assign(sights_.size(), std::numeric_limits<float>::quiet_NaN());
  leaf_box_ = leaf_motion_ = empty_boxes(model.contact_branch_count());
  branch_box_ = empty_boxes(model::parts_of(model.contact_branch_count(), contact_boxes_together));
  blocks_.resize(rest_->blocks.size());
  for (std::size_t b = 0; b < blocks_.size(); ++b) blocks_[b].rest = &rest_->blocks[b];
}

std::uint32_t ContactSearch::block_end(std::size_t block) const {
  return std::min(block_begin(block) + block_size, static_cast<std::uint32_t>(rest_->order.size()));
}

std::uint32_t ContactSearch::leaf_end(std::uint32_t leaf) const {
  return std::min((leaf + 1) * leaf_size, model_.contact_tetrahedron_count());
}

void ContactSearch::find(Fields& fields, ThreadPool& pool) {
  try {
    look(fields, pool);
    pool.run(static_cast<std::uint32_t>(blocks_.size()), [&](std::uint32_t first, std::uint32_t last) {
      for (std::uint32_t block = first; block < last; ++block) find_in_block(block, fields);
    });
    crowd(fields);
  } catch (...) {
    forget();
    throw;
  }
}

void ContactSearch::forget() {
  for (Block& block : blocks_)
    block = Block{.rest = block.rest, .branches = {}, .pairs = {}, .relevant = {}, .unused = {}};
  touched_.clear();
  std::fill(place_.begin(), place_.end(), nothing);
}

// Updates all positions, and the leaves' boxes and motions.
void ContactSearch::look(const Fields& fields, ThreadPool& pool) {
  std::swap(sights_, sights_before_);
  pool.run(model_.vertex_count, [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t i = first; i < last; ++i)
      put_place(sights_.data() + sight_stride * i, position_of(fields, i));
  });
  pool.run(model_.contact_branch_count(), [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t branch = first; branch < last; ++branch) bound_branch(branch);
  });
}

ContactBounds ContactSearch::bounds_of(const std::uint32_t* vertices, std::uint32_t count) const {
  ContactBounds bounds;
  lanes_.bound({.now = sights_.data(), .before = sights_before_.data(), .vertex = vertices, .count = count},
               bounds);
  return bounds;
}

void ContactSearch::bound_branch(std::uint32_t branch) {
  const std::uint32_t begin = branch * shader::contact_branch,
                      end = std::min(begin + shader::contact_branch, model_.contact_leaf_count());
  float* boxes = leaf_box_.data() + std::size_t{branch} * contact_boxes_stride;
  float* motions = leaf_motion_.data() + std::size_t{branch} * contact_boxes_stride;
  ContactBox all = empty_contact_box;
  for (std::uint32_t leaf = begin; leaf < end; ++leaf) {
    const ContactBounds bounds = bounds_of(rest_->leaf_vertex.data() + rest_->leaf_offset[leaf],
                                           rest_->leaf_offset[leaf + 1] - rest_->leaf_offset[leaf]);
    put_box(boxes, leaf - begin, bounds.low, bounds.high);
    put_box(motions, leaf - begin, bounds.least, bounds.most);
    grow(all, {place_at(bounds.low), place_at(bounds.high)});
  }
  const std::array<float, 6> box{all.low.x, all.low.y, all.low.z, all.high.x, all.high.y, all.high.z};
  put_box(branch_box_.data() + std::size_t{branch / contact_boxes_together} * contact_boxes_stride,
          branch % contact_boxes_together, box.data(), box.data() + 3);
}

// Leaves are visited in ascending order, so a point's first find is the one with the lowest number.
void ContactSearch::find_in_block(std::uint32_t number, Fields& fields) {
  Block& block = blocks_[number];
  const std::uint32_t begin = block_begin(number), end = block_end(number);
  Sight sight{.block = number,
              .bounds = bounds_of(rest_->order_vertex.data() + begin, end - begin),
              .open = block.rest->points,
              .points = {}};
  sight.points.fill(std::numeric_limits<float>::infinity());
  for (std::uint32_t k = begin; k < end; ++k) {
    for (std::size_t a = 0; a < 3; ++a)
      sight.points[a * block_size + (k - begin)] = sights_[sight_stride * rest_->order_vertex[k] + a];
    fields.contact_found[rest_->order[k]] = shader::no_contact;
  }
  std::size_t at = 0;
  for (std::uint32_t first = 0; first < model_.contact_branch_count(); first += contact_boxes_together) {
    const float* boxes =
        branch_box_.data() + std::size_t{first} * (contact_boxes_stride / contact_boxes_together);
    for_each_bit(lanes_.overlap(boxes, sight.bounds), [&](std::uint32_t bit) {
      while (at < block.branches.size() && block.branches[at].number < first + bit) drop(block, at);
      if (at == block.branches.size() || block.branches[at].number != first + bit) {
        Branch made{.number = first + bit};
        made.pair.fill(nothing);
        block.branches.insert(block.branches.begin() + static_cast<std::ptrdiff_t>(at), made);
      }
      find_in_branch(block.branches[at++], sight, fields);
    });
  }
  while (at < block.branches.size()) drop(block, at);
}

// Distances are not updated while the boxes do not overlap, so they are dropped.
void ContactSearch::drop(Block& block, std::size_t branch) {
  const auto place = block.branches.begin() + static_cast<std::ptrdiff_t>(branch);
  for (const std::uint32_t pair : place->pair)
    if (pair != nothing) block.unused.push_back(pair);
  block.branches.erase(place);
}

void ContactSearch::find_in_branch(Branch& branch, Sight& sight, Fields& fields) {
  const std::size_t at = std::size_t{branch.number} * contact_boxes_stride;
  const LeafBits leaves = lanes_.approach({.boxes = leaf_box_.data() + at,
                                           .motions = leaf_motion_.data() + at,
                                           .points = &sight.bounds,
                                           .nearest = branch.nearest.data(),
                                           .gone = branch.gone.data()});
  // A body has several megabytes of these: prefetch them all before the first is needed.
  const Block& block = blocks_[sight.block];
  for_each_bit(leaves, [&](std::uint32_t leaf) {
    if (branch.pair[leaf] == nothing) return;
    __builtin_prefetch(&block.pairs[branch.pair[leaf]]);
    __builtin_prefetch(block.relevant[branch.pair[leaf]]);
  });
  for_each_bit(leaves, [&](std::uint32_t leaf) {
    if (sight.open != 0) find_in_leaf(branch, leaf, sight, fields);
  });
}

void ContactSearch::find_in_leaf(Branch& branch, std::uint32_t number, Sight& sight, Fields& fields) {
  Block& block = blocks_[sight.block];
  const std::uint32_t leaf = branch.number * shader::contact_branch + number, begin = leaf * leaf_size;
  if (is_ignored(block, leaf)) {
    branch.nearest[number] = std::numeric_limits<float>::infinity();
    branch.gone[number] = 0.0f;
    return;
  }
  if (branch.pair[number] == nothing) branch.pair[number] = make_pair(block, leaf);
  const std::uint32_t place = branch.pair[number];
  ContactLook look{.points = sight.points.data(),
                   .places = sights_.data(),
                   .corners = model_.contact_tetrahedron.data() + std::size_t{4} * begin,
                   .relevant = block.relevant[place],
                   .all = rest_->leaf_is_held[leaf] != 0 ? block.rest->mobile : block.rest->points,
                   .tetrahedra = ~LeafBits{0} >> (leaf_size - (leaf_end(leaf) - begin)),
                   .gone = branch.gone[number],
                   .apart = block.pairs[place].apart.data(),
                   .nearest = 0.0f,
                   .hits = 0,
                   .inside = {}};
  lanes_.look(look);
  branch.nearest[number] = look.nearest;
  branch.gone[number] = 0.0f;
  const auto place_of = [&](std::uint32_t i) { return place_at(sights_.data() + sight_stride * i); };
  for_each_bit(look.hits, [&](std::uint32_t t) {
    for_each_bit(look.inside[t] & sight.open, [&](std::uint32_t bit) {
      const std::uint32_t p = rest_->order[block_begin(sight.block) + bit];
      if (!contact_meets(model_, fields, p, place_of(model_.contact[p].vertex), begin + t, place_of)) return;
      fields.contact_found[p] = begin + t;
      sight.open &= static_cast<PointBits>(~(1U << bit));
    });
  });
}

// Nothing is known about a new pair: all its distances are 0.
std::uint32_t ContactSearch::make_pair(Block& block, std::uint32_t leaf) const {
  if (block.unused.empty()) {
    block.unused.push_back(static_cast<std::uint32_t>(block.pairs.size()));
    block.pairs.emplace_back();
    block.relevant.push_back(nullptr);
  }
  const std::uint32_t place = block.unused.back();
  block.unused.pop_back();
  block.pairs[place] = {};
  const auto near =
      std::lower_bound(block.rest->near.begin(), block.rest->near.end(), leaf,
                       [](const ContactRest::Near& of, std::uint32_t number) { return of.leaf < number; });
  const bool is_near = near != block.rest->near.end() && near->leaf == leaf;
  block.relevant[place] = is_near ? rest_->relevant.data() + near->first : nullptr;
  return place;
}

// A single thread visits the contacts tetrahedron by tetrahedron. For each vertex this is the order of
// contact_crowd and of the kernels that sum impulses.
void ContactSearch::crowd(Fields& fields) {
  found_.clear();
  for (std::uint32_t p = 0; p < model_.contact.size(); ++p)
    if (fields.contact_found[p] != shader::no_contact) found_.push_back({fields.contact_found[p], p});
  std::sort(found_.begin(), found_.end());
  list_shares(fields);
  for (std::size_t k = 0; k < touched_.size(); ++k) {
    float sum = std::abs(shares_[first_share_[k]].weight);
    for (std::uint32_t e = first_share_[k] + 1; e < first_share_[k + 1]; ++e)
      sum += std::abs(shares_[e].weight);
    fields.contact_crowd[touched_[k]] = sum;
  }
}

// A vertex's own contact first, then those of its tetrahedra.
void ContactSearch::list_shares(const Fields& fields) {
  for (const std::uint32_t i : touched_) place_[i] = nothing;
  touched_.clear();
  first_share_.assign(1, 0);
  const auto count = [&](std::uint32_t i) {
    if (place_[i] == nothing) {
      place_[i] = static_cast<std::uint32_t>(touched_.size());
      touched_.push_back(i);
      first_share_.push_back(0);
    }
    ++first_share_[place_[i] + 1];
  };
  for (const auto& [t, p] : found_) {
    count(model_.contact[p].vertex);
    for (const std::uint32_t i : corners_of(model_, t)) count(i);
  }
  std::partial_sum(first_share_.begin(), first_share_.end(), first_share_.begin());
  shares_.resize(first_share_.back());
  std::vector<std::uint32_t> next(first_share_.begin(), first_share_.end() - 1);
  for (const auto& [t, p] : found_) shares_[next[place_[model_.contact[p].vertex]]++] = {p, 1.0f};
  for (const auto& [t, p] : found_)
    for (std::size_t k = 0; k < 4; ++k)
      shares_[next[place_[corners_of(model_, t)[k]]]++] = {
          p, -fields.contact_place[contact_place_stride * p + k]};
}

bool ContactSearch::runs(model::Kernel kernel) {
  return kernel >= model::Kernel::contact_hold && kernel <= model::Kernel::contact;
}

void ContactSearch::run(model::Kernel kernel, const SubstepInput& in, Fields& fields, ThreadPool& pool) {
  using model::Kernel;
  const auto for_each_found = [&](ModelStage stage) {
    run_over(found_.size(), pool, [&](std::size_t k) {
      const std::uint32_t p = found_[k].point;
      stage(model_, in, fields, {p, p + 1});
    });
  };
  using Apply = void (*)(const model::Model& model, const SubstepInput& in, Fields& fields, std::uint32_t i,
                         const Place& sum);
  const auto for_each_touched = [&](Apply apply) {
    run_over(touched_.size(), pool,
             [&](std::size_t k) { apply(model_, in, fields, touched_[k], sum_of_impulses(fields, k)); });
  };
  switch (kernel) {
    case Kernel::contact_hold:
      return for_each_found(&contact_hold);
    case Kernel::contact_settle:
      return for_each_found(&contact_settle);
    case Kernel::contact_press:
      return for_each_found(&contact_press);
    case Kernel::contact_yield:
      return for_each_touched(&contact_apply_yield);
    case Kernel::contact_rest:
      return for_each_touched(&contact_apply_rest);
    default:
      return for_each_touched(&contact_apply);
  }
}

Place ContactSearch::sum_of_impulses(const Fields& fields, std::size_t touched) const {
  const auto term = [&](std::uint32_t e) {
    const Share& share = shares_[e];
    return kernel::scaled_vector<float>(
        share.weight, place_at(fields.contact_impulse.data() + 3 * std::size_t{share.point}));
  };
  Place sum = term(first_share_[touched]);
  for (std::uint32_t e = first_share_[touched] + 1; e < first_share_[touched + 1]; ++e)
    sum = kernel::vector_sum<float>(sum, term(e));
  return sum;
}

}  // namespace fascicle::cpu_reference
