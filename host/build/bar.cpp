#include "host/build/bar.h"

#include <cmath>
#include <limits>

#include "host/build/check_mesh.h"
#include "host/build/mass.h"
#include "host/build/message.h"

namespace fascicle::build {

namespace {

using scene::Vector3d;

// Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
struct SplitMix64 {
  std::uint64_t state;

  std::uint64_t next() {
    state += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  // Uniform in [-1, 1), a multiple of 2^-52.
  double symmetric() { return static_cast<double>(next() >> 11) * 0x1p-52 - 1.0; }
};

// The six axis orders of a path from a cell's corner to the opposite one. Each path is a tetrahedron; odd
// orders give a mirrored one, so their last two corners are swapped.
struct KuhnPath {
  std::array<int, 3> axes;
  bool odd;
};
constexpr std::array<KuhnPath, 6> kuhn_paths{{{{0, 1, 2}, false},
                                              {{1, 2, 0}, false},
                                              {{2, 0, 1}, false},
                                              {{0, 2, 1}, true},
                                              {{2, 1, 0}, true},
                                              {{1, 0, 2}, true}}};

// A tetrahedron keeps at least this share of its volume under jitter.
constexpr double least_volume_ratio = 0.1;

void check_bar(const scene::Bar& bar, const std::string& source) {
  double vertices = bar.count;
  if (bar.count == 0) fail(source, "bar: count: must be at least 1");
  if (!(bar.gap >= 0.0) || !std::isfinite(bar.gap)) fail(source, "bar: gap: must not be below 0");
  for (int a = 0; a < 3; ++a) {
    const std::uint32_t n = bar.vertices[static_cast<std::size_t>(a)];
    if (n < 2) fail(source, "bar: vertices: must be at least 2 along each axis, not " + std::to_string(n));
    if (!(bar.size[a] > 0.0) || !std::isfinite(bar.size[a]))
      fail(source, "bar: size: must be above 0 along each axis");
    vertices *= n;
  }
  // Six tetrahedra per cell with four corners each must be countable in 32 bits.
  if (vertices > 1.7e8)
    fail(source, "bar: vertices: " + std::to_string(static_cast<std::uint64_t>(vertices)) +
                     " vertices are too many to index; use a coarser bar");
  if (!(bar.jitter >= 0.0 && bar.jitter <= 0.3)) fail(source, "bar: jitter: must lie in [0, 0.3]");
}

// Displacements shrink only at vertices of squashed tetrahedra, and zero displacement squashes none, so this
// terminates.
void apply_jitter(mesh::TetMesh& mesh, std::vector<Vector3d> displacement, double whole_volume) {
  const std::vector<Vector3d> grid = mesh.vertices;
  std::vector<char> halve(grid.size());
  for (int round = 0; round < 64; ++round) {
    for (std::size_t i = 0; i < grid.size(); ++i) mesh.vertices[i] = grid[i] + displacement[i];
    std::fill(halve.begin(), halve.end(), char{0});
    bool squashed = false;
    for (const auto& t : mesh.tetrahedra) {
      if (signed_volume(mesh, t) >= least_volume_ratio * whole_volume) continue;
      squashed = true;
      for (const std::uint32_t corner : t) halve[corner] = 1;
    }
    if (!squashed) return;
    for (std::size_t i = 0; i < grid.size(); ++i)
      if (halve[i]) displacement[i] *= 0.5;
  }
  mesh.vertices = grid;
}

// Adds further copies, each `step` above the one before.
void repeat_upwards(mesh::TetMesh& mesh, std::uint32_t count, double step) {
  const std::size_t vertices = mesh.vertices.size(), tetrahedra = mesh.tetrahedra.size();
  for (std::uint32_t k = 1; k < count; ++k) {
    for (std::size_t i = 0; i < vertices; ++i)
      mesh.vertices.emplace_back(mesh.vertices[i] + Vector3d(0.0, k * step, 0.0));
    for (std::size_t t = 0; t < tetrahedra; ++t) {
      std::array<std::uint32_t, 4> corners = mesh.tetrahedra[t];
      for (std::uint32_t& corner : corners) corner += static_cast<std::uint32_t>(k * vertices);
      mesh.tetrahedra.push_back(corners);
    }
  }
}

}  // namespace

mesh::TetMesh make_bar(const scene::Bar& bar, const std::string& source) {
  check_bar(bar, source);
  const auto [nx, ny, nz] = bar.vertices;
  const std::array<std::uint32_t, 3> stride{ny * nz, nz, 1};
  const Vector3d spacing(bar.size[0] / (nx - 1), bar.size[1] / (ny - 1), bar.size[2] / (nz - 1));

  mesh::TetMesh mesh;
  mesh.vertices.reserve(std::size_t{nx} * ny * nz);
  std::vector<Vector3d> displacement;
  SplitMix64 random{bar.seed};
  for (std::uint32_t x = 0; x < nx; ++x)
    for (std::uint32_t y = 0; y < ny; ++y)
      for (std::uint32_t z = 0; z < nz; ++z) {
        // The far faces lie exactly at `size`, however the spacing rounds.
        mesh.vertices.emplace_back(x + 1 == nx ? bar.size[0] : x * spacing[0],
                                   y + 1 == ny ? bar.size[1] : y * spacing[1],
                                   z + 1 == nz ? bar.size[2] : z * spacing[2]);
        if (bar.jitter == 0.0) continue;
        const bool inside = x > 0 && x + 1 < nx && y > 0 && y + 1 < ny && z > 0 && z + 1 < nz;
        Vector3d d = Vector3d::Zero();
        for (int a = 0; inside && a < 3; ++a) d[a] = bar.jitter * spacing[a] * random.symmetric();
        displacement.push_back(d);
      }

  mesh.tetrahedra.reserve(std::size_t{6} * (nx - 1) * (ny - 1) * (nz - 1));
  for (std::uint32_t x = 0; x + 1 < nx; ++x)
    for (std::uint32_t y = 0; y + 1 < ny; ++y)
      for (std::uint32_t z = 0; z + 1 < nz; ++z)
        for (const KuhnPath& path : kuhn_paths) {
          std::array<std::uint32_t, 4> t{};
          t[0] = x * stride[0] + y * stride[1] + z * stride[2];
          for (std::size_t k = 0; k < 3; ++k)
            t[k + 1] = t[k] + stride[static_cast<std::size_t>(path.axes[k])];
          if (path.odd) std::swap(t[2], t[3]);
          mesh.tetrahedra.push_back(t);
        }

  if (!tetrahedra_without_volume(mesh).empty())
    fail(source,
         "bar: size: its cells have no measurable volume; make its thin sides longer, or give them fewer "
         "vertices");
  if (bar.jitter > 0.0)
    apply_jitter(mesh, std::move(displacement), spacing[0] * spacing[1] * spacing[2] / 6.0);
  repeat_upwards(mesh, bar.count, bar.size[1] + bar.gap);
  return mesh;
}

}  // namespace fascicle::build
