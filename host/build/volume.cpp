#include "host/build/volume.h"

#include <algorithm>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include "host/build/cube_root.h"
#include "host/build/points.h"

namespace fascicle::build {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::Model;

constexpr double largest_gain = 32.0;
constexpr double flat_moment = 1e-3;
// The threshold of extract_rotation in shaders/kernel/rotation.inc.
constexpr double least_turned = 0x1p-40;

// The moment at rest, with the weights as the solvers have them.
Matrix3d rest_moment(const Model& model, std::uint32_t r) {
  const auto rest = [&](std::uint32_t i) { return vector_at(model.rest, i); };
  const float* centre = &model.region_rest[4 * std::size_t{r}];
  const Vector3d o(double{centre[0]}, double{centre[1]}, double{centre[2]});
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();
  for (std::uint32_t e = model.ring_offset[r]; e < model.ring_offset[r + 1]; ++e) {
    const std::uint32_t i = model.ring[e];
    const double w = double{model.share_taken[e]} * double{model.pull[i]};
    const Vector3d offset = rest(i) - rest(r);
    first += w * offset;
    second += w * (offset * offset.transpose());
  }
  return second - first * o.transpose();
}

double largest_alpha(const Model& model, std::uint32_t r) {
  float alpha = model.alpha[r];
  for (std::uint32_t e = model.ring_offset[r]; e < model.ring_offset[r + 1]; ++e)
    alpha = std::max(alpha, model.alpha[model.ring[e]]);
  return double{alpha};
}

}  // namespace

double volume_gain(double volume, double alpha, double limit) {
  if (!(volume > 0.0) || !(alpha > 0.0)) return 0.0;
  return volume * std::clamp(2.0 * (limit / alpha - 1.0), 0.0, largest_gain);
}

void write_volume(const std::vector<double>& volume, Model& model) {
  const std::size_t n = model.vertex_count;
  std::vector<float> gains(n, 0.0f), regions(3 * n);
  bool some = false;
  for (std::uint32_t r = 0; r < n; ++r) {
    regions[3 * r + 1] = 1.0f;
    const double gain = volume_gain(volume[model.layer_of(r)], largest_alpha(model, r),
                                    model.is_implicit() ? implicit_limit : explicit_limit);
    if (!(gain > 0.0) || !(model.region_rest[4 * std::size_t{r} + 3] > 0.0f)) continue;
    const Vector3d sizes =
        Eigen::SelfAdjointEigenSolver<Matrix3d>(rest_moment(model, r), Eigen::EigenvaluesOnly).eigenvalues();
    if (!(sizes[0] > flat_moment * sizes[2]) || !(sizes[2] > least_turned)) continue;
    const double size = cube_root(sizes[0] * sizes[1] * sizes[2]);
    const Vector3d inverse = size * sizes.cwiseInverse();
    gains[r] = static_cast<float>(gain);
    regions[3 * r] = static_cast<float>(1.0 / size);
    regions[3 * r + 1] = static_cast<float>(inverse.squaredNorm());
    regions[3 * r + 2] = static_cast<float>(gain * inverse.squaredNorm() / inverse.sum());
    some = true;
  }
  if (!some) return;
  model.volume_gain = std::move(gains);
  model.region_volume = std::move(regions);
}

}  // namespace fascicle::build
