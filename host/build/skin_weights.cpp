#include "host/build/skin_weights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "host/build/boundary.h"
#include "host/build/harmonic.h"
#include "host/build/message.h"

namespace fascicle::build {

namespace {

constexpr std::size_t most_joints = 8;
constexpr double least_share = 1e-4;
constexpr double weight_steps = 8388608.0;  // 2^23: sums of these up to 1 are exact in floats

struct Influence {
  std::uint32_t joint;
  double weight;
};
using Influences = std::vector<Influence>;

void check_weights(const rig::Character& character, std::span<const std::uint32_t> welded,
                   const std::string& source) {
  if (character.weights.size() != welded.size() || character.joints.size() != welded.size())
    fail(source, "mesh: " + std::to_string(character.weights.size()) + " vertices have skin weights, of " +
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

void add(Influences& row, const Influence& influence) {
  const auto same =
      std::find_if(row.begin(), row.end(), [&](const Influence& i) { return i.joint == influence.joint; });
  if (same == row.end())
    row.push_back(influence);
  else
    same->weight += influence.weight;
}

// Sums of the joints' weights over the vertices welded into each; the scale does not matter.
std::vector<Influences> surface_influences(const rig::Character& character,
                                           std::span<const std::uint32_t> welded, std::size_t surface_count) {
  std::vector<Influences> rows(surface_count);
  for (std::size_t v = 0; v < welded.size(); ++v)
    for (std::size_t k = 0; k < most_joints; ++k) {
      const Influence influence{character.joints[v][k], character.weights[v][k]};
      if (influence.weight == 0.0) continue;
      add(rows[welded[v]], influence);
    }
  for (Influences& row : rows) {
    double sum = 0.0;
    for (const Influence& i : row) sum += i.weight;
    for (Influence& i : row) i.weight /= sum;
  }
  return rows;
}

// Keeps the most_joints largest.
void offer(Influences& row, const Influence& influence) {
  row.push_back(influence);
  if (row.size() <= most_joints) return;
  row.erase(std::min_element(row.begin(), row.end(),
                             [](const Influence& a, const Influence& b) { return a.weight < b.weight; }));
}

// Each joint's weights at the vertices that have none yet, by ascending vertex.
std::vector<std::vector<VertexValue>> carried_inside(const mesh::TetMesh& mesh,
                                                     const std::vector<Influences>& rows,
                                                     std::size_t joint_count, const std::string& source,
                                                     std::size_t threads) {
  std::vector<char> is_given(rows.size(), 0);
  std::vector<std::vector<VertexValue>> given(joint_count), found(joint_count);
  for (std::uint32_t v = 0; v < rows.size(); ++v) {
    is_given[v] = !rows[v].empty();
    for (const Influence& i : rows[v]) given[i.joint].push_back({v, i.weight});
  }
  if (std::find(is_given.begin(), is_given.end(), 0) == is_given.end()) return found;

  const LaplaceMatrix matrix = laplace_matrix(mesh);
  std::vector<HarmonicExtension> extension(std::min(threads, joint_count),
                                           HarmonicExtension(matrix, is_given));
  base::for_each_in_parallel(joint_count, threads, [&](std::size_t joint, std::size_t worker) {
    if (given[joint].empty()) return;
    std::optional<std::vector<VertexValue>> values = extension[worker].extend(given[joint]);
    if (!values)
      fail(source, "mesh: skin weights could not be extended to the inside for joint " +
                       std::to_string(joint) + "; the tetrahedra are too flat, use another resolution");
    std::erase_if(*values, [](const VertexValue& v) { return !(v.value >= least_share); });
    found[joint] = std::move(*values);
  });
  return found;
}

// Sorts by size, truncates, normalises and rounds; the largest takes the rounding remainder.
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

std::vector<Influences> rows_of(const SkinWeights& skin, std::size_t count) {
  std::vector<Influences> rows(count);
  for (std::size_t i = 0; i + 1 < skin.offset.size(); ++i)
    for (std::uint32_t k = skin.offset[i]; k < skin.offset[i + 1]; ++k)
      rows[i].push_back({skin.joint[k], skin.weight[k]});
  return rows;
}

// The weighted mean of a triangle's corners.
Influences at_place(const std::vector<Influences>& rows, const mesh::SurfaceMesh& surface,
                    const SkinPoint& place) {
  Influences mean;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(place.weights[k] > 0.0)) continue;
    for (const Influence& i : rows[surface.triangles[place.triangle][k]])
      add(mean, {i.joint, place.weights[k] * i.weight});
  }
  return mean;
}

SkinWeights flattened(const std::vector<Influences>& rows) {
  SkinWeights skin;
  skin.offset.push_back(0);
  for (const Influences& row : rows) {
    for (const Influence& influence : row) {
      skin.joint.push_back(influence.joint);
      skin.weight.push_back(influence.weight);
    }
    skin.offset.push_back(static_cast<std::uint32_t>(skin.joint.size()));
  }
  return skin;
}

}  // namespace

SkinWeights welded_skin_weights(const rig::Character& character, std::span<const std::uint32_t> welded,
                                std::size_t count, const std::string& source) {
  check_weights(character, welded, source);
  return flattened(surface_influences(character, welded, count));
}

SkinWeights with_shared_rows(const SkinWeights& weights, std::span<const SharedRow> shared) {
  if (shared.empty()) return weights;
  std::vector<Influences> rows = rows_of(weights, weights.offset.size() - 1);
  for (const SharedRow& of : shared) {
    Influences row;
    for (const auto& [joint, w] : of.row) row.push_back({joint, w});
    finish(row);
    for (const std::uint32_t v : of.vertices) rows[v] = row;
  }
  return flattened(rows);
}

SkinWeights harmonic_skin_weights(const mesh::TetMesh& mesh, const SkinWeights& given,
                                  std::size_t joint_count, const std::string& source, std::size_t threads) {
  std::vector<Influences> rows = rows_of(given, mesh.vertices.size());
  const std::vector<std::vector<VertexValue>> inside =
      carried_inside(mesh, rows, joint_count, source, threads);
  for (std::uint32_t joint = 0; joint < joint_count; ++joint)
    for (const VertexValue& v : inside[joint]) offer(rows[v.vertex], {joint, v.value});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].empty())
      fail(source, "mesh: no joint reaches vertex " + std::to_string(i) +
                       " of the tetrahedral mesh; use another resolution");
    finish(rows[i]);
  }
  return flattened(rows);
}

SkinWeights body_skin_weights(const BodyMesh& body, const WeldedSurface& welded, const SkinWeights& skin,
                              std::size_t joint_count, const std::string& source) {
  if (body.keeps_skin) return harmonic_skin_weights(body.mesh, skin, joint_count, source);
  const std::vector<Influences> of_skin = rows_of(skin, welded.surface.vertices.size());
  std::vector<Influences> given(body.mesh.vertices.size());
  for (const auto& face : boundary_triangles(body.mesh, source))
    for (const std::uint32_t vertex : face)
      if (given[vertex].empty()) given[vertex] = at_place(of_skin, welded.surface, body.anchor[vertex]);
  return harmonic_skin_weights(body.mesh, flattened(given), joint_count, source);
}

}  // namespace fascicle::build
