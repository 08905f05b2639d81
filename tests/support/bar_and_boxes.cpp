#include "tests/support/bar_and_boxes.h"

#include <cstdint>

#include "tests/support/test_models.h"

namespace fascicle::tests {

model::Model bar_and_boxes(const std::vector<Box>& boxes) {
  model::Model model = make_model(kuhn_bar(4, 2, 2, 0.25), {});
  model.surface_vertex.clear();
  model.surface_weight.clear();
  model.surface_triangle.clear();
  std::vector<Box> all{{{0.0f, 0.0f, 0.0f}, {1.0f, 0.5f, 0.5f}}};
  all.insert(all.end(), boxes.begin(), boxes.end());
  for (std::size_t b = 0; b < all.size(); ++b) {
    const std::uint32_t first = model.surface_count();
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
      const std::uint32_t vertex = model.vertex_count++;
      for (std::uint32_t a = 0; a < 3; ++a) {
        const double place = double{((corner >> a) & 1U) != 0 ? all[b].high[a] : all[b].low[a]};
        model.rest.push_back(static_cast<float>((place - model.rest_origin[a]) / model.unit));
      }
      model.tag.push_back(b > 0 ? shader::tag_kinematic : 0U);
      model.mass.push_back(1.0);
      model.surface_vertex.insert(model.surface_vertex.end(), 4, vertex);
      model.surface_weight.insert(model.surface_weight.end(), {1.0f, 0.0f, 0.0f, 0.0f});
    }
    for (const std::uint32_t corner :
         {0U, 1U, 3U, 0U, 3U, 2U, 4U, 7U, 5U, 4U, 6U, 7U, 0U, 4U, 1U, 3U, 7U, 2U})
      model.surface_triangle.push_back(first + corner);
  }
  return model;
}

}  // namespace fascicle::tests
