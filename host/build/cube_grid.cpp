#include "host/build/cube_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/parallel.h"

namespace fascicle::build {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Place = std::array<std::uint32_t, 3>;
using CornerValues = std::array<double, 8>;

constexpr std::uint32_t no_cube = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t cubes_a_piece = 64;

constexpr std::size_t entry(std::size_t row, std::size_t column) {
  return row * (row + 1) / 2 + column;
}

bool by_place(const Place& a, const Place& b) {
  return std::array{a[2], a[1], a[0]} < std::array{b[2], b[1], b[0]};
}

std::uint32_t number_of(const std::vector<Place>& sorted, const Place& place) {
  return static_cast<std::uint32_t>(std::lower_bound(sorted.begin(), sorted.end(), place, by_place) -
                                    sorted.begin());
}

void sort_places(std::vector<Place>& places) {
  std::sort(places.begin(), places.end(), by_place);
  places.erase(std::unique(places.begin(), places.end()), places.end());
}

Place corner_place(const Place& cube, std::uint32_t c) {
  return {cube[0] + (c & 1u), cube[1] + (c >> 1 & 1u), cube[2] + (c >> 2)};
}

void number_nodes(CubeGrid& grid) {
  std::vector<Place> nodes;
  nodes.reserve(8 * grid.place.size());
  for (const Place& cube : grid.place)
    for (std::uint32_t c = 0; c < 8; ++c) nodes.push_back(corner_place(cube, c));
  sort_places(nodes);
  grid.node.resize(nodes.size());
  grid.corner.resize(grid.place.size());
  for (std::uint32_t k = 0; k < grid.place.size(); ++k)
    for (std::uint32_t c = 0; c < 8; ++c) {
      grid.corner[k][c] = number_of(nodes, corner_place(grid.place[k], c));
      grid.node[grid.corner[k][c]] = {k, c};
    }
}

Vector3d as_vector(const Place& place) {
  return {static_cast<double>(place[0]), static_cast<double>(place[1]), static_cast<double>(place[2])};
}

// At a point in the cube's own coordinates; it may lie outside.
CornerValues corner_values(const Vector3d& at) {
  CornerValues values;
  for (std::size_t c = 0; c < 8; ++c)
    values[c] = ((c & 1u) != 0 ? at[0] : 1.0 - at[0]) * ((c & 2u) != 0 ? at[1] : 1.0 - at[1]) *
                ((c & 4u) != 0 ? at[2] : 1.0 - at[2]);
  return values;
}

Vector3d in_cube(const CubeGrid& grid, std::size_t cube, const Vector3d& point) {
  return (point - grid.origin) / grid.size - as_vector(grid.place[cube]);
}

// The matrix M with M b = a x b.
Matrix3d cross_matrix(const Vector3d& a) {
  Matrix3d m;
  m << 0.0, -a[2], a[1], a[2], 0.0, -a[0], -a[1], a[0], 0.0;
  return m;
}

// x.K x = sum w |x_i|^2 - |sum w x_i|^2 / W - t.J^-1 t, t = sum w r_i x x_i, with x_i interpolated from the
// corners.
void add_region(const RegionStiffness& body, const CubeGrid& grid, std::size_t cube, std::size_t r,
                CubeStiffness& stiffness) {
  CubeMass squares{};
  CornerValues first{};
  std::array<Vector3d, 8> lever;
  lever.fill(Vector3d::Zero());
  body.for_each_member(r, [&](std::size_t i, double w, const Vector3d& p) {
    if (!body.is_free()[i]) return;
    const CornerValues values = corner_values(in_cube(grid, cube, body.rest(i)));
    for (std::size_t a = 0; a < 8; ++a) {
      const double share = w * values[a];
      first[a] += share;
      lever[a] += share * p;
      for (std::size_t b = 0; b <= a; ++b) squares[entry(a, b)] += share * values[b];
    }
  });
  std::array<Matrix3d, 8> turn;  // J^-1 times the corner's part of t
  for (std::size_t b = 0; b < 8; ++b) {
    const Matrix3d part = cross_matrix(lever[b]);
    for (int c = 0; c < 3; ++c) turn[b].col(c) = solve_symmetric(body.inertia(r), part.col(c));
  }
  for (std::size_t a = 0; a < 8; ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      const double along = squares[entry(a, b)] - first[a] * first[b] / body.weight(r);
      for (int c = 0; c < 3; ++c) {
        const Vector3d turned = turn[b].col(c);
        const Vector3d back(lever[a][1] * turned[2] - lever[a][2] * turned[1],
                            lever[a][2] * turned[0] - lever[a][0] * turned[2],
                            lever[a][0] * turned[1] - lever[a][1] * turned[0]);
        const std::size_t column = 3 * b + static_cast<std::size_t>(c);
        for (std::size_t row = std::max(3 * a, column); row < 3 * a + 3; ++row)
          stiffness[entry(row, column)] +=
              back[static_cast<int>(row - 3 * a)] + (row - 3 * a == column - 3 * b ? along : 0.0);
      }
    }
}

// The values at a cube's corners, interpolated from the corners of its parent, a cube twice as large.
CornerValues corner_by_parent(const Place& child, std::uint32_t c) {
  return corner_values(as_vector(corner_place({child[0] & 1u, child[1] & 1u, child[2] & 1u}, c)) / 2.0);
}

std::array<CornerValues, 8> corners_by_parent(const Place& child) {
  std::array<CornerValues, 8> values;
  for (std::uint32_t c = 0; c < 8; ++c) values[c] = corner_by_parent(child, c);
  return values;
}

Place parent_place(const Place& child) {
  return {child[0] / 2, child[1] / 2, child[2] / 2};
}

void add_child(const std::array<CornerValues, 8>& values, const CubeStiffness& child, CubeStiffness& parent) {
  const auto of_child = [&](std::size_t row, std::size_t column) {
    return row >= column ? child[entry(row, column)] : child[entry(column, row)];
  };
  for (std::size_t a = 0; a < 8; ++a)
    for (std::size_t b = 0; b < 8; ++b) {
      for (std::size_t A = 0; A < 8; ++A)
        for (std::size_t B = 0; B <= A; ++B) {
          const double factor = values[a][A] * values[b][B];
          if (factor == 0.0) continue;
          for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t d = 0; d < (A == B ? c + 1 : 3); ++d)
              parent[entry(3 * A + c, 3 * B + d)] += factor * of_child(3 * a + c, 3 * b + d);
        }
    }
}

void add_child_mass(const std::array<CornerValues, 8>& values, const CubeMass& child, CubeMass& parent) {
  for (std::size_t a = 0; a < 8; ++a)
    for (std::size_t b = 0; b < 8; ++b)
      for (std::size_t A = 0; A < 8; ++A)
        for (std::size_t B = 0; B <= A; ++B)
          parent[entry(A, B)] +=
              values[a][A] * values[b][B] * (a >= b ? child[entry(a, b)] : child[entry(b, a)]);
}

template <class Visit>
void for_each_link(const CubeGrid& coarse, const CubeGrid& fine, Visit visit) {
  for (std::size_t node = 0; node < fine.node.size(); ++node) {
    const auto [cube, corner] = fine.node[node];
    const CornerValues values = corner_by_parent(fine.place[cube], corner);
    const auto& parents = coarse.corner[fine.parent[cube]];
    for (std::size_t a = 0; a < 8; ++a)
      if (values[a] != 0.0) visit(node, parents[a], values[a]);
  }
}

// A fixed number, so that sums over the pieces do not depend on the number of threads.
constexpr std::size_t body_pieces = 8;

template <class Visit>
void for_each_free(const BodyGrid& grid, const RegionStiffness& body, std::size_t piece, Visit visit) {
  for (std::size_t i = body.size() * piece / body_pieces; i < body.size() * (piece + 1) / body_pieces; ++i) {
    if (!body.is_free()[i]) continue;
    const std::uint32_t cube = grid.cube_of[i];
    visit(i, grid.grid.corner[cube], corner_values(in_cube(grid.grid, cube, body.rest(i))));
  }
}

}  // namespace

BodyGrid grid_of_body(const RegionStiffness& body, double size) {
  const std::size_t n = body.size();
  BodyGrid result;
  CubeGrid& grid = result.grid;
  grid.size = size;
  grid.origin = body.rest(0);
  for (std::size_t i = 0; i < n; ++i) grid.origin = grid.origin.cwiseMin(body.rest(i));
  const auto place_of = [&](std::size_t i) {
    const Vector3d at = (body.rest(i) - grid.origin) / size;
    return Place{static_cast<std::uint32_t>(at[0]), static_cast<std::uint32_t>(at[1]),
                 static_cast<std::uint32_t>(at[2])};
  };
  for (std::size_t r = 0; r < n; ++r) {
    if (!body.touches_free(r)) continue;
    const Place place = place_of(r);
    if (grid.place.empty() || grid.place.back() != place) grid.place.push_back(place);
  }
  sort_places(grid.place);
  number_nodes(grid);

  const std::size_t cubes = grid.place.size();
  std::vector<std::uint32_t> begin(cubes + 1, 0);
  result.cube_of.assign(n, no_cube);
  for (std::size_t r = 0; r < n; ++r)
    if (body.touches_free(r)) ++begin[1 + (result.cube_of[r] = number_of(grid.place, place_of(r)))];
  for (std::size_t k = 0; k < cubes; ++k) begin[k + 1] += begin[k];
  std::vector<std::uint32_t> regions(begin.back()), next(begin.begin(), begin.end() - 1);
  for (std::uint32_t r = 0; r < n; ++r)
    if (result.cube_of[r] != no_cube) regions[next[result.cube_of[r]]++] = r;

  grid.stiffness.assign(cubes, CubeStiffness{});
  grid.mass.assign(cubes, CubeMass{});
  base::for_each_in_parallel((cubes + cubes_a_piece - 1) / cubes_a_piece, body.threads(),
                             [&](std::size_t piece, std::size_t) {
                               const std::size_t end = std::min(cubes, (piece + 1) * cubes_a_piece);
                               for (std::size_t k = piece * cubes_a_piece; k < end; ++k)
                                 for (std::uint32_t e = begin[k]; e < begin[k + 1]; ++e) {
                                   const std::uint32_t r = regions[e];
                                   add_region(body, grid, k, r, grid.stiffness[k]);
                                   if (!body.is_free()[r]) continue;
                                   const CornerValues values = corner_values(in_cube(grid, k, body.rest(r)));
                                   for (std::size_t a = 0; a < 8; ++a)
                                     for (std::size_t b = 0; b <= a; ++b)
                                       grid.mass[k][entry(a, b)] += body.mass(r) * values[a] * values[b];
                                 }
                             });
  return result;
}

CubeGrid coarser_grid(CubeGrid& fine) {
  CubeGrid grid;
  grid.size = 2.0 * fine.size;
  grid.origin = fine.origin;
  for (const Place& child : fine.place) grid.place.push_back(parent_place(child));
  sort_places(grid.place);
  number_nodes(grid);
  grid.stiffness.assign(grid.place.size(), CubeStiffness{});
  grid.mass.assign(grid.place.size(), CubeMass{});
  for (std::size_t k = 0; k < fine.place.size(); ++k) {
    const std::uint32_t parent = number_of(grid.place, parent_place(fine.place[k]));
    fine.parent.push_back(parent);
    const std::array<CornerValues, 8> values = corners_by_parent(fine.place[k]);
    add_child(values, fine.stiffness[k], grid.stiffness[parent]);
    add_child_mass(values, fine.mass[k], grid.mass[parent]);
  }
  return grid;
}

std::vector<Vector3d> on_finer_grid(const CubeGrid& coarse, const CubeGrid& fine,
                                    const std::vector<Vector3d>& x) {
  std::vector<Vector3d> result(fine.node.size(), Vector3d::Zero());
  for_each_link(coarse, fine, [&](std::size_t node, std::uint32_t parent_node, double share) {
    result[node] += share * x[parent_node];
  });
  return result;
}

std::vector<Vector3d> onto_coarser_grid(const CubeGrid& coarse, const CubeGrid& fine,
                                        const std::vector<Vector3d>& f) {
  std::vector<Vector3d> result(coarse.node.size(), Vector3d::Zero());
  for_each_link(coarse, fine, [&](std::size_t node, std::uint32_t parent_node, double share) {
    result[parent_node] += share * f[node];
  });
  return result;
}

void add_on_body(const BodyGrid& grid, const RegionStiffness& body, const std::vector<Vector3d>& on_grid,
                 std::vector<Vector3d>& x) {
  base::for_each_in_parallel(body_pieces, body.threads(), [&](std::size_t piece, std::size_t) {
    for_each_free(grid, body, piece, [&](std::size_t i, const auto& corners, const CornerValues& values) {
      for (std::size_t a = 0; a < 8; ++a) x[i] += values[a] * on_grid[corners[a]];
    });
  });
}

std::vector<Vector3d> onto_grid(const BodyGrid& grid, const RegionStiffness& body,
                                const std::vector<Vector3d>& f) {
  std::array<std::vector<Vector3d>, body_pieces> parts;
  base::for_each_in_parallel(body_pieces, body.threads(), [&](std::size_t piece, std::size_t) {
    parts[piece].assign(grid.grid.node.size(), Vector3d::Zero());
    for_each_free(grid, body, piece, [&](std::size_t i, const auto& corners, const CornerValues& values) {
      for (std::size_t a = 0; a < 8; ++a) parts[piece][corners[a]] += values[a] * f[i];
    });
  });
  for (std::size_t piece = 1; piece < body_pieces; ++piece)
    for (std::size_t k = 0; k < parts[0].size(); ++k) parts[0][k] += parts[piece][k];
  return std::move(parts[0]);
}

}  // namespace fascicle::build
