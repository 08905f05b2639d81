#include "host/build/bone_layer.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>

namespace fascicle::build {

namespace {

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
// At the skin an edge of a way counts this much more than at the bone.
constexpr double dearer_at_skin = 4.0;
constexpr double longest_of_diagonal = 0.1;
// Part of a bone's length within which ends are the same: rigs are stored in floats.
constexpr double same_place = 1e-5;

struct Islands {
  std::vector<std::uint32_t> of;  // a vertex: its island, or none
  std::vector<std::uint32_t> first;
  std::vector<std::size_t> size;
};

Islands find_islands(const OneRings& rings, const std::vector<char>& is_bone) {
  Islands islands{std::vector<std::uint32_t>(is_bone.size(), none), {}, {}};
  for (std::uint32_t start = 0; start < is_bone.size(); ++start) {
    if (!is_bone[start] || islands.of[start] != none) continue;
    const auto number = static_cast<std::uint32_t>(islands.first.size());
    islands.first.push_back(start);
    islands.of[start] = number;
    std::vector<std::uint32_t> open{start};
    std::size_t size = 0;
    for (; !open.empty(); ++size) {
      const std::uint32_t i = open.back();
      open.pop_back();
      for (const std::uint32_t j : rings[i])
        if (is_bone[j] && islands.of[j] == none) islands.of[j] = number, open.push_back(j);
    }
    islands.size.push_back(size);
  }
  return islands;
}

double diagonal(const std::vector<Vector3d>& vertices) {
  Vector3d low = vertices[0], high = vertices[0];
  for (const Vector3d& p : vertices) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return (high - low).norm();
}

// For each bone the first that lies in its place: several joints may lead from one place to another.
std::vector<std::uint32_t> first_in_place(const std::vector<Bone>& bones) {
  const auto lie_together = [](const Bone& a, const Bone& b) {
    const double near = same_place * (a.to - a.from).norm();
    return (a.from - b.from).norm() <= near && (a.to - b.to).norm() <= near;
  };
  std::vector<std::uint32_t> first(bones.size());
  for (std::uint32_t b = 0; b < bones.size(); ++b)
    for (first[b] = 0; first[b] < b; ++first[b])
      if (lie_together(bones[first[b]], bones[b])) break;
  return first;
}

// A vertex for each bone that owns none.
void give_each_bone_a_vertex(Measures& measures, const std::vector<char>& closed, std::vector<char>& is_bone,
                             BoneLayerReport& report) {
  const std::vector<NearestBone>& nearest = measures.nearest_bones();
  const std::size_t bones = measures.body().bones.size();
  const std::vector<std::uint32_t> first = first_in_place(measures.body().bones);
  std::vector<char> owns(bones, 0);
  std::vector<std::uint32_t> best(bones, none);
  for (std::uint32_t i = 0; i < nearest.size(); ++i) {
    const std::uint32_t bone = first[nearest[i].bone];
    if (is_bone[i]) owns[bone] = 1;
    if (closed[i]) continue;
    if (best[bone] == none || nearest[i].distance < nearest[best[bone]].distance) best[bone] = i;
  }
  for (std::uint32_t bone = 0; bone < bones; ++bone) {
    if (first[bone] != bone || owns[bone]) continue;
    if (best[bone] == none) {
      report.without.push_back(bone);
      continue;
    }
    is_bone[best[bone]] = 1;
    ++report.added;
  }
}

// Shortest ways from the islands outward, and where two of them meet.
struct Meeting {
  double cost;
  std::uint32_t a, b;  // neighbours on ways from different islands
};

void join_islands(Measures& measures, const OneRings& rings, const std::vector<char>& closed,
                  std::vector<char>& is_bone, BoneLayerReport& report) {
  const std::vector<Vector3d>& vertices = measures.body().mesh.vertices;
  const std::vector<double>& depth = measures.depths();
  const Islands islands = find_islands(rings, is_bone);
  report.islands_before = islands.first.size();
  if (islands.first.size() < 2) return;

  const double longest = longest_of_diagonal * diagonal(vertices);
  const auto cost_of = [&](std::uint32_t a, std::uint32_t b) {
    return (vertices[a] - vertices[b]).norm() * (1.0 + (dearer_at_skin - 1.0) * (depth[a] + depth[b]) / 2.0);
  };
  std::vector<double> cost(is_bone.size(), std::numeric_limits<double>::infinity());
  std::vector<std::uint32_t> from(is_bone.size(), none), island = islands.of;
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (std::uint32_t i = 0; i < is_bone.size(); ++i)
    if (is_bone[i]) cost[i] = 0.0, queue.emplace(0.0, i);
  while (!queue.empty()) {
    const auto [reached, i] = queue.top();
    queue.pop();
    if (reached > cost[i]) continue;
    for (const std::uint32_t j : rings[i]) {
      const double next = reached + cost_of(i, j);
      if (closed[j] || is_bone[j] || next >= cost[j] || next > longest * dearer_at_skin) continue;
      cost[j] = next;
      from[j] = i;
      island[j] = island[i];
      queue.emplace(next, j);
    }
  }

  std::vector<Meeting> meetings;
  for (std::uint32_t i = 0; i < is_bone.size(); ++i)
    for (const std::uint32_t j : rings[i])
      if (i < j && island[i] != none && island[j] != none && island[i] != island[j])
        meetings.push_back({cost[i] + cost_of(i, j) + cost[j], i, j});
  std::sort(meetings.begin(), meetings.end(), [](const Meeting& x, const Meeting& y) {
    return std::tuple(x.cost, x.a, x.b) < std::tuple(y.cost, y.a, y.b);
  });

  std::vector<std::uint32_t> joined(islands.first.size());
  std::iota(joined.begin(), joined.end(), 0u);
  const auto root = [&](std::uint32_t k) {
    while (joined[k] != k) k = joined[k];
    return k;
  };
  const auto length_to_island = [&](std::uint32_t i) {
    double length = 0.0;
    for (; from[i] != none; i = from[i]) length += (vertices[i] - vertices[from[i]]).norm();
    return length;
  };
  for (const Meeting& meeting : meetings) {
    const std::uint32_t a = root(island[meeting.a]), b = root(island[meeting.b]);
    if (a == b) continue;
    const double length = length_to_island(meeting.a) + length_to_island(meeting.b) +
                          (vertices[meeting.a] - vertices[meeting.b]).norm();
    if (length > longest) continue;
    joined[std::max(a, b)] = std::min(a, b);
    for (std::uint32_t i : {meeting.a, meeting.b})
      for (; from[i] != none; i = from[i]) {
        if (!is_bone[i]) ++report.added;
        is_bone[i] = 1;
      }
  }
}

}  // namespace

BoneLayerReport complete_bone_layer(Measures& measures, const OneRings& rings,
                                    const std::vector<char>& closed, std::vector<char>& is_bone) {
  BoneLayerReport report;
  give_each_bone_a_vertex(measures, closed, is_bone, report);
  join_islands(measures, rings, closed, is_bone, report);
  const Islands islands = find_islands(rings, is_bone);
  report.islands = islands.first.size();
  if (report.islands > 1) {
    const auto largest = static_cast<std::size_t>(std::max_element(islands.size.begin(), islands.size.end()) -
                                                  islands.size.begin());
    for (std::size_t k = 0; k < islands.first.size(); ++k)
      if (k != largest) report.island_vertex.push_back(islands.first[k]);
  }
  return report;
}

}  // namespace fascicle::build
