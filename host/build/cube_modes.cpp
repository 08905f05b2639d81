// Finds modes from noise on a coarse grid and refines them on finer grids, each starting from the coarser
// result: Bornemann and Deuflhard's cascade.
#include "host/build/cube_modes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "host/build/cube_grid.h"
#include "host/build/rayleigh.h"

namespace fascicle::build {

namespace {

using Eigen::Vector3d;
using Field = std::vector<Vector3d>;

// Cube size for the body's vertices: 3 mean edges, so that a grid takes a tenth of the body's memory.
constexpr double edges_a_cube = 3.0;
constexpr std::size_t cubes_for_noise = 1000, fewest_cubes = 8;
// A coarse grid may confuse modes that are close together, so these are refined together and the finest grid
// decides which is the lowest: the limit on their square over the lowest one's, which cubes give to a few
// percent, and the maximum number.
constexpr double hardly_higher = 1.15;
constexpr std::size_t most_modes = 3;
// Settled: the quotient fell by less than this share in this many iterations. A guess needs no better.
constexpr double cascade_settled = 1e-5;
constexpr int cascade_iterations = 20, most_cascade_iterations = 2000;

struct Mode {
  double square = 0.0;
  Field x, weighed;  // weighed: M x
};

void add_product(const CubeStiffness& m, const std::array<double, 24>& x, std::array<double, 24>& y) {
  const double* row = m.data();
  for (std::size_t a = 0; a < 24; row += ++a) {
    double sum = row[a] * x[a];
    for (std::size_t b = 0; b < a; ++b) {
      sum += row[b] * x[b];
      y[b] += row[b] * x[a];
    }
    y[a] += sum;
  }
}

Field stiffness_times(const CubeGrid& grid, const Field& x) {
  Field result(x.size(), Vector3d::Zero());
  for (std::size_t k = 0; k < grid.corner.size(); ++k) {
    std::array<double, 24> in, out{};
    for (std::size_t c = 0; c < 24; ++c) in[c] = x[grid.corner[k][c / 3]][static_cast<int>(c % 3)];
    add_product(grid.stiffness[k], in, out);
    for (std::size_t c = 0; c < 24; ++c) result[grid.corner[k][c / 3]][static_cast<int>(c % 3)] += out[c];
  }
  return result;
}

Field mass_times(const CubeGrid& grid, const Field& x) {
  Field result(x.size(), Vector3d::Zero());
  for (std::size_t k = 0; k < grid.corner.size(); ++k) {
    const double* row = grid.mass[k].data();
    const auto& corner = grid.corner[k];
    for (std::size_t a = 0; a < 8; row += ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        result[corner[a]] += row[b] * x[corner[b]];
        result[corner[b]] += row[b] * x[corner[a]];
      }
      result[corner[a]] += row[a] * x[corner[a]];
    }
  }
  return result;
}

// 1 over the stiffness's diagonal; 0 for a node with almost no stiffness, which stays at rest.
Field inverse_diagonal(const CubeGrid& grid) {
  Field diagonal(grid.node.size(), Vector3d::Zero());
  double highest = 0.0;
  for (std::size_t k = 0; k < grid.corner.size(); ++k)
    for (std::size_t c = 0; c < 24; ++c)
      diagonal[grid.corner[k][c / 3]][static_cast<int>(c % 3)] += grid.stiffness[k][c * (c + 1) / 2 + c];
  for (const Vector3d& d : diagonal) highest = std::max(highest, d.maxCoeff());
  for (Vector3d& d : diagonal)
    d = d.minCoeff() > 1e-10 * highest ? Vector3d(1.0 / d[0], 1.0 / d[1], 1.0 / d[2]) : Vector3d::Zero();
  return diagonal;
}

double over_nodes(const Field& a, const Field& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += scalar_product(a[i], b[i]);
  return sum;
}

// A grid and all coarser ones.
struct Grids {
  std::span<const CubeGrid* const> grid;
  std::span<const Field> inverse;
};

// The sum over the grids of the inverse diagonals' responses, on the first grid.
Field response(const Grids& grids, const Field& f) {
  const Field& inverse = grids.inverse.front();
  Field x(f.size());
  if (grids.grid.size() > 1) {
    const CubeGrid &fine = *grids.grid[0], &coarse = *grids.grid[1];
    x = on_finer_grid(
        coarse, fine,
        response({grids.grid.subspan(1), grids.inverse.subspan(1)}, onto_coarser_grid(coarse, fine, f)));
    for (std::size_t i = 0; i < f.size(); ++i) x[i] += f[i].cwiseProduct(inverse[i]);
  } else {
    for (std::size_t i = 0; i < f.size(); ++i) x[i] = f[i].cwiseProduct(inverse[i]);
  }
  return x;
}

void leave_out(const std::vector<Mode>& modes, Field& x) {
  for (const Mode& mode : modes) {
    const double part = over_nodes(x, mode.weighed);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] -= part * mode.x[i];
  }
}

// The lowest mode orthogonal to those below it, starting from x.
Mode next_mode(const Grids& grids, const std::vector<Mode>& below, Field x) {
  const CubeGrid& grid = *grids.grid.front();
  const Field& inverse = grids.inverse.front();
  for (std::size_t i = 0; i < x.size(); ++i)
    if (inverse[i][0] == 0.0) x[i] = Vector3d::Zero();
  leave_out(below, x);
  Field Kx = stiffness_times(grid, x), Mx = mass_times(grid, x), p(x.size(), Vector3d::Zero()), r = p, w = p;
  double rw_before = 0.0;
  std::vector<double> quotients;
  for (int k = 0; k < most_cascade_iterations; ++k) {
    const double xmx = over_nodes(x, Mx), xkx = over_nodes(x, Kx), quotient = xkx / xmx;
    quotients.push_back(quotient);
    if (k >= cascade_iterations &&
        quotients[static_cast<std::size_t>(k - cascade_iterations)] - quotient <= cascade_settled * quotient)
      break;
    double rw = 0.0, rw_of_before = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      r[i] = Kx[i] - quotient * Mx[i];
      rw_of_before += scalar_product(r[i], w[i]);
    }
    w = response(grids, r);
    for (std::size_t i = 0; i < x.size(); ++i)
      if (inverse[i][0] == 0.0) w[i] = Vector3d::Zero();
    leave_out(below, w);
    rw = over_nodes(r, w);
    const double beta = k == 0 ? 0.0 : std::max(0.0, (rw - rw_of_before) / rw_before);
    rw_before = rw;
    for (std::size_t i = 0; i < x.size(); ++i) p[i] = beta * p[i] - w[i];
    const Field Kp = stiffness_times(grid, p), Mp = mass_times(grid, p);
    const double xmp = over_nodes(x, Mp), pmp = over_nodes(p, Mp);
    const double t = best_step(xkx, over_nodes(x, Kp), over_nodes(p, Kp), xmx, xmp, pmp);
    const double scale = 1.0 / std::sqrt(xmx + 2.0 * t * xmp + t * t * pmp);
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = scale * (x[i] + t * p[i]);
      Kx[i] = scale * (Kx[i] + t * Kp[i]);
      Mx[i] = scale * (Mx[i] + t * Mp[i]);
    }
  }
  const double scale = 1.0 / std::sqrt(over_nodes(x, Mx));
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i] *= scale;
    Mx[i] *= scale;
  }
  return {quotients.back(), std::move(x), std::move(Mx)};
}

// The modes close to the lowest, ascending.
std::vector<Mode> modes_of(const Grids& grids, std::vector<Field> guesses) {
  std::vector<Mode> modes;
  double lowest = std::numeric_limits<double>::max();
  for (Field& guess : guesses) {
    modes.push_back(next_mode(grids, modes, std::move(guess)));
    lowest = std::min(lowest, modes.back().square);
    if (modes.back().square > hardly_higher * lowest) break;
  }
  std::stable_sort(modes.begin(), modes.end(),
                   [](const Mode& a, const Mode& b) { return a.square < b.square; });
  while (modes.size() > 1 && modes.back().square > hardly_higher * lowest) modes.pop_back();
  return modes;
}

std::vector<Field> noisy_guesses(std::size_t nodes) {
  Noise numbers;
  std::vector<Field> guesses(most_modes, Field(nodes));
  for (Field& guess : guesses)
    for (Vector3d& x : guess)
      for (int c = 0; c < 3; ++c) x[c] = numbers.next();
  return guesses;
}

std::vector<const CubeGrid*> finest_first(const CubeGrid& finest, const std::vector<CubeGrid>& coarser) {
  std::vector<const CubeGrid*> grids{&finest};
  for (const CubeGrid& grid : coarser) grids.push_back(&grid);
  return grids;
}

void forget_matrices(CubeGrid& grid) {
  grid.stiffness = std::vector<CubeStiffness>();
  grid.mass = std::vector<CubeMass>();
}

}  // namespace

CubeCascade::CubeCascade(const RegionStiffness& body, Field& guess)
    : body_(body), finest_(grid_of_body(body, edges_a_cube * body.mean_edge())) {
  for (CubeGrid* last = &finest_.grid; last->place.size() > fewest_cubes; last = &coarser_.back()) {
    CubeGrid next = coarser_grid(*last);
    coarser_.push_back(std::move(next));
  }
  const std::vector<const CubeGrid*> grids = finest_first(finest_.grid, coarser_);
  for (const CubeGrid* grid : grids) inverse_.push_back(inverse_diagonal(*grid));

  std::size_t level = 0;
  while (grids[level]->place.size() > cubes_for_noise && level + 1 < grids.size()) ++level;
  std::vector<Field> guesses = noisy_guesses(grids[level]->node.size());
  while (true) {
    std::vector<Mode> modes =
        modes_of({std::span(grids).subspan(level), std::span(inverse_).subspan(level)}, std::move(guesses));
    guesses.clear();
    for (Mode& mode : modes) guesses.push_back(std::move(mode.x));
    if (level == 0) break;
    for (Field& x : guesses) x = on_finer_grid(*grids[level], *grids[level - 1], x);
    --level;
  }
  guess.assign(body.size(), Vector3d::Zero());
  add_on_body(finest_, body, guesses.front(), guess);
  forget_matrices(finest_.grid);
  for (CubeGrid& grid : coarser_) forget_matrices(grid);
}

void CubeCascade::add_response(const Field& f, Field& x) const {
  const Field forces = onto_grid(finest_, body_, f);
  add_on_body(finest_, body_, response({finest_first(finest_.grid, coarser_), inverse_}, forces), x);
}

}  // namespace fascicle::build
