#include "tests/formats/sink_frames.h"

#include "host/formats/surface.h"
#include "tests/bake/fake_solver.h"

namespace fascicle::tests {

model::Frame stretched(const model::Model& model, std::uint64_t k) {
  model::Frame frame{
      .index = k, .origin = sink_origin, .positions = model.rest, .velocities = model.rest, .surface = {}};
  for (float& value : frame.positions) value *= 1.0f + 0.25f * static_cast<float>(k);
  for (float& value : frame.velocities) value *= static_cast<float>(k);
  frame.surface = formats::embed(model, frame.positions);
  return frame;
}

void write_frames(std::unique_ptr<formats::FrameSink> sink, const model::Model& model,
                  const std::filesystem::path& folder) {
  const model::Frame initial = stretched(model, 0);
  sink->begin({.model = &model,
               .folder = folder,
               .scene_name = "s",
               .fps = 8.0,
               .start = 1.5,
               .frames = 2,
               .first = 0,
               .initial = &initial});
  for (std::uint64_t k = 0; k < 3; ++k) sink->write(stretched(model, k));
  sink->sync();
  sink->finish();
}

model::Model folded_sheet() {
  model::Model m = two_tetrahedra();
  // Model vertices at the origin, on x, y and z; the last one is moved to (0, 0, 2).
  m.rest = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 2, 1, 1, 1};
  m.surface_vertex.clear();
  m.surface_weight.clear();
  for (const std::uint32_t vertex : {0u, 1u, 2u, 0u, 1u, 3u})
    for (int corner = 0; corner < 4; ++corner) {
      m.surface_vertex.push_back(vertex);
      m.surface_weight.push_back(corner == 0 ? 1.0f : 0.0f);
    }
  // The first triangle faces z; the second faces -y and is twice as large.
  m.surface_triangle = {0, 1, 2, 3, 5, 4};
  return m;
}

}  // namespace fascicle::tests
