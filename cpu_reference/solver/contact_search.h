// Stage contact as CpuSolver runs it: the contacts and the bits of contact_stages.h, found by a shorter way.
//
// Points are taken in blocks that lie near each other, tetrahedra in the leaves of the plain search. Where
// the boxes of a block and a leaf overlap, the distance of each of the block's points to the leaf's
// tetrahedra is kept, as it was at a time in the past. As long as nothing in the two has moved by that much
// against each other since then, there is no contact between them. Most of a body's surface lies close to
// flesh that moves with it, and is done with by that.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "cpu_reference/solver/contact_meets.h"
#include "cpu_reference/solver/fields.h"
#include "cpu_reference/solver/stages.h"
#include "cpu_reference/solver/thread_pool.h"
#include "host/model/model.h"

namespace fascicle::cpu_reference {

class ContactSearch {
 public:
  // The model has contact and must outlive the search.
  explicit ContactSearch(const model::Model& model);

  // The whole stage: contact_found, contact_place, contact_impulse and pressed, and contact_crowd of vertices
  // that take part in a contact.
  void run(const SubstepInput& in, Fields& fields, ThreadPool& pool);

 private:
  // Points that are taken together.
  static constexpr std::uint32_t block_size = 16;
  // A tetrahedron that was near to a point: its number in the leaf, and how far the two were apart at least.
  struct Candidate {
    std::uint32_t number;
    float distance;
  };
  // A block and a leaf. The candidates of each point, nearest first; what a point may meet in the leaf beside
  // them was no nearer than `others`.
  struct Pair {
    std::uint32_t leaf = 0;
    float nearest = 0.0f;  // of all points
    float others = 0.0f;
    std::array<std::uint16_t, block_size + 1> first{};
    std::vector<Candidate> candidates;
  };
  struct Block {
    std::vector<Pair> pairs;      // by ascending leaf
    std::uint64_t looked_at = 0;  // pairs of a point and a tetrahedron that had come too near to be left out
  };
  struct Found {
    std::uint32_t tetrahedron, point;
    auto operator<=>(const Found&) const = default;
  };

  void look(const SubstepInput& in, const Fields& fields, ThreadPool& pool);
  bool is_due() const;
  void find(Fields& fields, ThreadPool& pool);
  void find_in_block(std::uint32_t block, Fields& fields);
  void find_in_pair(std::uint32_t block, const Pair& pair, Fields& fields);
  Pair make_pair(std::uint32_t block, std::uint32_t leaf) const;
  Place sight_of(std::uint32_t vertex) const;
  Place motion_of(std::uint32_t vertex) const;
  void press(const SubstepInput& in, Fields& fields);

  const model::Model& model_;
  std::vector<std::uint32_t> order_;                      // points, block by block
  std::vector<std::uint32_t> leaf_offset_, leaf_vertex_;  // the vertices of each leaf
  LineVector<float> sights_;                              // 4 a vertex: where the stage looks for it
  LineVector<float> sights_then_;                         // the same at the time of the distances
  std::vector<Block> blocks_;
  // Six floats a box: where a leaf, a branch and a block are; where leaves were then; how far leaves and
  // blocks have moved since.
  std::vector<float> leaf_box_, branch_box_, leaf_box_then_, leaf_motion_;
  std::uint64_t runs_since_ = 0;
  bool has_distances_ = false;
  std::vector<Found> found_;
  std::vector<std::uint32_t> touched_;  // vertices that pressed is not 0 of
};

}  // namespace fascicle::cpu_reference
