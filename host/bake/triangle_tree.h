// A bounding volume hierarchy over triangles whose corners move: built once, refitted to each frame. It finds
// triangles that cross, and the first hit of a ray.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "host/model/boxes.h"

namespace fascicle::bake {

class TriangleTree {
 public:
  // `triangles`: 3 vertex numbers each. `positions`: 3 values per vertex. `places`: one per vertex; triangles
  // that share a place are neighbours. `places` is read only here; the other arrays must outlive the tree.
  TriangleTree(std::span<const std::uint32_t> triangles, std::span<const std::uint32_t> places,
               std::span<const float> positions);

  // Refits to new positions; the order of the triangles in the tree stays.
  void fit(std::span<const float> positions);

  // Pairs of triangles that cross and are not neighbours, the lower number first, in unspecified order.
  // Triangles that only touch do not cross. Flags are one per triangle, or empty. `asked`: only pairs with
  // both flagged; `known`: no pairs with both flagged.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> crossings(
      std::span<const std::uint8_t> asked = {}, std::span<const std::uint8_t> known = {}) const;

  // The distance, in lengths of `direction`, to the first triangle without this place; empty if none is hit.
  std::optional<double> hit(const std::array<double, 3>& from, const std::array<double, 3>& direction,
                            std::uint32_t without_place) const;

 private:
  // An inner node's children are the next node and `second`; a leaf has second 0.
  struct Node {
    model::Box box{};
    std::uint32_t second = 0, first_triangle = 0, last_triangle = 0;
  };

  std::uint32_t build(std::uint32_t first, std::uint32_t last, const std::vector<float>& centres);
  // For triangles by their rank in the tree's order.
  bool neighbours(std::uint32_t a, std::uint32_t b) const;
  bool cross(std::uint32_t a, std::uint32_t b) const;
  std::vector<std::uint8_t> nodes_with(std::span<const std::uint8_t> flags, std::uint8_t flag) const;
  std::array<double, 3> corner(std::uint32_t triangle, std::size_t k) const;

  std::span<const std::uint32_t> triangles_;
  std::span<const float> positions_;
  std::vector<std::uint32_t> order_;                         // triangles, leaf by leaf
  std::vector<model::Box> boxes_;                            // per triangle, in that order
  std::vector<std::array<std::uint32_t, 3>> corner_places_;  // likewise
  std::vector<Node> nodes_;
};

}  // namespace fascicle::bake
