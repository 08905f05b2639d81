#include "host/bake/surface.h"

#include <cmath>

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
