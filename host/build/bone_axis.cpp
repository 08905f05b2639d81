#include "host/build/bone_axis.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "host/build/measures.h"

namespace fascicle::build {

namespace {

// An end's bone reaches this share of the span of most of its skin (most_skin).
constexpr double end_reach = 0.85;
constexpr double most_skin = 0.98;
// Samples along a bone to test whether it runs inside the skin.
constexpr int axis_samples = 10;

// Vertices that a joint and its descendants move, and their areas times its weight.
template <class Use>
void for_each_part(const mesh::SurfaceMesh& surface, const SkinOfJoints& skin, std::size_t joint, Use use) {
  for (std::size_t v = 0; v < skin.with_below.size(); ++v)
    for (const auto& [j, w] : skin.with_below[v])
      if (j == joint) use(surface.vertices[v], w * skin.vertex_area[v]);
}

}  // namespace

bool runs_inside(const SkinInside& skin, const Vector3d& from, const Vector3d& to) {
  int inside = 0;
  for (int k = 0; k < axis_samples; ++k)
    inside += skin.contains(from + (k + 0.5) / axis_samples * (to - from)) ? 1 : 0;
  return 2 * inside >= axis_samples;
}

Vector3d tip_of_chain(const mesh::SurfaceMesh& surface, const SkinOfJoints& skin, std::size_t joint,
                      const Vector3d& begin, double shortest) {
  const Vector3d towards = skin.below[joint].middle - begin;
  const double length = towards.norm();
  if (!(length > shortest)) return begin;
  std::vector<std::pair<double, double>> reach;  // along the bone, area
  double all = 0.0;
  for_each_part(surface, skin, joint, [&](const Vector3d& p, double area) {
    reach.emplace_back((p - begin).dot(towards) / length, area);
    all += area;
  });
  std::sort(reach.begin(), reach.end());
  double sum = 0.0, far = 0.0;
  for (const auto& [along, area] : reach) {
    far = along;
    sum += area;
    if (sum >= most_skin * all) break;
  }
  return begin + std::max(end_reach * far, length) / length * towards;
}

bool lies_around(const mesh::SurfaceMesh& surface, const SkinOfJoints& skin, std::size_t joint,
                 const Vector3d& from, const Vector3d& to) {
  double sum = 0.0, area = 0.0;
  for_each_part(surface, skin, joint, [&](const Vector3d& p, double part) {
    sum += part * segment_distance(p, from, to);
    area += part;
  });
  const Vector3d& middle = skin.below[joint].middle;
  const double along = (middle - from).dot(to - from) / (to - from).squaredNorm();
  return along > 0.0 && along < 1.0 && 2.0 * area * segment_distance(middle, from, to) < sum;
}

}  // namespace fascicle::build
