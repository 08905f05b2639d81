#include "host/build/cut.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <tuple>

#include <Eigen/Geometry>

#include "host/build/box_tree.h"
#include "host/build/surface_search.h"
#include "host/build/unions.h"

namespace fascicle::build {

namespace {

using mesh::SurfaceMesh;
using mesh::TetMesh;
using scene::Vector3d;

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

// Whether any part of a triangle is in a tetrahedron of positive volume: clips it by the four planes
// (Sutherland and Hodgman, 1974).
bool overlaps(const TetMesh& mesh, const std::array<std::uint32_t, 4>& tetrahedron,
              const std::array<Vector3d, 3>& triangle) {
  std::vector<Vector3d> polygon(triangle.begin(), triangle.end()), kept;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector3d& a = mesh.vertices[tetrahedron[(k + 1) % 4]];
    const Vector3d& b = mesh.vertices[tetrahedron[(k + 2) % 4]];
    const Vector3d& c = mesh.vertices[tetrahedron[(k + 3) % 4]];
    Vector3d normal = (b - a).cross(c - a);
    if (normal.dot(mesh.vertices[tetrahedron[k]] - a) < 0.0) normal = -normal;
    kept.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vector3d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      const double height_p = normal.dot(p - a), height_q = normal.dot(q - a);
      if (height_p >= 0.0) kept.push_back(p);
      if ((height_p >= 0.0) != (height_q >= 0.0))
        kept.push_back(p + height_p / (height_p - height_q) * (q - p));
    }
    std::swap(polygon, kept);
    if (polygon.empty()) return false;
  }
  return true;
}

// The skin's triangles in each tetrahedron, ascending.
std::vector<std::vector<std::uint32_t>> skin_in_tetrahedra(const TetMesh& cage, const SurfaceMesh& skin) {
  std::vector<BoundingBox> boxes;
  boxes.reserve(cage.tetrahedra.size());
  for (const auto& t : cage.tetrahedra)
    boxes.push_back(box_around(
        std::array{cage.vertices[t[0]], cage.vertices[t[1]], cage.vertices[t[2]], cage.vertices[t[3]]}));
  const BoxTree tree(boxes);
  std::vector<std::vector<std::uint32_t>> inside(cage.tetrahedra.size());
  for (std::uint32_t k = 0; k < skin.triangles.size(); ++k) {
    const auto& t = skin.triangles[k];
    const std::array<Vector3d, 3> triangle{skin.vertices[t[0]], skin.vertices[t[1]], skin.vertices[t[2]]};
    const Vector3d middle = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
    double radius2 = 0.0;
    for (const Vector3d& p : triangle) radius2 = std::max(radius2, (p - middle).squaredNorm());
    tree.visit_near(middle, radius2, [&](std::uint32_t item) {
      if (overlaps(cage, cage.tetrahedra[item], triangle)) inside[item].push_back(k);
      return radius2;
    });
  }
  return inside;
}

// Where a vertex of the cage belongs: the nearest place of the skin of the limb it lies deepest in, or else
// of the nearest limb.
class Sites {
 public:
  Sites(const TetMesh& cage, const SurfaceMesh& skin, const Limbs& limbs,
        const std::vector<std::vector<std::uint32_t>>& skin_in)
      : skin_(skin), normals_(skin.vertices.size(), Vector3d::Zero()) {
    // Weighted by angle, so that the sign of a distance is also right at edges and corners (Baerentzen and
    // Aanaes, 2005).
    for (const auto& t : skin.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector3d ab = (skin.vertices[t[(k + 1) % 3]] - skin.vertices[t[k]]).normalized();
        const Vector3d ac = (skin.vertices[t[(k + 2) % 3]] - skin.vertices[t[k]]).normalized();
        const Vector3d cross = ab.cross(ac);
        // (1 - cos)/sin is the tangent of half the angle: it grows with the angle and needs only + - * /
        // sqrt.
        if (cross.norm() > 0.0) normals_[t[k]] += cross.normalized() * (1.0 - ab.dot(ac));
      }
    turn_outward();
    std::vector<std::vector<std::uint32_t>> star(cage.vertices.size()), near(cage.vertices.size());
    for (std::uint32_t i = 0; i < cage.tetrahedra.size(); ++i)
      for (const std::uint32_t v : cage.tetrahedra[i]) {
        star[v].push_back(i);
        near[v].insert(near[v].end(), skin_in[i].begin(), skin_in[i].end());
      }
    for (auto& triangles : near) sort_out(triangles);
    of_vertex_.resize(cage.vertices.size());
    has_site_.resize(cage.vertices.size(), 0);
    for (std::size_t v = 0; v < near.size(); ++v) {
      if (near[v].empty()) continue;
      has_site_[v] = 1;
      if (choose(cage.vertices[v], near[v], limbs, of_vertex_[v]) <= 0.0) continue;
      // In front of all nearby skin: outside, or in a limb whose own skin is farther away than the skin of a
      // crossing limb.
      std::vector<std::uint32_t> around, wide;
      for (const std::uint32_t i : star[v])
        around.insert(around.end(), cage.tetrahedra[i].begin(), cage.tetrahedra[i].end());
      sort_out(around);
      for (const std::uint32_t other : around)
        wide.insert(wide.end(), near[other].begin(), near[other].end());
      sort_out(wide);
      choose(cage.vertices[v], wide, limbs, of_vertex_[v]);
    }
  }

  bool has(std::uint32_t vertex) const { return has_site_[vertex] != 0; }
  const SurfacePoint& operator[](std::uint32_t vertex) const { return of_vertex_[vertex]; }

  SurfacePoint nearest(const Vector3d& point, const std::vector<std::uint32_t>& triangles) const {
    SurfacePoint best;
    best.distance = std::numeric_limits<double>::infinity();
    for (const std::uint32_t k : triangles) {
      const auto& t = skin_.triangles[k];
      SurfacePoint found =
          nearest_on_triangle(point, skin_.vertices[t[0]], skin_.vertices[t[1]], skin_.vertices[t[2]]);
      found.triangle = k;
      if (found.distance < best.distance) best = found;
    }
    return best;
  }

 private:
  static void sort_out(std::vector<std::uint32_t>& numbers) {
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  }

  // Finds the place among the triangles; returns its signed distance.
  double choose(const Vector3d& point, const std::vector<std::uint32_t>& triangles, const Limbs& limbs,
                SurfacePoint& site) const {
    double deepest = std::numeric_limits<double>::infinity();
    for (const auto& group : limbs.groups_of(triangles)) {
      const SurfacePoint place = nearest(point, group);
      const double depth = signed_distance(point, place);
      if (!(depth < deepest)) continue;
      deepest = depth;
      site = place;
    }
    return deepest;
  }

  // In parts that face inward, the normals do too.
  void turn_outward() {
    Unions parts(skin_.vertices.size());
    for (const auto& t : skin_.triangles) {
      parts.join(t[0], t[1]);
      parts.join(t[1], t[2]);
    }
    std::vector<double> volume(skin_.vertices.size(), 0.0);
    for (const auto& t : skin_.triangles) {
      const std::uint32_t part = parts.find(t[0]);
      const Vector3d& origin = skin_.vertices[part];
      volume[part] += (skin_.vertices[t[0]] - origin)
                          .dot((skin_.vertices[t[1]] - origin).cross(skin_.vertices[t[2]] - origin));
    }
    for (std::uint32_t v = 0; v < normals_.size(); ++v)
      if (volume[parts.find(v)] < 0.0) normals_[v] = -normals_[v];
  }

  double signed_distance(const Vector3d& point, const SurfacePoint& place) const {
    const auto& t = skin_.triangles[place.triangle];
    Vector3d normal = Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) normal += place.weights[k] * normals_[t[k]].normalized();
    return (point - place.point).dot(normal) < 0.0 ? -place.distance : place.distance;
  }

  const SurfaceMesh& skin_;
  std::vector<Vector3d> normals_;
  std::vector<SurfacePoint> of_vertex_;
  std::vector<char> has_site_;
};

// One limb's copy of a tetrahedron.
struct Copy {
  std::uint32_t tetrahedron = 0;
  std::vector<std::uint32_t> skin;  // triangles of the skin
  std::array<bool, 4> own{};        // corners that lie in this limb
  bool is_dropped = false;
};

std::vector<Copy> copies_of(std::uint32_t index, const TetMesh& cage, const Limbs& limbs, const Sites& sites,
                            const std::vector<std::uint32_t>& skin_in) {
  std::vector<Copy> copies;
  for (auto& group : limbs.groups_of(skin_in)) copies.push_back({index, std::move(group), {}, false});
  const std::size_t with_skin = copies.size();
  std::vector<std::vector<std::uint32_t>> own_sites(copies.size());
  for (std::size_t k = 0; k < 4; ++k) {
    const std::uint32_t v = cage.tetrahedra[index][k];
    if (!sites.has(v)) continue;
    const std::array<std::uint32_t, 1> site{sites[v].triangle};
    std::size_t chosen = copies.size();
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < copies.size(); ++c) {
      const bool is_apart = std::any_of(own_sites[c].begin(), own_sites[c].end(),
                                        [&](std::uint32_t other) {
                                          return limbs.are_apart(site, std::array<std::uint32_t, 1>{other});
                                        }) ||
                            (c < with_skin && limbs.are_apart(site, copies[c].skin));
      if (is_apart) continue;
      const double distance = c < with_skin ? sites.nearest(cage.vertices[v], copies[c].skin).distance : 0.0;
      if (distance < nearest) {
        nearest = distance;
        chosen = c;
      }
    }
    if (chosen == copies.size()) {
      copies.push_back({index, {}, {}, false});
      own_sites.emplace_back();
    }
    own_sites[chosen].push_back(site[0]);
    copies[chosen].own[k] = true;
  }
  if (copies.empty()) copies.push_back({index, {}, {}, false});
  // Deep inside, with no skin nearby, there is nothing to decide.
  if (copies.size() == 1) copies[0].own = {true, true, true, true};
  return copies;
}

struct CageFace {
  std::array<std::uint32_t, 3> corners;  // ascending
  std::uint32_t tetrahedron;
};

std::vector<CageFace> sorted_faces(const std::vector<std::array<std::uint32_t, 4>>& tetrahedra) {
  std::vector<CageFace> faces;
  faces.reserve(4 * tetrahedra.size());
  for (std::uint32_t i = 0; i < tetrahedra.size(); ++i) {
    const auto& t = tetrahedra[i];
    for (std::size_t k = 0; k < 4; ++k) {
      CageFace face{{t[(k + 1) % 4], t[(k + 2) % 4], t[(k + 3) % 4]}, i};
      std::sort(face.corners.begin(), face.corners.end());
      faces.push_back(face);
    }
  }
  std::sort(faces.begin(), faces.end(), [](const CageFace& a, const CageFace& b) {
    return std::tie(a.corners, a.tetrahedron) < std::tie(b.corners, b.tetrahedron);
  });
  return faces;
}

std::size_t corner_of(const TetMesh& cage, std::uint32_t tetrahedron, std::uint32_t vertex) {
  const auto& t = cage.tetrahedra[tetrahedron];
  return static_cast<std::size_t>(std::find(t.begin(), t.end(), vertex) - t.begin());
}

// How much two copies on both sides of a face have in common: face vertices that lie in the limb of both, and
// skin.
std::size_t in_common(const TetMesh& cage, const Copy& a, const Copy& b,
                      const std::array<std::uint32_t, 3>& face) {
  std::size_t count = 0;
  for (const std::uint32_t v : face)
    if (a.own[corner_of(cage, a.tetrahedron, v)] && b.own[corner_of(cage, b.tetrahedron, v)]) count += 1000;
  for (const std::uint32_t t : a.skin) count += std::binary_search(b.skin.begin(), b.skin.end(), t) ? 1 : 0;
  return count;
}

// Joins corners of copies across a face, each copy to at most one: a face with three tetrahedra would not be
// a solid.
void join_across(const TetMesh& cage, const std::vector<Copy>& copies,
                 std::array<std::array<std::uint32_t, 2>, 2> sides, const std::array<std::uint32_t, 3>& face,
                 Unions& corners) {
  std::vector<std::tuple<std::size_t, std::uint32_t, std::uint32_t>> pairs;
  for (std::uint32_t a = sides[0][0]; a < sides[0][1]; ++a)
    for (std::uint32_t b = sides[1][0]; b < sides[1][1]; ++b)
      if (const std::size_t score = in_common(cage, copies[a], copies[b], face); score > 0)
        pairs.emplace_back(std::numeric_limits<std::size_t>::max() - score, a, b);
  std::sort(pairs.begin(), pairs.end());
  std::vector<std::uint32_t> taken;
  for (const auto& [score, a, b] : pairs) {
    if (std::find(taken.begin(), taken.end(), a) != taken.end() ||
        std::find(taken.begin(), taken.end(), b) != taken.end())
      continue;
    taken.insert(taken.end(), {a, b});
    for (const std::uint32_t v : face)
      corners.join(4 * a + static_cast<std::uint32_t>(corner_of(cage, copies[a].tetrahedron, v)),
                   4 * b + static_cast<std::uint32_t>(corner_of(cage, copies[b].tetrahedron, v)));
  }
}

// At the end of a cut, copies of a tetrahedron may come to share three corners, with no room between them.
// The first takes the others' skin, and the others are dropped.
void drop_twins(std::vector<Copy>& copies, const std::vector<std::uint32_t>& first, Unions& corners) {
  for (std::size_t i = 0; i + 1 < first.size(); ++i)
    for (std::uint32_t a = first[i]; a < first[i + 1]; ++a)
      for (std::uint32_t b = a + 1; b < first[i + 1]; ++b) {
        if (copies[a].is_dropped || copies[b].is_dropped) continue;
        int shared = 0;
        for (std::uint32_t k = 0; k < 4; ++k)
          shared += corners.find(4 * a + k) == corners.find(4 * b + k) ? 1 : 0;
        if (shared < 3) continue;
        copies[a].skin.insert(copies[a].skin.end(), copies[b].skin.begin(), copies[b].skin.end());
        copies[b].is_dropped = true;
      }
}

// A group of a few copies that no face joins to the rest of its limb would fall out of the body, or swing
// about the vertex or edge it hangs by. Its skin goes to the adjacent skin's tetrahedra.
void drop_crumbs(std::vector<Copy>& copies, const std::vector<std::uint32_t>& first, Unions& corners) {
  constexpr std::size_t most = 8;
  std::vector<std::uint32_t> kept;
  std::vector<std::array<std::uint32_t, 4>> tetrahedra;
  std::vector<std::size_t> weight;
  for (std::size_t i = 0; i + 1 < first.size(); ++i)
    for (std::uint32_t c = first[i]; c < first[i + 1]; ++c) {
      if (copies[c].is_dropped) continue;
      kept.push_back(c);
      tetrahedra.push_back(
          {corners.find(4 * c), corners.find(4 * c + 1), corners.find(4 * c + 2), corners.find(4 * c + 3)});
      // A solid that contains an uncut tetrahedron is not a crumb.
      weight.push_back(first[i + 1] - first[i] > 1 ? 1 : most + 1);
    }
  Unions solids(kept.size());
  const std::vector<CageFace> faces = sorted_faces(tetrahedra);
  for (std::size_t k = 1; k < faces.size(); ++k)
    if (faces[k].corners == faces[k - 1].corners) solids.join(faces[k].tetrahedron, faces[k - 1].tetrahedron);
  std::vector<std::size_t> size(kept.size(), 0);
  for (std::uint32_t i = 0; i < kept.size(); ++i) size[solids.find(i)] += weight[i];
  for (std::uint32_t i = 0; i < kept.size(); ++i)
    if (size[solids.find(i)] <= most) copies[kept[i]].is_dropped = true;
}

SkinPoint as_anchor(const SurfacePoint& place) {
  return {place.triangle, place.weights};
}

}  // namespace

CutMesh cut_limbs(const TetMesh& cage, const SurfaceMesh& skin, const Limbs& limbs) {
  const auto skin_in = skin_in_tetrahedra(cage, skin);
  const Sites sites(cage, skin, limbs, skin_in);
  std::vector<Copy> copies;
  std::vector<std::uint32_t> first{0};  // copies of tetrahedron i: [first[i], first[i + 1])
  CutMesh cut;
  for (std::uint32_t i = 0; i < cage.tetrahedra.size(); ++i) {
    for (Copy& copy : copies_of(i, cage, limbs, sites, skin_in[i])) copies.push_back(std::move(copy));
    cut.cut_tetrahedra += copies.size() - first.back() > 1 ? 1u : 0u;
    first.push_back(static_cast<std::uint32_t>(copies.size()));
  }

  Unions corners(4 * copies.size());
  const std::vector<CageFace> faces = sorted_faces(cage.tetrahedra);
  for (std::size_t k = 1; k < faces.size(); ++k) {
    if (faces[k].corners != faces[k - 1].corners) continue;
    const std::uint32_t a = faces[k - 1].tetrahedron, b = faces[k].tetrahedron;
    join_across(cage, copies, {{{first[a], first[a + 1]}, {first[b], first[b + 1]}}}, faces[k].corners,
                corners);
  }
  // A vertex that lies in a limb is one vertex in all of that limb's copies, whether or not they share faces.
  std::vector<std::uint32_t> owner(cage.vertices.size(), none);
  for (std::uint32_t c = 0; c < copies.size(); ++c)
    for (std::uint32_t k = 0; k < 4; ++k) {
      if (!copies[c].own[k]) continue;
      std::uint32_t& corner = owner[cage.tetrahedra[copies[c].tetrahedron][k]];
      if (corner == none) corner = 4 * c + k;
      corners.join(corner, 4 * c + k);
    }

  drop_twins(copies, first, corners);
  drop_crumbs(copies, first, corners);

  std::vector<std::uint32_t> number(4 * copies.size(), none);
  std::vector<std::vector<std::uint32_t>> skin_at;  // of vertices that no limb owns: skin of their copies
  const SurfaceSearch search(skin);
  std::vector<char> is_used(4 * copies.size(), 0);
  for (std::uint32_t c = 0; c < copies.size(); ++c)
    for (std::uint32_t k = 0; k < 4 && !copies[c].is_dropped; ++k) is_used[corners.find(4 * c + k)] = 1;
  // Owned vertices come first, in the cage's order, so that a cage without cuts keeps its numbers.
  for (std::uint32_t v = 0; v < cage.vertices.size(); ++v) {
    if (owner[v] == none || !is_used[corners.find(owner[v])]) continue;
    if (number[corners.find(owner[v])] != none) continue;
    number[corners.find(owner[v])] = static_cast<std::uint32_t>(cut.mesh.vertices.size());
    cut.mesh.vertices.push_back(cage.vertices[v]);
    cut.anchor.push_back(as_anchor(sites.has(v) ? sites[v] : search.nearest(cage.vertices[v])));
  }
  const std::size_t own_count = cut.mesh.vertices.size();
  std::vector<std::vector<std::uint32_t>> holders(skin.vertices.size());
  for (std::uint32_t c = 0; c < copies.size(); ++c) {
    if (copies[c].is_dropped) continue;
    const auto tetrahedron = static_cast<std::uint32_t>(cut.mesh.tetrahedra.size());
    const auto& t = cage.tetrahedra[copies[c].tetrahedron];
    std::array<std::uint32_t, 4> made{};
    for (std::uint32_t k = 0; k < 4; ++k) {
      std::uint32_t& vertex = number[corners.find(4 * c + k)];
      if (vertex == none) {
        vertex = static_cast<std::uint32_t>(cut.mesh.vertices.size());
        cut.mesh.vertices.push_back(cage.vertices[t[k]]);
        skin_at.emplace_back();
      }
      made[k] = vertex;
      if (vertex < own_count) continue;
      auto& skin_here = skin_at[vertex - own_count];
      skin_here.insert(skin_here.end(), copies[c].skin.begin(), copies[c].skin.end());
      for (std::uint32_t j = 0; j < 4; ++j)
        if (copies[c].own[j] && sites.has(t[j])) skin_here.push_back(sites[t[j]].triangle);
    }
    for (const std::uint32_t s : copies[c].skin)
      for (const std::uint32_t v : skin.triangles[s])
        if (holders[v].empty() || holders[v].back() != tetrahedron) holders[v].push_back(tetrahedron);
    cut.mesh.tetrahedra.push_back(made);
  }
  for (std::size_t i = 0; i < skin_at.size(); ++i) {
    const Vector3d& place = cut.mesh.vertices[own_count + i];
    cut.anchor.push_back(
        as_anchor(skin_at[i].empty() ? search.nearest(place) : sites.nearest(place, skin_at[i])));
  }
  cut.holder_offset.push_back(0);
  for (const auto& list : holders) {
    cut.holder.insert(cut.holder.end(), list.begin(), list.end());
    cut.holder_offset.push_back(static_cast<std::uint32_t>(cut.holder.size()));
  }
  return cut;
}

}  // namespace fascicle::build
