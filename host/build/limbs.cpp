#include "host/build/limbs.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <queue>
#include <utility>

#include "host/build/unions.h"

namespace fascicle::build {

namespace {

constexpr double least_kin_share = 0.05;

}  // namespace

Limbs::Limbs(const mesh::SurfaceMesh& skin, const SkinWeights& weights,
             const std::vector<rig::Joint>& skeleton, Separation separation, const Partings* partings)
    : skin_(skin), weights_(weights), skeleton_(skeleton), separation_(separation), partings_(partings) {
  if (weights_.offset.empty()) return;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  Unions unions(skin.vertices.size());
  for (const auto& t : skin.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      edges.emplace_back(t[k], t[(k + 1) % 3]);
      edges.emplace_back(t[(k + 1) % 3], t[k]);
      unions.join(t[k], t[(k + 1) % 3]);
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  edge_offset_.assign(skin.vertices.size() + 1, 0);
  for (const auto& [from, to] : edges) {
    ++edge_offset_[from + 1];
    edge_end_.push_back(to);
  }
  for (std::size_t i = 1; i < edge_offset_.size(); ++i) edge_offset_[i] += edge_offset_[i - 1];
  for (std::uint32_t v = 0; v < skin.vertices.size(); ++v) part_.push_back(unions.find(v));
}

std::vector<Limbs::Share> Limbs::shares_of(std::span<const std::uint32_t> triangles) const {
  std::map<std::uint32_t, double> sum;
  double whole = 0.0;
  for (const std::uint32_t t : triangles)
    for (const std::uint32_t v : skin_.triangles[t])
      for (std::uint32_t k = weights_.offset[v]; k < weights_.offset[v + 1]; ++k) {
        sum[weights_.joint[k]] += weights_.weight[k];
        whole += weights_.weight[k];
      }
  std::vector<Share> shares;
  for (const auto& [joint, weight] : sum) shares.push_back({joint, weight / whole});
  return shares;
}

double Limbs::in_common(const std::vector<Share>& a, const std::vector<Share>& b) {
  double sum = 0.0;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (i->joint == j->joint)
      sum += std::min((i++)->weight, (j++)->weight);
    else if (i->joint < j->joint)
      ++i;
    else
      ++j;
  }
  return sum;
}

bool Limbs::are_kin(const std::vector<Share>& a, const std::vector<Share>& b) const {
  for (const Share& i : a)
    for (const Share& j : b) {
      const auto parent_of = [&](std::uint32_t joint) { return skeleton_[joint].parent; };
      const bool is_kin = parent_of(i.joint) == static_cast<std::int32_t>(j.joint) ||
                          parent_of(j.joint) == static_cast<std::int32_t>(i.joint);
      if (is_kin && i.weight >= least_kin_share && j.weight >= least_kin_share) return true;
    }
  return false;
}

bool Limbs::are_within_reach(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) const {
  std::vector<std::uint32_t> goal;
  for (const std::uint32_t t : b)
    goal.insert(goal.end(), skin_.triangles[t].begin(), skin_.triangles[t].end());
  std::sort(goal.begin(), goal.end());
  // Dijkstra, 1959, limited to the distance.
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::map<std::uint32_t, double> reached;
  for (const std::uint32_t t : a)
    for (const std::uint32_t v : skin_.triangles[t])
      if (reached.emplace(v, 0.0).second) queue.emplace(0.0, v);
  while (!queue.empty()) {
    const auto [length, v] = queue.top();
    queue.pop();
    if (length > reached[v]) continue;
    if (std::binary_search(goal.begin(), goal.end(), v)) return true;
    for (std::uint32_t k = edge_offset_[v]; k < edge_offset_[v + 1]; ++k) {
      const std::uint32_t next = edge_end_[k];
      const double farther = length + (skin_.vertices[next] - skin_.vertices[v]).norm();
      if (farther > separation_.distance) continue;
      const auto [place, is_new] = reached.emplace(next, farther);
      if (!is_new && place->second <= farther) continue;
      place->second = farther;
      queue.emplace(farther, next);
    }
  }
  return false;
}

Limbs::Kind Limbs::kind_of(std::span<const std::uint32_t> triangles) const {
  Kind kind{shares_of(triangles), {}};
  for (const std::uint32_t t : triangles) kind.each.push_back(shares_of(std::array{t}));
  std::sort(kind.each.begin(), kind.each.end());
  kind.each.erase(std::unique(kind.each.begin(), kind.each.end()), kind.each.end());
  return kind;
}

std::uint32_t Limbs::part_of(std::span<const std::uint32_t> triangles) const {
  return part_[skin_.triangles[triangles[0]][0]];
}

bool Limbs::are_strangers(const Kind& a, const Kind& b) const {
  const auto has_stranger = [&](const Kind& of, const Kind& to) {
    return std::any_of(of.each.begin(), of.each.end(), [&](const std::vector<Share>& shares) {
      return in_common(shares, to.mean) < separation_.in_common;
    });
  };
  return has_stranger(a, b) || has_stranger(b, a);
}

bool Limbs::do_part(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) const {
  return partings_ != nullptr && std::any_of(a.begin(), a.end(), [&](std::uint32_t i) {
           return std::any_of(b.begin(), b.end(), [&](std::uint32_t j) { return partings_->do_part(i, j); });
         });
}

bool Limbs::are_apart_as_parts(const Kind& a, const Kind& b) const {
  return are_strangers(a, b) && !are_kin(a.mean, b.mean);
}

bool Limbs::are_apart_in_part(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b,
                              bool are_strangers) const {
  if (!are_strangers && partings_ == nullptr) return false;
  // Clips last: they cost the most, and most adjacent skin is within reach.
  return !are_within_reach(a, b) && (are_strangers || do_part(a, b));
}

bool Limbs::are_apart(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) const {
  if (weights_.offset.empty()) return false;
  const Kind of_a = kind_of(a), of_b = kind_of(b);
  if (part_of(a) != part_of(b)) return are_apart_as_parts(of_a, of_b);
  return are_apart_in_part(a, b, are_strangers(of_a, of_b));
}

// The patches of one limb. Hair may be thousands of parts with the same weights: parts are compared kind by
// kind, and only patches of one part each with each.
class Limbs::Group {
 public:
  bool is_apart_from(const Limbs& limbs, const std::vector<Kind>& kinds, const Patch& patch) const {
    for (const auto& [kind, part] : parts_)
      if (part != patch.part && limbs.are_apart_as_parts(kinds[kind], kinds[patch.kind])) return true;
    const auto same = members_.find(patch.part);
    if (same == members_.end()) return false;
    return std::any_of(same->second.begin(), same->second.end(), [&](const Patch* member) {
      return limbs.are_apart_in_part(member->triangles, patch.triangles,
                                     limbs.are_strangers(kinds[member->kind], kinds[patch.kind]));
    });
  }

  void add(const Patch& patch) {
    const auto [place, is_new] = parts_.emplace(patch.kind, patch.part);
    if (!is_new && place->second != patch.part) place->second = of_several;
    members_[patch.part].push_back(&patch);
  }

  std::vector<std::uint32_t> triangles() const {
    std::vector<std::uint32_t> all;
    for (const auto& [part, members] : members_)
      for (const Patch* member : members)
        all.insert(all.end(), member->triangles.begin(), member->triangles.end());
    std::sort(all.begin(), all.end());
    return all;
  }

 private:
  static constexpr std::uint32_t of_several = std::numeric_limits<std::uint32_t>::max();

  std::map<std::uint32_t, std::uint32_t> parts_;                // kind, the part of its patches or of_several
  std::map<std::uint32_t, std::vector<const Patch*>> members_;  // by part
};

std::vector<std::vector<std::uint32_t>> Limbs::groups_of(std::span<const std::uint32_t> triangles) const {
  std::vector<std::vector<std::uint32_t>> groups;
  if (triangles.empty()) return groups;
  if (weights_.offset.empty()) return {{triangles.begin(), triangles.end()}};
  std::vector<std::pair<std::uint32_t, std::uint32_t>> corners;  // vertex, place in `triangles`
  for (std::uint32_t i = 0; i < triangles.size(); ++i)
    for (const std::uint32_t v : skin_.triangles[triangles[i]]) corners.emplace_back(v, i);
  std::sort(corners.begin(), corners.end());
  Unions patches(triangles.size());
  for (std::size_t k = 1; k < corners.size(); ++k)
    if (corners[k].first == corners[k - 1].first) patches.join(corners[k].second, corners[k - 1].second);

  std::map<std::uint32_t, std::vector<std::uint32_t>> found;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) found[patches.find(i)].push_back(triangles[i]);
  if (found.size() == 1) {
    std::sort(found.begin()->second.begin(), found.begin()->second.end());
    return {std::move(found.begin()->second)};
  }
  std::vector<Patch> all_patches;
  std::map<Kind, std::uint32_t> number;
  for (auto& [first, members] : found) {
    const auto [kind, is_new] = number.emplace(kind_of(members), static_cast<std::uint32_t>(number.size()));
    const std::uint32_t part = part_of(members);
    all_patches.push_back({std::move(members), part, kind->second});
  }
  std::vector<Kind> kinds(number.size());
  for (const auto& [kind, k] : number) kinds[k] = kind;
  std::stable_sort(all_patches.begin(), all_patches.end(),
                   [](const Patch& a, const Patch& b) { return a.triangles.size() > b.triangles.size(); });
  std::vector<Group> limbs;
  for (const Patch& patch : all_patches) {
    const auto home = std::find_if(limbs.begin(), limbs.end(), [&](const Group& limb) {
      return !limb.is_apart_from(*this, kinds, patch);
    });
    (home == limbs.end() ? limbs.emplace_back() : *home).add(patch);
  }
  for (const Group& limb : limbs) groups.push_back(limb.triangles());
  std::sort(groups.begin(), groups.end());
  return groups;
}

}  // namespace fascicle::build
