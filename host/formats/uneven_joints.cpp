#include "host/formats/uneven_joints.h"

#include <cstddef>

namespace fascicle::formats {

namespace {

bool is_uneven(const Eigen::Matrix4d& transform, double tolerance) {
  const Eigen::Matrix3d linear = transform.topLeftCorner<3, 3>();
  const Eigen::Matrix3d squares = linear.transpose() * linear;
  const double mean = squares.trace() / 3.0;
  return (squares - mean * Eigen::Matrix3d::Identity()).norm() > tolerance * mean;
}

}  // namespace

std::vector<char> below_uneven_joints(const gltf::RigPart& part, const std::vector<Eigen::Matrix4d>& slots,
                                      double tolerance) {
  std::vector<char> found(part.positions.size(), 0);
  std::vector<char> uneven;
  for (const Eigen::Matrix4d& slot : slots) uneven.push_back(is_uneven(slot, tolerance) ? 1 : 0);
  for (std::size_t i = 0; i + 1 < part.influence_offset.size(); ++i)
    for (std::size_t k = part.influence_offset[i]; k < part.influence_offset[i + 1]; ++k)
      if (uneven[part.slot[k]] != 0) found[i] = 1;
  return found;
}

}  // namespace fascicle::formats
