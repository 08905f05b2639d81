// Stage contact as CpuSolver runs it: the contacts and the bits of contact_stages.h, found by a shorter way.
//
// For each point a list holds the tetrahedra whose boxes come near its place, each with how far the two are
// from touching. No list changes until two vertices may have moved against each other by more than the lists'
// reach since they were made; until then a tetrahedron is looked at once its distance may have been bridged.
#pragma once

#include <cstdint>
#include <vector>

#include "cpu_reference/fields.h"
#include "cpu_reference/stages.h"
#include "cpu_reference/thread_pool.h"
#include "host/model/model.h"

namespace fascicle::cpu_reference {

class ContactSearch {
 public:
  // The model has contact and must outlive the search.
  explicit ContactSearch(const model::Model& model);

  // The whole stage: contact_found, contact_place, contact_impulse and pressed, and contact_crowd of vertices
  // that take part in a contact.
  void run(const SubstepInput& in, Fields& fields, ThreadPool& pool);

  // How often the lists were made, for measurements.
  std::uint64_t renewals() const { return renewals_; }

 private:
  struct Candidate {
    std::uint32_t tetrahedron;
    float distance;  // of the point from the tetrahedron's box, along the axis where it is farthest
  };
  struct Found {
    std::uint32_t tetrahedron, point;
    auto operator<=>(const Found&) const = default;
  };

  void look(const SubstepInput& in, const Fields& fields, ThreadPool& pool);
  float motion() const;
  void renew(ThreadPool& pool);
  void list_candidates(std::uint32_t point, const std::vector<float>& leaf_boxes,
                       const std::vector<float>& branch_boxes, std::vector<Candidate>& list) const;
  void find(Fields& fields, ThreadPool& pool);
  void press(const SubstepInput& in, Fields& fields);

  const model::Model& model_;
  float reach_;
  LineVector<float> sights_;       // 4 a vertex: where the stage looks for it
  LineVector<float> sights_then_;  // the same when the lists were made; empty before
  std::vector<float> motions_;     // 6 a part of the vertices: least and most of their motion since then
  std::vector<std::vector<Candidate>> lists_;  // of a part of the points
  std::vector<std::uint32_t> first_;           // of a point, in its part's list; one more a part
  std::vector<Found> found_;
  std::vector<std::uint32_t> touched_;  // vertices that pressed is not 0 of
  float motion_ = 0.0f;
  std::uint64_t renewals_ = 0;
};

}  // namespace fascicle::cpu_reference
