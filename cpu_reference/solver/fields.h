// What changes from substep to substep, in the layout that all stages of CpuSolver share: scalar stages read
// it number by number, stages in lanes four numbers at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <type_traits>
#include <vector>

#include "cpu_reference/solver/huge_pages.h"
#include "host/model/model.h"
#include "host/model/stages.h"

namespace fascicle::cpu_reference {

// Number of vertices that stages in lanes process together. Fields hold whole slices; values past the last
// vertex are finite and affect no vertex.
inline constexpr std::uint32_t slice_size = 16;

inline std::uint32_t slice_count(std::uint32_t vertices) {
  return vertices / slice_size + (vertices % slice_size != 0 ? 1 : 0);
}

// Allocates arrays aligned to cache lines, in `pages` if given.
template <class T>
struct LineAllocator {
  using value_type = T;
  using propagate_on_container_move_assignment = std::true_type;
  static constexpr std::align_val_t line{64};
  LineAllocator() = default;
  explicit LineAllocator(HugePages& from) : pages(&from) {}
  template <class U>
  LineAllocator(const LineAllocator<U>& other) : pages(other.pages) {}
  T* allocate(std::size_t count) {
    if (pages) return static_cast<T*>(pages->allocate(count * sizeof(T)));
    return static_cast<T*>(::operator new(count * sizeof(T), line));
  }
  void deallocate(T* values, std::size_t) {
    if (!pages) ::operator delete(values, line);
  }
  bool operator==(const LineAllocator&) const = default;

  HugePages* pages = nullptr;
};
template <class T>
using LineVector = std::vector<T, LineAllocator<T>>;
using Floats = LineVector<float>;

// Floats per vertex in each array, and the offsets of its parts.
inline constexpr std::size_t vertex_stride = 8, pull_place = 3, rest_place = 4, alpha_place = 7;
inline constexpr std::size_t region_stride = 16, rotation_place = 12;
inline constexpr std::size_t vector_stride = 4;

// Working units. Sizes below are per vertex; vectors are three floats and a 0.
struct Fields {
  explicit Fields(LineAllocator<float> from = {}) : memory(from) {}

  LineAllocator<float> memory;

  // 8: position; then constants of the model that only stages in lanes read: pull, rest position, alpha.
  Floats vertices{memory};
  // 16: the region's transform in rows, three of its linear map and one of the translation each, then its
  // rotation's quaternion w x y z.
  Floats regions{memory};
  Floats velocities{memory};          // 4
  Floats predicted{memory};           // 4: velocities with the external forces in; implicit: y
  Floats goals{memory};               // 4
  Floats skinned{memory};             // 4, empty without a skeleton
  Floats skinned_before{memory};      // 4, the same for the previous substep
  Floats skinned_velocities{memory};  // 4: u of the previous substep, empty if no stage needs it
  Floats gravity{memory};             // 4: change of gravity as the bones turn, empty without a skeleton
  Floats tied{memory};                // 4: accelerations by ties, empty without ties
  std::vector<float> surface;         // 3 per render vertex
  // Implicit models only, else empty.
  Floats positions_before{memory};   // 4, a substep earlier; from predict on, this one's start
  Floats velocities_before{memory};  // 4
  Floats iterate_before{memory};     // 4: the iterate before the last; in stage limit the pass's start
  // Models with limits only, else empty.
  std::vector<float> lack;  // 1 per Limit: the volume that it lacks
  // 1 per slice of the limits that stages in lanes tested last: whether any of them lacks volume.
  std::vector<std::uint8_t> some_lack;
  // For limits that lack volume: a Limit's index in `terms`; and the moves of its corners, 12 floats each.
  std::vector<std::uint32_t> term_place;
  std::vector<float> terms;
  std::vector<float> load;  // 1: number of the vertex's tetrahedra that lack volume, times its mobility
  // Models with contact only, else empty.
  std::vector<std::uint32_t> contact_found;  // 1 per ContactPoint
  std::vector<float> contact_place;          // 10 per point: weights, push, normal
  std::vector<float> contact_crowd;          // 1: S
  std::vector<float> contact_impulse;        // 3 per point: J
  // The same, only for the stage's plain form. Boxes are six floats: least, greatest.
  std::vector<float> contact_box, contact_branch_box;      // per leaf, per branch
  std::vector<std::uint32_t> contact_first, contact_next;  // 1 per tetrahedron, 1 per point
};

// Sizes all fields that the model's stages need without a probe, in whole slices.
void size_fields(const model::Model& model, Fields& fields);
// The same for the fields that only contact_stages.h needs.
void size_plain_contact_fields(const model::Model& model, Fields& fields);

// `width` floats of each of `count` items, `stride` apart in a field, starting at `place`.
struct Column {
  std::span<const float> field;
  std::size_t stride, place, width;
};
Column vectors_of(const Floats& field);
Column positions_of(const Fields& fields);
Column rotations_of(const Fields& fields);
// The columns of a field of the schedule, as probes see it; none if its row has no floats.
std::vector<Column> columns_of(const Fields& fields, model::Field field);
// The columns side by side without gaps, in the layout of State, Frame and Probe.
std::vector<float> gathered(std::uint32_t count, std::span<const Column> columns);
// The inverse, for one column of a field of `count` items.
void scatter(std::span<const float> values, std::size_t width, Floats& field, std::size_t stride,
             std::size_t place);

}  // namespace fascicle::cpu_reference
