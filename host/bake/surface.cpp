#include "host/bake/surface.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/bake/text.h"

namespace fascicle::bake {

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

SurfaceNormals::SurfaceNormals(const model::Model& model) : triangle_(model.surface_triangle) {
  const std::vector<float> rest = embed(model, model.rest);
  std::map<std::array<float, 3>, std::uint32_t> numbers;
  for (std::size_t i = 0; i < rest.size(); i += 3) {
    // -0 and 0 are one place.
    const std::array<float, 3> at{rest[i] + 0.0f, rest[i + 1] + 0.0f, rest[i + 2] + 0.0f};
    place_.push_back(numbers.try_emplace(at, static_cast<std::uint32_t>(numbers.size())).first->second);
  }
  places_ = static_cast<std::uint32_t>(numbers.size());
}

std::vector<float> SurfaceNormals::of(std::span<const float> positions) const {
  std::vector<double> sums(std::size_t{3} * places_, 0.0);
  for (std::size_t t = 0; t < triangle_.size(); t += 3) {
    const auto edge = [&](std::size_t k, std::size_t axis) {
      return double{positions[std::size_t{3} * triangle_[t + k] + axis]} -
             double{positions[std::size_t{3} * triangle_[t] + axis]};
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t y = (axis + 1) % 3, z = (axis + 2) % 3;
      const double cross = edge(1, y) * edge(2, z) - edge(1, z) * edge(2, y);
      for (std::size_t k = 0; k < 3; ++k) sums[std::size_t{3} * place_[triangle_[t + k]] + axis] += cross;
    }
  }
  std::vector<float> normals(positions.size());
  for (std::size_t i = 0; i < place_.size(); ++i) {
    const double* sum = &sums[std::size_t{3} * place_[i]];
    const double length = std::sqrt((sum[0] * sum[0] + sum[1] * sum[1]) + sum[2] * sum[2]);
    for (std::size_t axis = 0; axis < 3; ++axis)
      normals[3 * i + axis] =
          length > 0.0 ? static_cast<float>(sum[axis] / length) : (axis == 1 ? 1.0f : 0.0f);
  }
  return normals;
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

std::string rest_obj(const model::Model& model) {
  const std::vector<float> surface = embed(model, model.rest);
  const std::vector<float> world = world_positions(surface, model.unit, model.rest_origin);
  std::string text = "# fascicle: the surface at rest, metres, Y up\n";
  for (std::size_t i = 0; i < world.size(); i += 3)
    text += "v " + number_text(world[i]) + ' ' + number_text(world[i + 1]) + ' ' + number_text(world[i + 2]) +
            '\n';
  for (std::size_t i = 0; i < model.surface_triangle.size(); i += 3) {
    text += 'f';
    for (std::size_t k = 0; k < 3; ++k)
      text += ' ' + number_text(std::uint64_t{model.surface_triangle[i + k]} + 1);
    text += '\n';
  }
  return text;
}

}  // namespace fascicle::bake
