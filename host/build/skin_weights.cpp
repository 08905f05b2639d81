#include "host/build/skin_weights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

#include "host/build/mass.h"
#include "host/build/message.h"

namespace fascicle::build {

namespace {

using Eigen::VectorXd;
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

constexpr std::size_t most_joints = 8;
constexpr double least_share = 1e-4;
constexpr double weight_steps = 8388608.0;  // 2^23: sums of these up to 1 are exact in floats
constexpr double solve_tolerance = 1e-8;

struct Influence {
  std::uint32_t joint;
  double weight;
};
using Influences = std::vector<Influence>;

void check_weights(const scene::Character& character, std::span<const std::uint32_t> welded,
                   const std::string& source) {
  if (character.weights.size() != welded.size() || character.joints.size() != welded.size())
    fail(source, "mesh: " + std::to_string(character.weights.size()) + " vertices have weights, of " +
                     std::to_string(welded.size()) + "; every vertex needs them");
  std::vector<std::uint32_t> bad;
  for (std::uint32_t v = 0; v < welded.size(); ++v) {
    double sum = 0.0;
    bool valid = true;
    for (std::size_t k = 0; k < most_joints; ++k) {
      const double w = character.weights[v][k];
      valid = valid && w >= 0.0 && std::isfinite(w) &&
              (w == 0.0 || character.joints[v][k] < character.skeleton.size());
      sum += w;
    }
    if (!valid || !(sum > 0.0)) bad.push_back(v);
  }
  if (!bad.empty())
    fail(source, "mesh: the skin weights are not positive numbers for joints of the skeleton at vertex " +
                     list_of(bad) + " (counted from 0)");
}

// Sums of the joints' weights over the vertices that were welded into each; the scale does not matter.
std::vector<Influences> surface_influences(const scene::Character& character,
                                           std::span<const std::uint32_t> welded, std::size_t surface_count) {
  std::vector<Influences> rows(surface_count);
  for (std::size_t v = 0; v < welded.size(); ++v)
    for (std::size_t k = 0; k < most_joints; ++k) {
      const Influence influence{character.joints[v][k], character.weights[v][k]};
      if (influence.weight == 0.0) continue;
      Influences& row = rows[welded[v]];
      const auto same = std::find_if(row.begin(), row.end(),
                                     [&](const Influence& i) { return i.joint == influence.joint; });
      if (same == row.end())
        row.push_back(influence);
      else
        same->weight += influence.weight;
    }
  for (Influences& row : rows) {
    double sum = 0.0;
    for (const Influence& i : row) sum += i.weight;
    for (Influence& i : row) i.weight /= sum;
  }
  return rows;
}

// Stiffness of Laplace's equation, sum over tetrahedra of volume grad_a . grad_b, rows of inner vertices
// only.
struct Laplace {
  SparseMatrix inner;    // inner x inner
  SparseMatrix surface;  // inner x surface
};

Laplace laplace(const scene::TetMesh& mesh, std::size_t surface_count) {
  const std::size_t inner_count = mesh.vertices.size() - surface_count;
  std::vector<Eigen::Triplet<double>> inner, surface;
  for (const auto& t : mesh.tetrahedra) {
    std::array<Vector3d, 4> gradient;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector3d& a = mesh.vertices[t[(k + 1) % 4]];
      const Vector3d normal = (mesh.vertices[t[(k + 2) % 4]] - a).cross(mesh.vertices[t[(k + 3) % 4]] - a);
      gradient[k] = normal / normal.dot(mesh.vertices[t[k]] - a);
    }
    const double volume = signed_volume(mesh, t);
    for (std::size_t a = 0; a < 4; ++a) {
      if (t[a] < surface_count) continue;
      const int row = static_cast<int>(t[a] - surface_count);
      for (std::size_t b = 0; b < 4; ++b) {
        const double entry = volume * gradient[a].dot(gradient[b]);
        if (t[b] < surface_count)
          surface.emplace_back(row, static_cast<int>(t[b]), entry);
        else
          inner.emplace_back(row, static_cast<int>(t[b] - surface_count), entry);
      }
    }
  }
  const auto rows = static_cast<Eigen::Index>(inner_count);
  Laplace result{SparseMatrix(rows, rows), SparseMatrix(rows, static_cast<Eigen::Index>(surface_count))};
  result.inner.setFromTriplets(inner.begin(), inner.end());
  result.surface.setFromTriplets(surface.begin(), surface.end());
  return result;
}

// Keeps the most_joints largest.
void offer(Influences& row, const Influence& influence) {
  row.push_back(influence);
  if (row.size() <= most_joints) return;
  row.erase(std::min_element(row.begin(), row.end(),
                             [](const Influence& a, const Influence& b) { return a.weight < b.weight; }));
}

void solve_inside(const scene::TetMesh& mesh, std::size_t joint_count, const std::string& source,
                  std::vector<Influences>& rows) {
  const std::size_t surface_count = rows.size();
  rows.resize(mesh.vertices.size());
  if (surface_count == rows.size()) return;
  const Laplace equation = laplace(mesh, surface_count);
  Eigen::ConjugateGradient<SparseMatrix, Eigen::Lower | Eigen::Upper> solver;
  solver.setTolerance(solve_tolerance);
  solver.compute(equation.inner);

  std::vector<std::vector<Influence>> of_joint(joint_count);  // here `joint` is the surface vertex
  for (std::uint32_t v = 0; v < surface_count; ++v)
    for (const Influence& i : rows[v]) of_joint[i.joint].push_back({v, i.weight});
  for (std::uint32_t joint = 0; joint < joint_count; ++joint) {
    if (of_joint[joint].empty()) continue;
    VectorXd boundary = VectorXd::Zero(static_cast<Eigen::Index>(surface_count));
    for (const Influence& i : of_joint[joint]) boundary[i.joint] = i.weight;
    const VectorXd right = -(equation.surface * boundary);
    const VectorXd weight = solver.solve(right);
    if (solver.info() != Eigen::Success)
      fail(source, "mesh: skin weights could not be carried inside for joint " + std::to_string(joint) +
                       "; the tetrahedra are too flat, ask for another resolution");
    for (std::size_t i = surface_count; i < rows.size(); ++i) {
      const double w = weight[static_cast<Eigen::Index>(i - surface_count)];
      if (w >= least_share) offer(rows[i], {joint, w});
    }
  }
}

// Largest first, cut, normalised and rounded; the largest takes what rounding left.
void finish(Influences& row) {
  std::sort(row.begin(), row.end(), [](const Influence& a, const Influence& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.joint < b.joint;
  });
  while (row.size() > most_joints || (row.size() > 1 && row.back().weight < least_share)) row.pop_back();
  double sum = 0.0;
  for (const Influence& i : row) sum += i.weight;
  double others = 0.0;
  for (std::size_t k = 1; k < row.size(); ++k) {
    row[k].weight = std::round(row[k].weight / sum * weight_steps) / weight_steps;
    others += row[k].weight;
  }
  row[0].weight = 1.0 - others;
}

}  // namespace

SkinWeights skin_weights(const scene::TetMesh& mesh, std::size_t surface_count,
                         const scene::Character& character, std::span<const std::uint32_t> welded,
                         const std::string& source) {
  check_weights(character, welded, source);
  std::vector<Influences> rows = surface_influences(character, welded, surface_count);
  solve_inside(mesh, character.skeleton.size(), source, rows);

  SkinWeights skin;
  skin.offset.push_back(0);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].empty())
      fail(source, "mesh: no joint reaches vertex " + std::to_string(i) +
                       " of the tetrahedral mesh; ask for another resolution");
    finish(rows[i]);
    for (const Influence& influence : rows[i]) {
      skin.joint.push_back(influence.joint);
      skin.weight.push_back(influence.weight);
    }
    skin.offset.push_back(static_cast<std::uint32_t>(skin.joint.size()));
  }
  return skin;
}

}  // namespace fascicle::build
