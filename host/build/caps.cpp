#include "host/build/caps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "host/build/box_tree.h"
#include "host/build/mesher.h"
#include "host/build/surface_search.h"
#include "host/build/unions.h"

namespace fascicle::build {

namespace {

using mesh::SurfaceMesh;
using scene::Vector3d;
using Triangle = std::array<std::uint32_t, 3>;

// Lid area over the area of the end's part of the skin. A sheet's outline needs nearly 1, half a pipe 0.64,
// half a ball 0.5, each end of a pipe as long as it is wide 0.25.
constexpr double most_of_part = 0.6;
// Loops with more edges are closed in two steps: first the stretch between each two of this many corners,
// then the polygon of these corners.
constexpr std::size_t most_corners = 96;

double area_of(const SurfaceMesh& skin, const Triangle& t) {
  return 0.5 *
         (skin.vertices[t[1]] - skin.vertices[t[0]]).cross(skin.vertices[t[2]] - skin.vertices[t[0]]).norm();
}

// Edges shared by an odd number of triangles. Each vertex has an even number of them, so paths along them end
// where they began, even on a non-manifold skin.
std::vector<std::array<std::uint32_t, 2>> odd_edges(const SurfaceMesh& skin) {
  std::vector<std::array<std::uint32_t, 2>> edges, odd;
  edges.reserve(3 * skin.triangles.size());
  for (const Triangle& t : skin.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      edges.push_back({low, high});
    }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    if ((end - i) % 2 == 1) odd.push_back(edges[i]);
    i = end;
  }
  return odd;
}

// Loops that visit no vertex twice and together use each of the edges once.
std::vector<std::vector<std::uint32_t>> loops_of(const std::vector<std::array<std::uint32_t, 2>>& edges) {
  std::map<std::uint32_t, std::vector<std::uint32_t>> ends;  // of each vertex, ascending
  for (const auto& [a, b] : edges) {
    ends[a].push_back(b);
    ends[b].push_back(a);
  }
  std::vector<std::vector<std::uint32_t>> loops;
  for (auto& [start, open] : ends)
    while (!open.empty()) {
      std::vector<std::uint32_t> way{start};
      for (;;) {
        auto& ways = ends[way.back()];
        if (ways.empty()) break;  // back at the start
        const std::uint32_t next = ways.front();
        ways.erase(ways.begin());
        auto& back = ends[next];
        back.erase(std::find(back.begin(), back.end(), way.back()));
        const auto seen = std::find(way.begin(), way.end(), next);
        if (seen == way.end()) {
          way.push_back(next);
          continue;
        }
        // The path met itself: the part in between is a loop, and the rest continues from there.
        loops.emplace_back(seen, way.end());
        way.erase(seen + 1, way.end());
      }
    }
  // Two edges back and forth would cancel out.
  std::erase_if(loops, [](const auto& loop) { return loop.size() < 3; });
  for (auto& loop : loops) std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
  std::sort(loops.begin(), loops.end());
  return loops;
}

// The triangulation of least area of a polygon in space, without new vertices (Barequet and Sharir, 1995).
std::vector<Triangle> least_triangulation(const SurfaceMesh& skin,
                                          const std::vector<std::uint32_t>& corners) {
  const std::size_t n = corners.size();
  std::vector<double> least(n * n, 0.0);
  std::vector<std::size_t> tip(n * n, 0);
  for (std::size_t span = 2; span < n; ++span)
    for (std::size_t i = 0; i + span < n; ++i) {
      const std::size_t k = i + span;
      double best = std::numeric_limits<double>::infinity();
      for (std::size_t j = i + 1; j < k; ++j) {
        const double area =
            least[i * n + j] + least[j * n + k] + area_of(skin, {corners[i], corners[j], corners[k]});
        if (!(area < best)) continue;
        best = area;
        tip[i * n + k] = j;
      }
      least[i * n + k] = best;
    }
  std::vector<Triangle> triangles;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, n - 1}};
  while (!open.empty()) {
    const auto [i, k] = open.back();
    open.pop_back();
    if (k < i + 2) continue;
    const std::size_t j = tip[i * n + k];
    triangles.push_back({corners[i], corners[j], corners[k]});
    open.emplace_back(i, j);
    open.emplace_back(j, k);
  }
  return triangles;
}

std::vector<Triangle> triangulation(const SurfaceMesh& skin, const std::vector<std::uint32_t>& loop) {
  const std::size_t stride = (loop.size() + most_corners - 1) / most_corners;
  if (stride <= 1) return least_triangulation(skin, loop);
  std::vector<std::uint32_t> corners;
  std::vector<Triangle> triangles;
  for (std::size_t k = 0; k < loop.size(); k += stride) {
    corners.push_back(loop[k]);
    const std::size_t next = std::min(k + stride, loop.size());
    for (std::size_t j = k + 1; j < next; ++j)
      triangles.push_back({loop[k], loop[j], loop[(j + 1) % loop.size()]});
  }
  const std::vector<Triangle> middle = least_triangulation(skin, corners);
  triangles.insert(triangles.end(), middle.begin(), middle.end());
  return triangles;
}

double width_of(const SurfaceMesh& skin, const std::vector<std::uint32_t>& loop) {
  double widest2 = 0.0;
  for (const std::uint32_t a : loop)
    for (const std::uint32_t b : loop)
      widest2 = std::max(widest2, (skin.vertices[a] - skin.vertices[b]).squaredNorm());
  return std::sqrt(widest2);
}

// Whether a segment passes through a triangle.
bool passes(const Vector3d& from, const Vector3d& to, const std::array<Vector3d, 3>& t) {
  const Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const double above = normal.dot(from - t[0]), below = normal.dot(to - t[0]);
  if ((above > 0.0) == (below > 0.0)) return false;
  const Vector3d place = from + above / (above - below) * (to - from);
  for (std::size_t k = 0; k < 3; ++k)
    if (normal.dot((t[(k + 1) % 3] - t[k]).cross(place - t[k])) < 0.0) return false;
  return true;
}

class Ends {
 public:
  Ends(const SurfaceMesh& skin, const Limbs& limbs)
      : skin_(skin), limbs_(limbs), parts_(skin.vertices.size()) {
    for (const Triangle& t : skin.triangles) {
      parts_.join(t[0], t[1]);
      parts_.join(t[1], t[2]);
    }
    for (const Triangle& t : skin.triangles) area_[parts_.find(t[0])] += area_of(skin, t);
  }

  std::vector<OpenEnd> find(const BuildOptions& options) {
    for (auto& loop : loops_of(odd_edges(skin_))) {
      check_cancelled(options);
      OpenEnd& end = ends_.emplace_back();
      end.triangles = triangulation(skin_, loop);
      end.width = width_of(skin_, loop);
      double area = 0.0;
      for (const Triangle& t : end.triangles) area += area_of(skin_, t);
      if (area > most_of_part * area_[parts_.find(loop[0])]) end.fate = OpenEnd::Fate::sheet;
      end.loop = std::move(loop);
    }
    if (limbs_.is_one_limb()) return std::move(ends_);
    for (OpenEnd& end : ends_) {
      check_cancelled(options);
      if (end.fate == OpenEnd::Fate::closed && joins_limbs(end)) end.fate = OpenEnd::Fate::hem;
    }
    return std::move(ends_);
  }

 private:
  // Triangles of other parts that pass through the triangles that would close an end.
  std::vector<std::uint32_t> crossing(const OpenEnd& end) {
    const std::uint32_t own = parts_.find(end.loop[0]);
    std::vector<BoundingBox> boxes;
    std::vector<std::array<Vector3d, 3>> lid;
    for (const Triangle& t : end.triangles) {
      lid.push_back({skin_.vertices[t[0]], skin_.vertices[t[1]], skin_.vertices[t[2]]});
      boxes.push_back(box_around(lid.back()));
    }
    const BoxTree tree(boxes);
    std::vector<std::uint32_t> found;
    for (std::uint32_t i = 0; i < skin_.triangles.size(); ++i) {
      const Triangle& t = skin_.triangles[i];
      if (parts_.find(t[0]) == own) continue;
      bool is_crossing = false;
      for (std::size_t k = 0; k < 3 && !is_crossing; ++k) {
        const Vector3d &a = skin_.vertices[t[k]], &b = skin_.vertices[t[(k + 1) % 3]];
        const double reach2 = (b - a).squaredNorm() / 4.0;
        tree.visit_near((a + b) / 2.0, reach2, [&](std::uint32_t item) {
          is_crossing = is_crossing || passes(a, b, lid[item]);
          return reach2;
        });
      }
      if (is_crossing) found.push_back(i);
    }
    return found;
  }

  bool joins_limbs(const OpenEnd& end) {
    const std::vector<std::uint32_t> through = crossing(end);
    if (limbs_.groups_of(through).size() < 2) return false;
    std::vector<std::uint32_t> parts;
    for (const std::uint32_t t : through) parts.push_back(parts_.find(skin_.triangles[t][0]));
    const std::uint32_t own = parts_.find(end.loop[0]);
    SurfaceMesh closed{skin_.vertices, {}};
    for (const Triangle& t : skin_.triangles)
      if (parts_.find(t[0]) == own) closed.triangles.push_back(t);
    for (const OpenEnd& other : ends_)
      if (parts_.find(other.loop[0]) == own)
        closed.triangles.insert(closed.triangles.end(), other.triangles.begin(), other.triangles.end());
    const SurfaceSearch search(closed);
    return std::none_of(ends_.begin(), ends_.end(), [&](const OpenEnd& other) {
      if (other.fate == OpenEnd::Fate::sheet) return false;
      if (std::find(parts.begin(), parts.end(), parts_.find(other.loop[0])) == parts.end()) return false;
      Vector3d middle = Vector3d::Zero();
      for (const std::uint32_t v : other.loop)
        middle += skin_.vertices[v] / static_cast<double>(other.loop.size());
      return search.is_inside(middle);
    });
  }

  const SurfaceMesh& skin_;
  const Limbs& limbs_;
  Unions parts_;
  std::map<std::uint32_t, double> area_;  // of each part
  std::vector<OpenEnd> ends_;
};

}  // namespace

std::vector<OpenEnd> find_open_ends(const SurfaceMesh& skin, const Limbs& limbs,
                                    const BuildOptions& options) {
  return Ends(skin, limbs).find(options);
}

SurfaceMesh with_caps(const SurfaceMesh& skin, const std::vector<OpenEnd>& ends) {
  SurfaceMesh capped = skin;
  for (const OpenEnd& end : ends)
    for (const Triangle& t : end.triangles)
      if (end.fate == OpenEnd::Fate::closed && area_of(skin, t) > 0.0) capped.triangles.push_back(t);
  return capped;
}

}  // namespace fascicle::build
