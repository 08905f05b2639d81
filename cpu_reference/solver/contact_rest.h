// The part of stage contact's search (contact_search.h) that is done once, on the rest shape. It takes as
// long as a few frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "cpu_reference/solver/contact_lanes.h"
#include "host/model/model.h"

namespace fascicle::cpu_reference {

struct ContactRest {
  static constexpr std::uint32_t block_size = contact_points_together, leaf_size = shader::contact_leaf;
  // One bit per point of a block.
  using PointBits = std::uint16_t;
  // A leaf with some tetrahedra near some of a block's points at rest.
  struct Near {
    std::uint32_t leaf;
    std::size_t first;  // in `relevant`, one entry per tetrahedron
  };
  struct Block {
    PointBits points = 0, mobile = 0;
    std::uint32_t ignored = 0;  // groups that none of the points meets
    std::vector<Near> near;     // in ascending order of leaf
  };

  // Requires a model with contact.
  explicit ContactRest(const model::Model& model);

  std::vector<std::uint32_t> order, order_vertex;       // points, in order of blocks; their vertices
  std::vector<std::uint32_t> leaf_offset, leaf_vertex;  // the vertices of each leaf
  std::vector<std::uint8_t> leaf_corner;  // for each corner, its index among its leaf's vertices
  std::vector<char> leaf_is_held;         // none of its vertices can move on its own
  std::vector<std::uint32_t> leaf_group;  // groups that all its tetrahedra are in; empty if there are none
  std::vector<PointBits> relevant;
  std::vector<Block> blocks;
};

// Keeps the last one, for another model with the same inputs.
class ContactRestMemory {
 public:
  std::shared_ptr<const ContactRest> of(const model::Model& model);

 private:
  struct Kept;
  std::shared_ptr<const Kept> kept_;
};

}  // namespace fascicle::cpu_reference
