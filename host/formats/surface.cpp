#include "host/formats/surface.h"

#include <algorithm>
#include <cmath>

#include "host/base/errors.h"

namespace fascicle::formats {

std::vector<float> embed(const model::Model& model, std::span<const float> positions) {
  std::vector<float> surface(std::size_t{3} * model.surface_count());
  for (std::size_t s = 0; s < model.surface_count(); ++s) {
    const std::uint32_t* vertex = &model.surface_vertex[4 * s];
    const float* weight = &model.surface_weight[4 * s];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto term = [&](std::size_t k) {
        return weight[k] * positions[std::size_t{3} * vertex[k] + axis];
      };
      const float sum = (term(0) + term(1)) + (term(2) + term(3));
      surface[3 * s + axis] = std::fabs(sum) < 0x1p-40f ? 0.0f : sum;
    }
  }
  return surface;
}

std::vector<float> world_positions(std::span<const float> positions, double unit,
                                   const std::array<double, 3>& origin) {
  std::vector<float> world(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i)
    world[i] = static_cast<float>(origin[i % 3] + unit * double{positions[i]});
  return world;
}

void require_surface(const model::Model& model, const std::string& format) {
  if (model.surface_count() == 0)
    throw base::BakeError(format + ": the scene has no surface to write; leave out --format " + format);
}

std::array<float, 6> bounds(std::span<const float> points) {
  if (points.empty()) return {};
  std::array<float, 6> box{points[0], points[1], points[2], points[0], points[1], points[2]};
  for (std::size_t i = 3; i < points.size(); ++i) {
    box[i % 3] = std::min(box[i % 3], points[i]);
    box[3 + i % 3] = std::max(box[3 + i % 3], points[i]);
  }
  return box;
}

}  // namespace fascicle::formats
