#include <algorithm>
#include <array>
#include <cmath>

#include "host/made/made_mesh.h"
#include "host/made/made_shape.h"

namespace fascicle::made {
namespace {

struct Segment {
  Vector3d from, to;
};

Vector3d place_of(const rig::Joint& joint) {
  return -joint.inverse_bind.topRightCorner<3, 1>();
}

double squared_distance(const Segment& bone, const Vector3d& point) {
  const Vector3d axis = bone.to - bone.from, from = point - bone.from;
  const double square = axis.squaredNorm();
  const double t = square > 0.0 ? std::min(std::max(from.dot(axis) / square, 0.0), 1.0) : 0.0;
  return (from - t * axis).squaredNorm();
}

// For each joint, the segments to its child joints; a point if it has none.
std::vector<std::vector<Segment>> bones_of_joints(const std::vector<rig::Joint>& skeleton) {
  std::vector<std::vector<Segment>> bones(skeleton.size());
  for (const rig::Joint& joint : skeleton)
    if (joint.parent >= 0) {
      const auto parent = static_cast<std::size_t>(joint.parent);
      bones[parent].push_back({place_of(skeleton[parent]), place_of(joint)});
    }
  for (std::size_t j = 0; j < skeleton.size(); ++j)
    if (bones[j].empty()) bones[j].push_back({place_of(skeleton[j]), place_of(skeleton[j])});
  return bones;
}

constexpr std::size_t most_joints_a_vertex = 6;

void keep_largest(const std::vector<double>& all, std::array<std::uint32_t, 8>& joints,
                  std::array<double, 8>& weights) {
  std::vector<std::uint32_t> order(all.size());
  for (std::uint32_t j = 0; j < order.size(); ++j) order[j] = j;
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return all[a] != all[b] ? all[a] > all[b] : a < b; });
  joints = {};
  weights = {};
  // Subtracts the largest weight left out from all, so that joints enter and leave without a jump.
  const std::size_t kept = std::min(most_joints_a_vertex, order.size());
  const double threshold = kept < order.size() ? all[order[kept]] : 0.0;
  double sum = 0.0;
  for (std::size_t k = 0; k < kept; ++k) sum += all[order[k]] - threshold;
  for (std::size_t k = 0; k < kept; ++k) {
    joints[k] = order[k];
    weights[k] = (all[order[k]] - threshold) / sum;
  }
}

}  // namespace

void bind_skin(const Sculpture& sculpture, rig::Character& character) {
  const std::vector<Vector3d>& vertices = character.surface.vertices;
  const auto neighbours = vertex_neighbours(character.surface);
  const auto bones = bones_of_joints(character.skeleton);
  const std::size_t joints = character.skeleton.size();

  // The equilibrium of (w_j - mean of the neighbours' w_j) + heat (w_j - [j is the vertex's own joint]) = 0
  // with heat = tightness (edge / distance to the bone)^2, by Gauss-Seidel. After this many sweeps the
  // weights change by less than 1e-3 where the body is thickest.
  constexpr double tightness = 2.0;
  constexpr double most_heat = 0.2;  // spreads a transition over several edges, however thin the limb
  constexpr int sweeps = 80;
  std::vector<std::vector<double>> weights(vertices.size(), std::vector<double>(joints, 0.0));
  std::vector<std::size_t> own(vertices.size());
  std::vector<double> heat(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    own[i] = sculpture.parts[nearest_part(sculpture, vertices[i])].joint;
    weights[i][own[i]] = 1.0;
    double nearest = 1e30;
    for (const Segment& bone : bones[own[i]])
      nearest = std::min(nearest, squared_distance(bone, vertices[i]));
    double edges = 0.0;
    for (const std::uint32_t j : neighbours[i]) edges += (vertices[j] - vertices[i]).squaredNorm();
    heat[i] = std::min(tightness * edges / static_cast<double>(neighbours[i].size()) / nearest, most_heat);
  }
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const double share = 1.0 / static_cast<double>(neighbours[i].size());
      for (std::size_t j = 0; j < joints; ++j) {
        double sum = j == own[i] ? heat[i] : 0.0;
        for (const std::uint32_t n : neighbours[i]) sum += share * weights[n][j];
        weights[i][j] = sum / (1.0 + heat[i]);
      }
    }

  character.joints.resize(vertices.size());
  character.weights.resize(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i)
    keep_largest(weights[i], character.joints[i], character.weights[i]);
}

}  // namespace fascicle::made
