#include "host/build/bone_layer.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace fascicle::build {

namespace {

constexpr std::uint32_t no_part = std::numeric_limits<std::uint32_t>::max();
// Cost factor of an edge at the skin, relative to the bone.
constexpr double dearer_at_skin = 4.0;
constexpr double longest_of_diagonal = 0.1;
// Bone ends closer than this part of the bone's length coincide: rigs are stored in floats.
constexpr double same_place = 1e-5;

struct Islands {
  std::vector<std::uint32_t> of;  // per vertex: its island, or no_part
  std::vector<std::uint32_t> first;
  std::vector<std::size_t> size;
};

Islands find_islands(const OneRings& rings, const std::vector<char>& is_bone) {
  Islands islands{std::vector<std::uint32_t>(is_bone.size(), no_part), {}, {}};
  for (std::uint32_t start = 0; start < is_bone.size(); ++start) {
    if (!is_bone[start] || islands.of[start] != no_part) continue;
    const auto number = static_cast<std::uint32_t>(islands.first.size());
    islands.first.push_back(start);
    islands.of[start] = number;
    std::vector<std::uint32_t> open{start};
    std::size_t size = 0;
    for (; !open.empty(); ++size) {
      const std::uint32_t i = open.back();
      open.pop_back();
      for (const std::uint32_t j : rings[i])
        if (is_bone[j] && islands.of[j] == no_part) islands.of[j] = number, open.push_back(j);
    }
    islands.size.push_back(size);
  }
  return islands;
}

// The first vertex of each island except the largest of its part of the mesh.
std::vector<std::uint32_t> islands_apart(const Islands& islands, const Parts& parts) {
  std::vector<std::uint32_t> largest(parts.count, no_part), apart;
  for (std::uint32_t k = 0; k < islands.first.size(); ++k) {
    std::uint32_t& best = largest[parts.of_vertex[islands.first[k]]];
    if (best == no_part || islands.size[k] > islands.size[best]) best = k;
  }
  for (std::uint32_t k = 0; k < islands.first.size(); ++k)
    if (largest[parts.of_vertex[islands.first[k]]] != k) apart.push_back(islands.first[k]);
  return apart;
}

// For each bone the first bone in the same place: several joints may lead from one place to another.
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

// Edge costs that grow with the square of the distance from the bone's axis, so that a path keeps to the axis
// if it can.
class Axis {
 public:
  Axis(const Bone& bone, const std::vector<Vector3d>& vertices, double spacing)
      : bone_(bone), vertices_(vertices), spacing_(spacing) {}
  double cost_of(std::uint32_t a, std::uint32_t b) const {
    const double off = (distance(a) + distance(b)) / (2.0 * spacing_);
    return (vertices_[a] - vertices_[b]).norm() * (1.0 + off * off);
  }

 private:
  double distance(std::uint32_t vertex) const {
    return segment_distance(vertices_[vertex], bone_.from, bone_.to);
  }
  const Bone& bone_;
  const std::vector<Vector3d>& vertices_;
  double spacing_;
};

// The cheapest path between two vertices through open vertices; empty if there is none.
std::vector<std::uint32_t> way_along(const Axis& axis, const OneRings& rings, const std::vector<char>& open,
                                     std::uint32_t start, std::uint32_t goal) {
  std::unordered_map<std::uint32_t, std::pair<double, std::uint32_t>> reached{{start, {0.0, no_part}}};
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  queue.emplace(0.0, start);
  while (!queue.empty()) {
    const auto [cost, i] = queue.top();
    queue.pop();
    if (i == goal) break;
    if (cost > reached.at(i).first) continue;
    for (const std::uint32_t j : rings[i]) {
      if (!open[j]) continue;
      const double next = cost + axis.cost_of(i, j);
      const auto [entry, is_new] = reached.try_emplace(j, next, i);
      if (!is_new && next >= entry->second.first) continue;
      entry->second = {next, i};
      queue.emplace(next, j);
    }
  }
  std::vector<std::uint32_t> way;
  if (!reached.contains(goal)) return way;
  for (std::uint32_t i = goal; i != no_part; i = reached.at(i).second) way.push_back(i);
  return way;
}

double mean_ring_edge(const std::vector<Vector3d>& vertices, const OneRings& rings) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < vertices.size(); ++i)
    for (const std::uint32_t j : rings[i]) sum += (vertices[i] - vertices[j]).norm(), ++count;
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

// Marks a path along every bone, from the bone's vertex nearest to one end to its vertex nearest to the
// other: through its own vertices if they are connected, else through any. A slender limb may have only
// vertices that lie nearer to the skin than to the bone, and would otherwise have no bone in it.
void lay_along_bones(Measures& measures, const OneRings& rings, const std::vector<char>& closed,
                     std::vector<char>& is_bone, BoneLayerReport& report) {
  const Body& body = measures.body();
  const std::vector<Vector3d>& vertices = body.mesh.vertices;
  const std::vector<NearestBone>& nearest = measures.nearest_bones();
  const std::vector<std::uint32_t> first = first_in_place(body.bones);
  std::vector<std::vector<std::uint32_t>> own(body.bones.size());
  std::vector<char> owns(body.bones.size(), 0);
  for (std::uint32_t i = 0; i < nearest.size(); ++i) {
    if (!closed[i] || is_bone[i]) own[first[nearest[i].bone]].push_back(i);
    if (is_bone[i]) owns[first[nearest[i].bone]] = 1;
  }
  const double spacing = mean_ring_edge(vertices, rings);
  std::vector<char> any(closed.size());
  for (std::size_t i = 0; i < any.size(); ++i) any[i] = !closed[i] || is_bone[i];
  std::vector<char> open(closed.size(), 0);
  for (std::uint32_t b = 0; b < body.bones.size(); ++b) {
    if (first[b] != b) continue;
    if (own[b].empty()) {
      report.without.push_back(b);
      continue;
    }
    const auto nearest_to = [&](const Vector3d& point) {
      return *std::min_element(own[b].begin(), own[b].end(), [&](std::uint32_t i, std::uint32_t j) {
        return (vertices[i] - point).squaredNorm() < (vertices[j] - point).squaredNorm();
      });
    };
    const std::uint32_t start = nearest_to(body.bones[b].from), goal = nearest_to(body.bones[b].to);
    const Axis axis(body.bones[b], vertices, spacing);
    for (const std::uint32_t i : own[b]) open[i] = 1;
    std::vector<std::uint32_t> way = way_along(axis, rings, open, start, goal);
    for (const std::uint32_t i : own[b]) open[i] = 0;
    if (way.empty()) way = way_along(axis, rings, any, start, goal);
    if (way.empty() && !owns[b]) way = {start};
    for (const std::uint32_t i : way) {
      if (!is_bone[i]) ++report.added;
      is_bone[i] = 1;
    }
  }
}

// Shortest paths from the islands outward, and where two of them meet.
struct Meeting {
  double cost;
  std::uint32_t a, b;  // neighbours on paths from different islands
};

void join_islands(Measures& measures, const OneRings& rings, const std::vector<char>& closed,
                  std::vector<char>& is_bone, BoneLayerReport& report) {
  const std::vector<Vector3d>& vertices = measures.body().mesh.vertices;
  const std::vector<double>& depth = measures.depths();
  const Islands islands = find_islands(rings, is_bone);
  if (islands.first.size() < 2) return;

  const double longest = longest_of_diagonal * diagonal_of_member(measures.body());
  const auto cost_of = [&](std::uint32_t a, std::uint32_t b) {
    return (vertices[a] - vertices[b]).norm() * (1.0 + (dearer_at_skin - 1.0) * (depth[a] + depth[b]) / 2.0);
  };
  std::vector<double> cost(is_bone.size(), std::numeric_limits<double>::infinity());
  std::vector<std::uint32_t> from(is_bone.size(), no_part), island = islands.of;
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
      if (i < j && island[i] != no_part && island[j] != no_part && island[i] != island[j])
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
    for (; from[i] != no_part; i = from[i]) length += (vertices[i] - vertices[from[i]]).norm();
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
      for (; from[i] != no_part; i = from[i]) {
        if (!is_bone[i]) ++report.added;
        is_bone[i] = 1;
      }
  }
}

}  // namespace

BoneLayerReport complete_bone_layer(Measures& measures, const OneRings& rings,
                                    const std::vector<char>& closed, std::vector<char>& is_bone) {
  BoneLayerReport report;
  const Parts parts = connected_parts(rings);
  report.islands_before = islands_apart(find_islands(rings, is_bone), parts).size() + 1;
  lay_along_bones(measures, rings, closed, is_bone, report);
  join_islands(measures, rings, closed, is_bone, report);
  report.island_vertex = islands_apart(find_islands(rings, is_bone), parts);
  report.islands = report.island_vertex.size() + 1;
  return report;
}

}  // namespace fascicle::build
