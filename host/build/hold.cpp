#include "host/build/hold.h"

#include <algorithm>
#include <array>
#include <limits>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>

#include "host/build/embedding.h"
#include "host/build/mass.h"
#include "host/build/smooth.h"
#include "host/build/surface_search.h"

namespace fascicle::build {

namespace {

using mesh::SurfaceMesh;
using mesh::TetMesh;
using scene::Vector3d;

constexpr std::uint32_t no_neighbour = std::numeric_limits<std::uint32_t>::max();
constexpr int most_passes = 12;
constexpr int most_hold_halvings = 6;
constexpr int most_rounds = 40;
// Faces are moved slightly too far, so that the rounds end.
constexpr double overshoot = 1.05;
constexpr double least_volume_left = 0.05;

// The tetrahedron opposite each corner, or none.
std::vector<std::array<std::uint32_t, 4>> neighbours(const TetMesh& mesh) {
  struct OwnFace {
    std::array<std::uint32_t, 3> corners;
    std::uint32_t tetrahedron, corner;
  };
  std::vector<OwnFace> faces;
  faces.reserve(4 * mesh.tetrahedra.size());
  for (std::uint32_t i = 0; i < mesh.tetrahedra.size(); ++i)
    for (std::uint32_t k = 0; k < 4; ++k) {
      const auto& t = mesh.tetrahedra[i];
      OwnFace face{{t[(k + 1) % 4], t[(k + 2) % 4], t[(k + 3) % 4]}, i, k};
      std::sort(face.corners.begin(), face.corners.end());
      faces.push_back(face);
    }
  std::sort(faces.begin(), faces.end(), [](const OwnFace& a, const OwnFace& b) {
    return std::tie(a.corners, a.tetrahedron) < std::tie(b.corners, b.tetrahedron);
  });
  std::vector<std::array<std::uint32_t, 4>> across(mesh.tetrahedra.size(),
                                                   {no_neighbour, no_neighbour, no_neighbour, no_neighbour});
  for (std::size_t k = 1; k < faces.size(); ++k) {
    const OwnFace &a = faces[k - 1], &b = faces[k];
    if (a.corners != b.corners) continue;
    across[a.tetrahedron][a.corner] = b.tetrahedron;
    across[b.tetrahedron][b.corner] = a.tetrahedron;
  }
  return across;
}

double least_of(const std::array<double, 4>& weights) {
  return *std::min_element(weights.begin(), weights.end());
}

class Holder {
 public:
  Holder(CutMesh& cage, const SurfaceMesh& skin, double farthest, const std::vector<char>& fixed)
      : mesh_(cage.mesh),
        fixed_(fixed),
        cage_(cage),
        skin_(skin),
        farthest_(farthest),
        start_(cage.mesh.vertices),
        across_(neighbours(cage.mesh)),
        touching_(cage.mesh.vertices.size()) {
    for (std::uint32_t i = 0; i < mesh_.tetrahedra.size(); ++i) {
      smallest_.push_back(least_volume_left * signed_volume(mesh_, mesh_.tetrahedra[i]));
      for (const std::uint32_t v : mesh_.tetrahedra[i]) touching_[v].push_back(i);
    }
    choose_candidates();
  }

  Hold run() {
    Hold hold = find_homes();
    for (int pass = 0; pass < most_passes && hold.least < 0.0; ++pass) {
      std::vector<std::uint32_t> outside;
      for (std::uint32_t v = 0; v < skin_.vertices.size(); ++v)
        if (hold.coordinate[v] < 0.0) outside.push_back(v);
      for (int round = 0; round < most_rounds && !outside.empty(); ++round) {
        bool has_moved = false;
        for (const std::uint32_t v : outside) has_moved |= make_room(v);
        if (!has_moved) break;
        std::erase_if(outside, [&](std::uint32_t v) { return best_home(v).second >= 0.0; });
      }
      hold = find_homes();
    }
    smooth_inside(mesh_, fixed_);
    return find_homes();
  }

 private:
  // Skin that no tetrahedron contains takes the candidates of adjacent skin, so that it stays with its limb.
  void choose_candidates() {
    candidates_.resize(skin_.vertices.size());
    around_.resize(skin_.vertices.size());
    std::vector<std::vector<std::uint32_t>> beside(skin_.vertices.size());
    for (const auto& t : skin_.triangles)
      for (std::size_t k = 0; k < 3; ++k)
        beside[t[k]].insert(beside[t[k]].end(), {t[(k + 1) % 3], t[(k + 2) % 3]});
    std::vector<std::uint32_t> reached;
    for (std::uint32_t v = 0; v < skin_.vertices.size(); ++v) {
      candidates_[v].assign(cage_.holder.begin() + cage_.holder_offset[v],
                            cage_.holder.begin() + cage_.holder_offset[v + 1]);
      if (!candidates_[v].empty()) reached.push_back(v);
    }
    for (std::size_t k = 0; k < reached.size(); ++k)
      for (const std::uint32_t next : beside[reached[k]])
        if (candidates_[next].empty()) {
          candidates_[next] = candidates_[reached[k]];
          reached.push_back(next);
        }
    // Parts of the skin that lie entirely outside.
    for (std::uint32_t v = 0; v < skin_.vertices.size(); ++v)
      if (candidates_[v].empty()) candidates_[v].push_back(nearest_tetrahedron(skin_.vertices[v]));
  }

  std::uint32_t nearest_tetrahedron(const Vector3d& point) const {
    std::uint32_t nearest = 0;
    double nearest2 = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < mesh_.tetrahedra.size(); ++i) {
      Vector3d middle = Vector3d::Zero();
      for (const std::uint32_t v : mesh_.tetrahedra[i]) middle += mesh_.vertices[v] / 4.0;
      const double distance2 = (middle - point).squaredNorm();
      if (distance2 < nearest2) {
        nearest2 = distance2;
        nearest = i;
      }
    }
    return nearest;
  }

  // A vertex's candidates and all tetrahedra that touch them.
  const std::vector<std::uint32_t>& around(std::uint32_t vertex) {
    std::vector<std::uint32_t>& wide = around_[vertex];
    if (!wide.empty()) return wide;
    for (const std::uint32_t i : candidates_[vertex])
      for (const std::uint32_t v : mesh_.tetrahedra[i])
        wide.insert(wide.end(), touching_[v].begin(), touching_[v].end());
    std::sort(wide.begin(), wide.end());
    wide.erase(std::unique(wide.begin(), wide.end()), wide.end());
    return wide;
  }

  using Home = std::pair<std::uint32_t, double>;  // a tetrahedron, and the least coordinate in it

  Home best_of(const std::vector<std::uint32_t>& tetrahedra, const Vector3d& point) const {
    Home best{0, -std::numeric_limits<double>::infinity()};
    for (const std::uint32_t i : tetrahedra) {
      const double least = least_of(barycentric(mesh_, mesh_.tetrahedra[i], point));
      if (least > best.second) best = {i, least};
    }
    return best;
  }

  Home best_home(std::uint32_t v) {
    const Home best = best_of(candidates_[v], skin_.vertices[v]);
    return best.second >= 0.0 ? best : best_of(around(v), skin_.vertices[v]);
  }

  Hold find_homes() {
    Hold hold;
    hold.least = std::numeric_limits<double>::infinity();
    for (std::uint32_t v = 0; v < skin_.vertices.size(); ++v) {
      const auto [home, least] = best_home(v);
      hold.home.push_back(home);
      hold.coordinate.push_back(least);
      hold.least = std::min(hold.least, least);
    }
    return hold;
  }

  // Moves the nearest boundary face that has skin vertex `v` on its outer side over that vertex.
  bool make_room(std::uint32_t v) {
    const Vector3d& point = skin_.vertices[v];
    SurfacePoint nearest;
    nearest.distance = std::numeric_limits<double>::infinity();
    std::array<std::uint32_t, 3> chosen{};
    for (const std::uint32_t i : around(v)) {
      const auto& t = mesh_.tetrahedra[i];
      for (std::size_t k = 0; k < 4; ++k) {
        if (across_[i][k] != no_neighbour) continue;
        const std::array<std::uint32_t, 3> face{t[(k + 1) % 4], t[(k + 2) % 4], t[(k + 3) % 4]};
        const SurfacePoint place = nearest_on_triangle(point, mesh_.vertices[face[0]],
                                                       mesh_.vertices[face[1]], mesh_.vertices[face[2]]);
        if (!(place.distance < nearest.distance)) continue;
        const Vector3d& a = mesh_.vertices[face[0]];
        const Vector3d normal = (mesh_.vertices[face[1]] - a).cross(mesh_.vertices[face[2]] - a);
        if (normal.dot(point - a) * normal.dot(mesh_.vertices[t[k]] - a) >= 0.0) continue;
        nearest = place;
        chosen = face;
      }
    }
    if (!(nearest.distance < std::numeric_limits<double>::infinity())) return false;
    const Vector3d way = overshoot * (point - nearest.point);
    double sum2 = 0.0;
    for (const double w : nearest.weights) sum2 += w * w;
    bool has_moved = false;
    for (std::size_t k = 0; k < 3; ++k)
      if (nearest.weights[k] > 0.0) has_moved |= move(chosen[k], way * (nearest.weights[k] / sum2));
    return has_moved;
  }

  // Takes as much of a step as the adjacent tetrahedra allow.
  bool move(std::uint32_t vertex, Vector3d step) {
    for (int k = 0; k < most_hold_halvings; ++k, step /= 2.0)
      if (move_whole(vertex, step)) return true;
    return false;
  }

  bool move_whole(std::uint32_t vertex, const Vector3d& step) {
    const Vector3d before = mesh_.vertices[vertex];
    Vector3d way = before + step - start_[vertex];
    if (way.norm() > farthest_) way *= farthest_ / way.norm();
    mesh_.vertices[vertex] = start_[vertex] + way;
    for (const std::uint32_t i : touching_[vertex])
      if (signed_volume(mesh_, mesh_.tetrahedra[i]) < smallest_[i]) {
        mesh_.vertices[vertex] = before;
        return false;
      }
    return true;
  }

  TetMesh& mesh_;
  const std::vector<char>& fixed_;
  const CutMesh& cage_;
  const SurfaceMesh& skin_;
  double farthest_;
  std::vector<Vector3d> start_;
  std::vector<std::array<std::uint32_t, 4>> across_;
  std::vector<std::vector<std::uint32_t>> touching_;  // tetrahedra of each vertex
  std::vector<double> smallest_;                      // the volume that each may shrink to
  std::vector<std::vector<std::uint32_t>> candidates_, around_;
};

}  // namespace

Hold hold_skin(CutMesh& cage, const SurfaceMesh& skin, double farthest, const std::vector<char>& fixed) {
  return Holder(cage, skin, farthest, fixed).run();
}

}  // namespace fascicle::build
