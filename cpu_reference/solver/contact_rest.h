// What stage contact's search (contact_search.h) finds once, of the rest shape. It takes as long as some
// frames.
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
  // A bit a point of a block.
  using PointBits = std::uint16_t;
  // A leaf some of whose tetrahedra lie near some of a block's points at rest.
  struct Near {
    std::uint32_t leaf;
    std::size_t first;  // of `relevant`, one a tetrahedron
  };
  struct Block {
    PointBits points = 0, mobile = 0;
    std::uint32_t ignored = 0;  // groups that none of the points meets
    std::vector<Near> near;     // by ascending leaf
  };

  // The model has contact.
  explicit ContactRest(const model::Model& model);

  std::vector<std::uint32_t> order, order_vertex;       // points, block by block; their vertices
  std::vector<std::uint32_t> leaf_offset, leaf_vertex;  // the vertices of each leaf
  std::vector<std::uint8_t> leaf_corner;                // of each corner, which of its leaf's vertices it is
  std::vector<char> leaf_is_held;                       // none of its vertices can move by itself
  std::vector<std::uint32_t> leaf_group;  // groups that all its tetrahedra are of; empty without any
  std::vector<PointBits> relevant;
  std::vector<Block> blocks;
};

// Keeps the last one, for the next model that differs in nothing that it follows from.
class ContactRestMemory {
 public:
  std::shared_ptr<const ContactRest> of(const model::Model& model);

 private:
  struct Kept;
  std::shared_ptr<const Kept> kept_;
};

}  // namespace fascicle::cpu_reference
