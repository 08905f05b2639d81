#include "host/model/model.h"

#include <algorithm>
#include <cstddef>

namespace fascicle::model {

double extent(const Model& model) {
  float largest = 0.0f;
  for (std::size_t axis = 0; axis < 3 && !model.rest.empty(); ++axis) {
    float low = model.rest[axis], high = low;
    for (std::size_t k = axis; k < model.rest.size(); k += 3) {
      low = std::min(low, model.rest[k]);
      high = std::max(high, model.rest[k]);
    }
    largest = std::max(largest, high - low);
  }
  return double{largest} * model.unit;
}

}  // namespace fascicle::model
