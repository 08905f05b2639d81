// What makes up a substep: stages, the kernels that implement them, and the fields that kernels read and
// write. Each is an enumeration with a table, one row per value in the same order; solvers derive what they
// need to know about a stage from its rows. substep_plan.h defines the order in which they run.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <string_view>

#include "host/model/model.h"
#include "shaders/buffers.h"

namespace fascicle::model {

// The stages of a substep, in order; embed runs once, after a frame's last substep. The same word names the
// shader (region.comp), the kernel (kernel/region.inc), and the test. Some stages run only in models that
// need them: skin with a skeleton, tie with ties, limit with limits, collide with colliders (last in an
// explicit substep), contact with contact; contacts are found before predict. An implicit substep runs
// region, goal, relax and contact once per iteration; an explicit one has no relax. In both, flesh in contact
// responds once more after integrate.
enum class Stage { skin, tie, predict, region, goal, relax, limit, collide, integrate, contact, embed };

// Kernels in the order of an implicit substep, except contact_hold to contact. The same word names the
// shader. lack, crowd and limit belong to stage limit, obstruct and collide to stage collide, and those with
// contact in their names to stage contact: contact_press and contact run in an explicit substep, contact_hold
// and contact_yield in an implicit iteration, contact_settle and contact_rest after the iterations. update
// and iterate are fused from other kernels, with the same bits.
enum class Kernel : std::uint8_t {
  rebase,
  skin,
  tie,
  contact_bound,
  contact_enclose,
  contact_find,
  contact_chain,
  contact_crowd,
  contact_hold,
  contact_yield,
  contact_settle,
  contact_rest,
  contact_press,
  contact,
  predict,
  region,
  goal,
  relax,
  obstruct,
  lack,
  crowd,
  limit,
  collide,
  integrate,
  update,   // predict, goal and integrate of an explicit substep
  iterate,  // goal and relax of an implicit one
  embed,
};

// State that changes from substep to substep. Each field is a buffer of shaders/buffers.h and an array, or a
// part of one, of cpu_reference/solver/fields.h. There, an explicit substep keeps predict's velocities in
// `predicted`.
enum class Field : std::uint8_t {
  position,
  velocity,
  rotation,
  transform,
  goal,
  skinned,
  skinned_before,
  skinned_velocity,
  gravity,
  surface,
  position_before,
  velocity_before,
  predicted,
  iterate_before,
  tied,
  lack,
  limit_load,
  contact_box,
  contact_branch_box,
  contact_found,
  contact_place,
  contact_first,
  contact_next,
  contact_crowd,
  contact_impulse,
};

struct FieldSet {
  std::uint32_t bits = 0;
  constexpr FieldSet() = default;
  constexpr FieldSet(std::initializer_list<Field> fields) {
    for (const Field f : fields) bits |= 1U << static_cast<std::uint32_t>(f);
  }
  constexpr bool has(Field f) const { return (bits >> static_cast<std::uint32_t>(f) & 1U) != 0; }
  constexpr bool empty() const { return bits == 0; }
  constexpr FieldSet operator|(FieldSet other) const { return of(bits | other.bits); }
  constexpr FieldSet operator&(FieldSet other) const { return of(bits & other.bits); }
  constexpr FieldSet without(FieldSet other) const { return of(bits & ~other.bits); }
  constexpr bool operator==(const FieldSet&) const = default;

 private:
  static constexpr FieldSet of(std::uint32_t bits) {
    FieldSet set;
    set.bits = bits;
    return set;
  }
};

// What a kernel runs over: one invocation, or one turn of a loop, per item.
enum class KernelItems : std::uint8_t {
  vertices,
  limits,
  surface,
  contact_leaves,
  contact_branches,
  contact_points,
  contact_tetrahedra
};

// Properties of a field in every implementation.
struct FieldTraits {
  Field field;
  const char* name;
  std::uint32_t buffer;  // of shaders/buffers.h
  std::uint32_t bytes;   // per item of that buffer
  // Floats per item as shown to a probe; 0: never shown. The GPU's items may hold more.
  std::uint32_t floats;
  KernelItems items;
  bool (Model::*is_kept)() const = nullptr;  // models for which the GPU keeps it; null: all with items
};
inline constexpr FieldTraits field_rows[] = {
    {Field::position, "position", shader::buffer_position, 16, 3, KernelItems::vertices},
    {Field::velocity, "velocity", shader::buffer_velocity, 16, 3, KernelItems::vertices},
    {Field::rotation, "rotation", shader::buffer_rotation, 16, 4, KernelItems::vertices},
    {Field::transform, "transform", shader::buffer_transform, 48, 12, KernelItems::vertices},
    {Field::goal, "goal", shader::buffer_goal, 16, 3, KernelItems::vertices},
    {Field::skinned, "skinned", shader::buffer_skinned, 16, 3, KernelItems::vertices, &Model::has_skeleton},
    {Field::skinned_before, "skinned_before", shader::buffer_skinned_before, 16, 3, KernelItems::vertices,
     &Model::has_skeleton},
    {Field::skinned_velocity, "skinned_velocity", shader::buffer_skinned_velocity, 16, 3,
     KernelItems::vertices, &Model::has_carried},
    {Field::gravity, "gravity", shader::buffer_gravity, 16, 3, KernelItems::vertices, &Model::has_skeleton},
    {Field::surface, "surface", shader::buffer_surface, 12, 3, KernelItems::surface},
    {Field::position_before, "position_before", shader::buffer_position_before, 16, 3, KernelItems::vertices,
     &Model::is_implicit},
    {Field::velocity_before, "velocity_before", shader::buffer_velocity_before, 16, 3, KernelItems::vertices,
     &Model::is_implicit},
    {Field::predicted, "predicted", shader::buffer_predicted, 16, 3, KernelItems::vertices,
     &Model::is_implicit},
    {Field::iterate_before, "iterate_before", shader::buffer_iterate_before, 16, 3, KernelItems::vertices,
     &Model::is_implicit},
    {Field::tied, "tied", shader::buffer_tied, 16, 3, KernelItems::vertices, &Model::has_ties},
    {Field::lack, "lack", shader::buffer_lack, 4, 1, KernelItems::limits},
    {Field::limit_load, "limit_load", shader::buffer_limit_load, 4, 1, KernelItems::vertices,
     &Model::has_limits},
    {Field::contact_box, "contact_box", shader::buffer_contact_box, 32, 0, KernelItems::contact_leaves},
    {Field::contact_branch_box, "contact_branch_box", shader::buffer_contact_branch_box, 32, 0,
     KernelItems::contact_branches},
    {Field::contact_found, "contact_found", shader::buffer_contact_found, 4, 0, KernelItems::contact_points},
    {Field::contact_place, "contact_place", shader::buffer_contact_place, 48, 0, KernelItems::contact_points},
    {Field::contact_first, "contact_first", shader::buffer_contact_first, 4, 0,
     KernelItems::contact_tetrahedra},
    {Field::contact_next, "contact_next", shader::buffer_contact_next, 4, 0, KernelItems::contact_points},
    {Field::contact_crowd, "contact_crowd", shader::buffer_contact_crowd, 4, 1, KernelItems::vertices,
     &Model::has_contact},
    {Field::contact_impulse, "contact_impulse", shader::buffer_contact_impulse, 16, 3,
     KernelItems::contact_points},
};
inline constexpr std::uint32_t field_count = std::size(field_rows);

constexpr const FieldTraits& row_of(Field field) {
  return field_rows[static_cast<std::size_t>(field)];
}
constexpr std::string_view name_of(Field field) {
  return row_of(field).name;
}

// What a kernel may access, in any model. An invocation writes only its own item's values, so the items of
// one kernel may run in any order: a kernel never reads from other items a field that it writes.
//
// With an atomic exchange, an item may put its number in another item's slot and take the previous value. The
// order of these exchanges is not defined: readers process what they find in order of number.
struct KernelAccess {
  Kernel kernel;
  std::string_view name;  // the shader has the same name
  KernelItems items;
  FieldSet own;   // read at its own item
  FieldSet ring;  // read at its own item and in its one-ring
  FieldSet any;   // read anywhere
  FieldSet writes;
  FieldSet exchanged = {};  // those of `writes` exchanged at other items

  constexpr FieldSet reads() const { return own | ring | any | exchanged; }
};

inline constexpr FieldSet forces_on_vertex{Field::gravity, Field::tied};
inline constexpr FieldSet skin_motion{Field::skinned, Field::skinned_before, Field::skinned_velocity};
inline constexpr FieldSet history{Field::position_before, Field::velocity_before};

inline constexpr FieldSet predict_reads =
    forces_on_vertex | skin_motion | history | FieldSet{Field::position, Field::velocity};
// The implicit integrate also reads what relax wrote.
inline constexpr FieldSet integrate_reads =
    skin_motion.without({Field::skinned_velocity}) |
    FieldSet{Field::position, Field::velocity, Field::goal, Field::predicted};
inline constexpr FieldSet integrate_writes{Field::position, Field::velocity, Field::skinned_velocity};
inline constexpr FieldSet relax_reads{Field::position, Field::iterate_before, Field::predicted};
inline constexpr FieldSet relax_writes{Field::position, Field::iterate_before};

inline constexpr FieldSet contacts_of_vertex{Field::contact_found, Field::contact_place, Field::contact_first,
                                             Field::contact_next, Field::contact_impulse};

inline constexpr KernelAccess kernel_rows[] = {
    {Kernel::rebase,
     "rebase",
     KernelItems::vertices,
     {Field::position, Field::skinned, Field::position_before},
     {},
     {},
     {Field::position, Field::skinned, Field::position_before}},
    {Kernel::skin, "skin", KernelItems::vertices, {}, {}, {}, {Field::skinned, Field::gravity}},
    {Kernel::tie, "tie", KernelItems::vertices, {}, {}, {Field::position, Field::velocity}, {Field::tied}},
    {Kernel::contact_bound,
     "contact_bound",
     KernelItems::contact_leaves,
     {},
     {},
     {Field::position},
     {Field::contact_box, Field::contact_first}},
    {Kernel::contact_enclose,
     "contact_enclose",
     KernelItems::contact_branches,
     {},
     {},
     {Field::contact_box},
     {Field::contact_branch_box}},
    {Kernel::contact_find,
     "contact_find",
     KernelItems::contact_points,
     {},
     {},
     {Field::position, Field::contact_box, Field::contact_branch_box},
     {Field::contact_found, Field::contact_place}},
    {Kernel::contact_chain,
     "contact_chain",
     KernelItems::contact_points,
     {Field::contact_found},
     {},
     {},
     {Field::contact_first, Field::contact_next},
     {Field::contact_first}},
    {Kernel::contact_crowd,
     "contact_crowd",
     KernelItems::vertices,
     {},
     {},
     {Field::contact_found, Field::contact_place, Field::contact_first, Field::contact_next},
     {Field::contact_crowd}},
    {Kernel::contact_hold,
     "contact_hold",
     KernelItems::contact_points,
     {Field::contact_found, Field::contact_place},
     {},
     {Field::position, Field::position_before, Field::contact_crowd},
     {Field::contact_impulse}},
    {Kernel::contact_yield,
     "contact_yield",
     KernelItems::vertices,
     {Field::position, Field::goal},
     {},
     contacts_of_vertex,
     {Field::position, Field::goal}},
    {Kernel::contact_settle,
     "contact_settle",
     KernelItems::contact_points,
     {Field::contact_found, Field::contact_place, Field::contact_impulse},
     {},
     {Field::velocity, Field::velocity_before, Field::contact_crowd},
     {Field::contact_impulse}},
    {Kernel::contact_rest,
     "contact_rest",
     KernelItems::vertices,
     {Field::velocity},
     {},
     contacts_of_vertex,
     {Field::velocity}},
    {Kernel::contact_press,
     "contact_press",
     KernelItems::contact_points,
     {Field::contact_found, Field::contact_place},
     {},
     {Field::velocity, Field::contact_crowd},
     {Field::contact_impulse}},
    {Kernel::contact,
     "contact",
     KernelItems::vertices,
     {Field::position, Field::velocity},
     {},
     contacts_of_vertex,
     {Field::position, Field::velocity}},
    {Kernel::predict,
     "predict",
     KernelItems::vertices,
     predict_reads,
     {},
     {},
     history | FieldSet{Field::position, Field::velocity, Field::predicted, Field::iterate_before}},
    {Kernel::region,
     "region",
     KernelItems::vertices,
     {Field::rotation},
     {Field::position},
     {},
     {Field::rotation, Field::transform}},
    {Kernel::goal, "goal", KernelItems::vertices, {}, {Field::transform}, {}, {Field::goal}},
    {Kernel::relax,
     "relax",
     KernelItems::vertices,
     relax_reads | FieldSet{Field::goal},
     {},
     {},
     relax_writes},
    {Kernel::obstruct,
     "obstruct",
     KernelItems::vertices,
     {Field::position, Field::position_before},
     {},
     {},
     {Field::position}},
    {Kernel::lack,
     "lack",
     KernelItems::limits,
     {},
     {},
     {Field::position, Field::position_before},
     {Field::lack}},
    {Kernel::crowd,
     "crowd",
     KernelItems::vertices,
     {Field::position},
     {},
     {Field::lack},
     {Field::limit_load, Field::iterate_before}},
    {Kernel::limit,
     "limit",
     KernelItems::vertices,
     {Field::position, Field::predicted, Field::goal, Field::velocity},
     {},
     {Field::iterate_before, Field::lack, Field::limit_load},
     {Field::position, Field::predicted, Field::goal, Field::velocity}},
    {Kernel::collide,
     "collide",
     KernelItems::vertices,
     history | FieldSet{Field::position, Field::velocity, Field::predicted, Field::goal},
     {},
     {},
     history | FieldSet{Field::position, Field::velocity, Field::predicted, Field::goal}},
    {Kernel::integrate, "integrate", KernelItems::vertices, integrate_reads, {}, {}, integrate_writes},
    {Kernel::update,
     "update",
     KernelItems::vertices,
     forces_on_vertex | skin_motion | FieldSet{Field::position, Field::velocity},
     {Field::transform},
     {},
     integrate_writes},
    {Kernel::iterate,
     "iterate",
     KernelItems::vertices,
     relax_reads,
     {Field::transform},
     {},
     relax_writes | FieldSet{Field::goal}},
    {Kernel::embed, "embed", KernelItems::surface, {}, {}, {Field::position}, {Field::surface}},
};
inline constexpr std::uint32_t kernel_count = std::size(kernel_rows);

constexpr const KernelAccess& access_of(Kernel kernel) {
  return kernel_rows[static_cast<std::size_t>(kernel)];
}
constexpr std::string_view name_of(Kernel kernel) {
  return access_of(kernel).name;
}

// The fields shown to a probe side by side when a stage is done.
struct ShownFields {
  constexpr ShownFields(std::initializer_list<Field> of) : count(of.size()) {
    std::copy(of.begin(), of.end(), fields.begin());
  }
  constexpr const Field* begin() const { return fields.data(); }
  constexpr const Field* end() const { return fields.data() + count; }

  std::array<Field, 2> fields{};
  std::size_t count;
};

struct StageRow {
  Stage stage;
  const char* name;
  ShownFields shown;
};
inline constexpr StageRow stage_rows[] = {
    {Stage::skin, "skin", {Field::skinned, Field::gravity}},  // gravity: its change by the bones
    {Stage::tie, "tie", {Field::tied}},
    {Stage::predict, "predict", {Field::predicted}},  // explicit: velocity including external forces
    {Stage::region, "region", {Field::transform, Field::rotation}},
    {Stage::goal, "goal", {Field::goal}},
    {Stage::relax, "relax", {Field::position}},
    {Stage::limit, "limit", {Field::position}},
    {Stage::collide, "collide", {Field::position}},
    {Stage::integrate, "integrate", {Field::position, Field::velocity}},
    {Stage::contact, "contact", {Field::position, Field::velocity}},
    {Stage::embed, "embed", {Field::surface}},
};

inline constexpr auto all_stages = [] {
  std::array<Stage, std::size(stage_rows)> stages{};
  for (std::size_t k = 0; k < stages.size(); ++k) stages[k] = stage_rows[k].stage;
  return stages;
}();

constexpr const StageRow& row_of(Stage stage) {
  return stage_rows[static_cast<std::size_t>(stage)];
}
constexpr const char* name_of(Stage stage) {
  return row_of(stage).name;
}
constexpr const ShownFields& shown_by(Stage stage) {
  return row_of(stage).shown;
}

// The items of a stage's output.
constexpr KernelItems items_of(Stage stage) {
  return row_of(*shown_by(stage).begin()).items;
}

// Floats per item of the stage's output, over all its fields. A transform is the linear map row by row (9),
// then the translation (3); a rotation is w x y z.
constexpr std::uint32_t stage_width(Stage stage) {
  std::uint32_t width = 0;
  for (const Field field : shown_by(stage)) width += row_of(field).floats;
  return width;
}

// Guarantees of the tables.
namespace rows {

template <class Row, std::size_t count, class Value>
constexpr bool are_in_order(const Row (&rows)[count], Value Row::*value) {
  for (std::size_t k = 0; k < count; ++k)
    if (static_cast<std::size_t>(rows[k].*value) != k) return false;
  return true;
}
static_assert(are_in_order(field_rows, &FieldTraits::field), "a field has no row, or at another place");
static_assert(are_in_order(kernel_rows, &KernelAccess::kernel), "a kernel has no row, or at another place");
static_assert(are_in_order(stage_rows, &StageRow::stage), "a stage has no row, or at another place");

constexpr bool fields_have_rows() {
  return std::all_of(std::begin(kernel_rows), std::end(kernel_rows), [](const KernelAccess& row) {
    return (std::uint64_t{(row.reads() | row.writes).bits} >> field_count) == 0;
  });
}
static_assert(fields_have_rows() && field_count <= 32, "a kernel touches a field that has no row");

// Fields shown side by side have the same kind of items, and floats.
constexpr bool outputs_are_whole() {
  for (const StageRow& row : stage_rows)
    for (const Field field : row.shown)
      if (row_of(field).floats == 0 || row_of(field).items != items_of(row.stage)) return false;
  return true;
}
static_assert(outputs_are_whole(), "a stage shows fields that do not stand side by side");

constexpr bool items_are_independent() {
  return std::all_of(std::begin(kernel_rows), std::end(kernel_rows),
                     [](const KernelAccess& row) { return ((row.ring | row.any) & row.writes).empty(); });
}
static_assert(items_are_independent(), "a kernel reads of other items what it writes");

}  // namespace rows

}  // namespace fascicle::model
