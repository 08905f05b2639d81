// Stage contact as CpuSolver runs it: finds the contacts of contact_stages.h, with the same bits, in less
// time.
//
// Points are grouped in blocks of near neighbours, tetrahedra in the leaves of the plain search. While the
// boxes of a block and a leaf overlap, the search keeps a lower bound on the distance of the block's points
// from the boxes of the leaf's tetrahedra, along any axis, and an upper bound on how much nearer the two may
// have come since. As long as the difference is positive there is no contact between them. Most of a body's
// surface is close to flesh that moves with it, and needs no more than that. Points and tetrahedra within the
// margin at rest are excluded from the start.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "cpu_reference/solver/contact_lanes.h"
#include "cpu_reference/solver/contact_meets.h"
#include "cpu_reference/solver/contact_rest.h"
#include "cpu_reference/solver/fields.h"
#include "cpu_reference/solver/stages.h"
#include "cpu_reference/solver/thread_pool.h"
#include "host/model/model.h"

namespace fascicle::cpu_reference {

class ContactSearch {
 public:
  // The model must have contact and outlive the search. `rest` is the model's.
  ContactSearch(const model::Model& model, const ContactLanes& lanes,
                std::shared_ptr<const ContactRest> rest);

  // Finds the contacts: contact_found, and contact_place and contact_crowd of everything that takes part in
  // one. If memory runs out, the search starts anew the next time.
  void find(Fields& fields, ThreadPool& pool);
  // Runs a kernel of the response on the contacts found last: for each of them, or for each vertex that takes
  // part.
  void run(model::Kernel kernel, const SubstepInput& in, Fields& fields, ThreadPool& pool);
  static bool runs(model::Kernel kernel);

 private:
  static constexpr std::uint32_t block_size = ContactRest::block_size, leaf_size = ContactRest::leaf_size;
  using PointBits = ContactRest::PointBits;
  using LeafBits = std::uint32_t;  // one bit per tetrahedron of a leaf
  static constexpr std::uint32_t nothing = ~std::uint32_t{0};

  // A block and a leaf that were tested.
  struct alignas(64) Pair {
    std::array<std::uint16_t, leaf_size> apart{};  // as in ContactLook
  };
  // A block and the leaves of a branch, while their boxes overlap. Per leaf: as in ContactApproach; the index
  // of the pair, or `nothing`.
  struct Branch {
    std::uint32_t number = 0;
    std::array<float, shader::contact_branch> nearest{}, gone{};
    std::array<std::uint32_t, shader::contact_branch> pair{};
  };
  struct Block {
    const ContactRest::Block* rest = nullptr;
    std::vector<Branch> branches;  // in ascending order of number
    std::vector<Pair> pairs;
    std::vector<const PointBits*> relevant;  // for each pair, as in ContactLook
    std::vector<std::uint32_t> unused;       // indices of free pairs
  };
  // A block in the current substep.
  struct Sight;
  struct Found {
    std::uint32_t tetrahedron, point;
    bool operator<(const Found& other) const {
      return std::pair(tetrahedron, point) < std::pair(other.tetrahedron, other.point);
    }
  };

  std::uint32_t block_begin(std::size_t block) const {
    return static_cast<std::uint32_t>(block) * block_size;
  }
  std::uint32_t block_end(std::size_t block) const;
  std::uint32_t leaf_end(std::uint32_t leaf) const;

  void look(const Fields& fields, ThreadPool& pool);
  void forget();
  ContactBounds bounds_of(const std::uint32_t* vertices, std::uint32_t count) const;
  void bound_branch(std::uint32_t branch);
  void find_in_block(std::uint32_t block, Fields& fields);
  static void drop(Block& block, std::size_t branch);
  void find_in_branch(Branch& branch, Sight& sight, Fields& fields);
  void find_in_leaf(Branch& branch, std::uint32_t leaf, Sight& sight, Fields& fields);
  std::uint32_t make_pair(Block& block, std::uint32_t leaf) const;
  void crowd(Fields& fields);
  void list_shares(const Fields& fields);
  Place sum_of_impulses(const Fields& fields, std::size_t touched) const;
  // Whether no point of the block may meet any tetrahedron of the leaf, according to the scene.
  bool is_ignored(const Block& block, std::uint32_t leaf) const {
    return !rest_->leaf_group.empty() && (block.rest->ignored & rest_->leaf_group[leaf]) != 0;
  }

  const model::Model& model_;
  const ContactLanes& lanes_;
  std::shared_ptr<const ContactRest> rest_;
  std::vector<Block> blocks_;
  LineVector<float> sights_, sights_before_;  // 4 per vertex: positions in this substep and the previous one
  // Boxes in the layout of ContactLanes: of leaves, their positions and motions, branch by branch; of
  // branches.
  LineVector<float> leaf_box_, leaf_motion_, branch_box_;
  std::vector<Found> found_;
  // A vertex's share in a contact: 1 in its own, minus its weight in one in its tetrahedra.
  struct Share {
    std::uint32_t point;
    float weight;
  };
  std::vector<std::uint32_t> touched_;      // vertices that take part in contacts
  std::vector<std::uint32_t> place_;        // for each vertex its index in touched_, or `nothing`
  std::vector<std::uint32_t> first_share_;  // for each vertex in touched_, and the count
  std::vector<Share> shares_;               // in the order of the kernels' sums
};

}  // namespace fascicle::cpu_reference
