#include "host/build/fibre.h"

namespace fascicle::build {

std::vector<float> fibre_directions(const std::vector<scene::Layer>& layers,
                                    const std::vector<std::uint32_t>& layer_of) {
  std::vector<float> directions;
  directions.reserve(3 * layer_of.size());
  for (const std::uint32_t layer : layer_of) {
    scene::Vector3d d = layers[layer].fibre.value_or(scene::Vector3d::Zero());
    const double length = d.norm();
    if (length > 0.0) d /= length;
    for (int a = 0; a < 3; ++a) directions.push_back(static_cast<float>(d[a]));
  }
  return directions;
}

}  // namespace fascicle::build
