// What changes from substep to substep, in the layout that all stages of CpuSolver share: scalar ones read it
// number by number, those in lanes four numbers at a time.
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

// Vertices that stages in lanes take together. Fields hold whole slices; what lies past the last vertex is
// finite and reaches no vertex.
inline constexpr std::uint32_t slice_size = 16;

inline std::uint32_t slice_count(std::uint32_t vertices) {
  return vertices / slice_size + (vertices % slice_size != 0 ? 1 : 0);
}

// Numbers that begin at a cache line, in `pages` where given.
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

// Floats of a vertex in each array, and where its parts begin.
inline constexpr std::size_t vertex_stride = 8, pull_place = 3, rest_place = 4, alpha_place = 7;
inline constexpr std::size_t region_stride = 16, rotation_place = 12;
inline constexpr std::size_t vector_stride = 4;

// Working units. Sizes below are of one vertex; vectors are three floats and one that is 0.
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
  Floats skinned_before{memory};      // 4, the same of the substep before
  Floats skinned_velocities{memory};  // 4: u of the substep before, empty where no stage needs it
  Floats gravity{memory};             // 4: the bones' change of gravity, empty without a skeleton
  Floats tied{memory};                // 4: accelerations by ties, empty without
  std::vector<float> surface;         // 3 a render vertex
  // Of an implicit model, else empty.
  Floats positions_before{memory};   // 4, a substep before; from predict on where the substep began
  Floats velocities_before{memory};  // 4
  Floats iterate_before{memory};     // 4: the last iteration but one; in stage limit where a pass begins
  // Of a model with limits, else empty.
  std::vector<float> lack;  // 1 a Limit: the volume that it lacks
  // 1 a slice of the limits that stages in lanes looked at last: whether one of them lacks volume.
  std::vector<std::uint8_t> some_lack;
  // Of the limits that lack volume, what each moves its corners by, 12 floats; which of these are a Limit's.
  std::vector<std::uint32_t> term_place;
  std::vector<float> terms;
  std::vector<float> load;  // 1: how many of the vertex's tetrahedra lack volume, times its mobility
  // Of a model with contact, else empty.
  std::vector<std::uint32_t> contact_found;  // 1 a ContactPoint
  std::vector<float> contact_place;          // 10 a point: weights, push, normal
  std::vector<float> contact_crowd;          // 1: S
  std::vector<float> contact_impulse;        // 3 a point: J
  // The same, of the stage's plain form alone. Boxes are six floats: least, most.
  std::vector<float> contact_box, contact_branch_box;      // of a leaf, of a branch
  std::vector<std::uint32_t> contact_first, contact_next;  // 1 a tetrahedron, 1 a point
};

// Gives all fields that the model's stages need without a probe their sizes, in whole slices.
void size_fields(const model::Model& model, Fields& fields);
// The same for those that contact_stages.h has and CpuSolver does without.
void size_plain_contact_fields(const model::Model& model, Fields& fields);

// `width` floats of each of `count` items, `stride` apart in a field from `place` on.
struct Column {
  std::span<const float> field;
  std::size_t stride, place, width;
};
Column vectors_of(const Floats& field);
Column positions_of(const Fields& fields);
Column rotations_of(const Fields& fields);
// Where a field of the schedule stands, as a probe is shown it; none where its row has no floats.
std::vector<Column> columns_of(const Fields& fields, model::Field field);
// The columns side by side without gaps, as State, Frame and Probe have them.
std::vector<float> gathered(std::uint32_t count, std::span<const Column> columns);
// The other way for one column of a field of `count` items.
void scatter(std::span<const float> values, std::size_t width, Floats& field, std::size_t stride,
             std::size_t place);

}  // namespace fascicle::cpu_reference
