#include "cpu_reference/solver/contact_rest.h"

#include <algorithm>
#include <array>

#include "cpu_reference/solver/contact_meets.h"
#include "host/model/contact_near.h"
#include "host/model/contact_order.h"

namespace fascicle::cpu_reference {

namespace {

constexpr std::uint32_t block_size = ContactRest::block_size, leaf_size = ContactRest::leaf_size;
using PointBits = ContactRest::PointBits;

float squared(const Place& v) {
  return kernel::inner_product<float>(v, v);
}

// The distance between two boxes.
float squared_distance(const ContactBox& a, const ContactBox& b) {
  const auto along = [](float low, float high, float other_low, float other_high) {
    return std::max({low - other_high, other_low - high, 0.0f});
  };
  return squared({along(a.low.x, a.high.x, b.low.x, b.high.x), along(a.low.y, a.high.y, b.low.y, b.high.y),
                  along(a.low.z, a.high.z, b.low.z, b.high.z)});
}

std::uint32_t block_begin(std::size_t block) {
  return static_cast<std::uint32_t>(block) * block_size;
}
std::uint32_t block_end(const ContactRest& rest, std::size_t block) {
  return std::min(block_begin(block) + block_size, static_cast<std::uint32_t>(rest.order.size()));
}
std::uint32_t leaf_end(const model::Model& model, std::uint32_t leaf) {
  return std::min((leaf + 1) * leaf_size, model.contact_tetrahedron_count());
}

// Partly ignored blocks and leaves are left to contact_meets.
void find_ignored(const model::Model& model, ContactRest& rest) {
  if (!model.has_ignored_contact()) return;
  for (std::uint32_t b = 0; b < rest.blocks.size(); ++b) {
    rest.blocks[b].ignored = ~std::uint32_t{0};
    for (std::uint32_t k = block_begin(b); k < block_end(rest, b); ++k)
      rest.blocks[b].ignored &= model.contact_ignored[rest.order[k]];
  }
  for (std::uint32_t leaf = 0; leaf < model.contact_leaf_count(); ++leaf) {
    rest.leaf_group.push_back(~std::uint32_t{0});
    for (std::uint32_t t = leaf * leaf_size; t < leaf_end(model, leaf); ++t)
      rest.leaf_group.back() &= model.contact_group[t];
  }
}

// For each of a leaf's tetrahedra, the points that may meet it. A tetrahedron whose corners are all nearer to
// a point at rest than its margin does not meet it (kernel::contact_is_near explains the 0.99), unless all
// are across a gap.
std::array<PointBits, leaf_size> relevant_at_rest(const model::Model& model, const ContactRest& rest,
                                                  std::uint32_t block, std::uint32_t leaf,
                                                  const std::vector<PointBits>& across_of) {
  constexpr std::size_t most_vertices = std::size_t{4} * leaf_size;
  std::array<PointBits, most_vertices> near{}, across{}, moved_by{};
  const PointBits points = rest.blocks[block].points;
  for (std::uint32_t v = rest.leaf_offset[leaf]; v < rest.leaf_offset[leaf + 1]; ++v) {
    const std::uint32_t i = rest.leaf_vertex[v];
    const std::size_t at = v - rest.leaf_offset[leaf];
    across[at] = across_of[i];
    moved_by[at] = model.mobility[i] > 0.0f ? points : rest.blocks[block].mobile;
  }
  for (std::uint32_t k = block_begin(block); k < block_end(rest, block); ++k) {
    const auto bit = static_cast<PointBits>(1U << (k - block_begin(block)));
    const shader::ContactPoint& point = model.contact[rest.order[k]];
    const Place x = rest_sight(model, point.vertex);
    const float most = 0.99f * (point.margin * point.margin);
    for (std::uint32_t v = rest.leaf_offset[leaf]; v < rest.leaf_offset[leaf + 1]; ++v)
      if (squared(kernel::subtract<float>(rest_sight(model, rest.leaf_vertex[v]), x)) < most)
        near[v - rest.leaf_offset[leaf]] |= bit;
  }
  std::array<PointBits, leaf_size> relevant{};
  for (std::uint32_t t = leaf * leaf_size; t < leaf_end(model, leaf); ++t) {
    PointBits all_near = points, all_across = points, moved = 0;
    for (std::size_t c = 4 * std::size_t{t}; c < 4 * std::size_t{t} + 4; ++c) {
      all_near &= near[rest.leaf_corner[c]];
      all_across &= across[rest.leaf_corner[c]];
      moved |= moved_by[rest.leaf_corner[c]];
    }
    relevant[t - leaf * leaf_size] = static_cast<PointBits>(moved & (~all_near | all_across));
  }
  return relevant;
}

void find_near(const model::Model& model, ContactRest& rest) {
  const auto rest_box = [&](std::uint32_t number) {
    const float* from = model.contact_rest_box.data() + 8 * std::size_t{number};
    return ContactBox{place_at(from), place_at(from + 4)};
  };
  const std::uint32_t leaves = model.contact_leaf_count();
  // For each vertex, the points of the current block that it is near across a gap.
  std::vector<PointBits> across(model.vertex_count, 0);
  const auto for_each_across = [&](std::uint32_t b, const auto& use) {
    for (std::uint32_t k = block_begin(b); k < block_end(rest, b); ++k) {
      const shader::ContactPoint& point = model.contact[rest.order[k]];
      for (const shader::VertexRun& run : model::near_runs(model, point))
        for (std::uint32_t i = run.first; i < run.end; ++i)
          use(across[i], static_cast<PointBits>(1U << (k - block_begin(b))));
    }
  };
  for (std::uint32_t b = 0; b < rest.blocks.size(); ++b) {
    ContactRest::Block& block = rest.blocks[b];
    for_each_across(b, [](PointBits& of, PointBits bit) { of |= bit; });
    ContactBox box = empty_contact_box;
    float margin = 0.0f;
    for (std::uint32_t k = block_begin(b); k < block_end(rest, b); ++k) {
      const Place x = rest_sight(model, rest.order_vertex[k]);
      grow(box, {x, x});
      margin = std::max(margin, model.contact[rest.order[k]].margin);
    }
    const auto is_far = [&](std::uint32_t number) {
      return squared_distance(box, rest_box(number)) > margin * margin;
    };
    for (std::uint32_t leaf = 0; leaf < leaves; ++leaf) {
      if (leaf % shader::contact_branch == 0 && is_far(leaves + leaf / shader::contact_branch)) {
        leaf += shader::contact_branch - 1;
        continue;
      }
      // ContactLook::all excludes pairs in which both sides follow the skeleton.
      if (is_far(leaf) || (block.mobile == 0 && rest.leaf_is_held[leaf] != 0)) continue;
      const std::array<PointBits, leaf_size> relevant = relevant_at_rest(model, rest, b, leaf, across);
      const auto first = relevant.begin(), last = first + (leaf_end(model, leaf) - leaf * leaf_size);
      if (std::all_of(first, last, [&](PointBits of) { return of == block.points; })) continue;
      block.near.push_back({leaf, rest.relevant.size()});
      rest.relevant.insert(rest.relevant.end(), relevant.begin(), relevant.end());
    }
    for_each_across(b, [](PointBits& of, PointBits) { of = 0; });
  }
}

bool is_same_point(const shader::ContactPoint& a, const shader::ContactPoint& b) {
  return a.vertex == b.vertex && a.margin == b.margin && a.first_near == b.first_near &&
         a.near_count == b.near_count;
}

bool is_same_run(const shader::VertexRun& a, const shader::VertexRun& b) {
  return a.first == b.first && a.end == b.end;
}

}  // namespace

ContactRest::ContactRest(const model::Model& model) : order(model::contact_points_along_curve(model)) {
  for (const std::uint32_t p : order) order_vertex.push_back(model.contact[p].vertex);
  leaf_offset.push_back(0);
  for (std::uint32_t leaf = 0; leaf < model.contact_leaf_count(); ++leaf) {
    const auto begin = model.contact_tetrahedron.begin() + std::ptrdiff_t{4} * leaf * leaf_size,
               end = model.contact_tetrahedron.begin() + std::ptrdiff_t{4} * leaf_end(model, leaf);
    std::vector<std::uint32_t> vertices(begin, end);
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (auto corner = begin; corner != end; ++corner)
      leaf_corner.push_back(static_cast<std::uint8_t>(
          std::lower_bound(vertices.begin(), vertices.end(), *corner) - vertices.begin()));
    leaf_is_held.push_back(
        std::none_of(begin, end, [&](std::uint32_t i) { return model.mobility[i] > 0.0f; }) ? 1 : 0);
    leaf_vertex.insert(leaf_vertex.end(), vertices.begin(), vertices.end());
    leaf_offset.push_back(static_cast<std::uint32_t>(leaf_vertex.size()));
  }
  blocks.resize(model::parts_of(static_cast<std::uint32_t>(order.size()), block_size));
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (std::uint32_t k = block_begin(b); k < block_end(*this, b); ++k) {
      const auto bit = static_cast<PointBits>(1U << (k - block_begin(b)));
      blocks[b].points |= bit;
      if (model.mobility[order_vertex[k]] > 0.0f) blocks[b].mobile |= bit;
    }
  find_ignored(model, *this);
  find_near(model, *this);
}

// Keeps copies of the model's arrays that it depends on, as that model may no longer exist.
struct ContactRestMemory::Kept {
  explicit Kept(const model::Model& model)
      : rest(model),
        places(model.rest),
        box(model.contact_rest_box),
        tetrahedron(model.contact_tetrahedron),
        ignored(model.contact_ignored),
        group(model.contact_group),
        point(model.contact),
        near(model.contact_near) {
    for (const float mobility : model.mobility) moves.push_back(mobility > 0.0f ? 1 : 0);
  }

  bool is_of(const model::Model& model) const {
    return places == model.rest && box == model.contact_rest_box &&
           tetrahedron == model.contact_tetrahedron && ignored == model.contact_ignored &&
           group == model.contact_group && std::ranges::equal(point, model.contact, is_same_point) &&
           std::ranges::equal(near, model.contact_near, is_same_run) &&
           std::ranges::equal(moves, model.mobility, [](char moves_here, float mobility) {
             return (moves_here != 0) == (mobility > 0.0f);
           });
  }

  ContactRest rest;
  std::vector<float> places, box;
  std::vector<std::uint32_t> tetrahedron, ignored, group;
  std::vector<shader::ContactPoint> point;
  std::vector<shader::VertexRun> near;
  std::vector<char> moves;
};

std::shared_ptr<const ContactRest> ContactRestMemory::of(const model::Model& model) {
  if (!kept_ || !kept_->is_of(model)) kept_ = std::make_shared<const Kept>(model);
  return {kept_, &kept_->rest};
}

}  // namespace fascicle::cpu_reference
