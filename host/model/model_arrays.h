// The table of a Model's members, one row each, in the order of model.h. Checking (model_check.cpp), hashing
// and the file (host/bake), byte counts, the GPU's buffers (gpu/model_buffers.cpp) and the arrays that
// vectorised stages see (cpu_reference/solver/lane_stages.h) follow from it. How to add an array:
// docs/architecture.md, "Adding a model array, adding a scene key".
//
// A member of Model without a row here does not compile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <tuple>
#include <type_traits>
#include <vector>

#include "host/base/fields.h"
#include "host/model/contact_depth.h"
#include "host/model/model.h"
#include "shaders/buffers.h"

namespace fascicle::model {

// A count derived from the model.
using Count = std::size_t (*)(const Model& model);

// Number of entries in an array: each x count(model) + more. Without a count: any multiple of `each`.
struct Items {
  Count count = nullptr;
  std::size_t each = 1;
  std::size_t more = 0;
};

enum class Promise {
  none,
  finite,
  range,     // within [low, high]
  factor,    // 0, or at least least_factor; at most high
  positive,  // finite and above 0
  index,     // below each x count(model)
  offsets,   // CSR offsets: begin with 0, do not fall, end with each x count(model)
};

// What holds for every entry of an array. check_model adds checks across several arrays.
struct Values {
  Promise promise = Promise::none;
  float low = 0.0f, high = 0.0f;
  Count count = nullptr;
  std::size_t each = 1;
};

enum class Needed { by_solvers, by_host };  // only the host needs metrics, export and reports
// In the model's file and hash. where_there: an array that most models lack leaves no trace if it is empty.
enum class Stored { always, where_there };

inline constexpr std::uint32_t no_buffer = std::numeric_limits<std::uint32_t>::max();

// The storage buffer (shaders/buffers.h) that holds the array on a GPU.
struct Buffer {
  std::uint32_t number = no_buffer;  // no_buffer: none, or gpu/model_buffers.cpp packs it with others
  bool as_vec4 = false;              // three numbers per item, padded to four there
};

// Properties of an array; the defaults suit most.
struct ArrayTraits {
  Items items = {};
  bool (*is_there)(const Model& model) = nullptr;  // if false, the array is empty; null: always true
  bool may_lack = false;                           // may be empty even if is_there
  Values values = {};
  Needed needed = Needed::by_solvers;
  Stored stored = Stored::always;
  Buffer buffer = {};
};

template <class T>
struct ArrayRow {
  const char* name;
  std::vector<T> Model::*member;
  ArrayTraits traits;
};
template <class T>
struct ValueRow {
  const char* name;
  T Model::*member;
};
// A list of structs with their own table.
template <class T, class Table>
struct ListRow {
  const char* name;
  std::vector<T> Model::*member;
  Table fields;
};
template <class Owner, class T>
struct FieldRow {
  const char* name;
  T Owner::*member;
};
template <class Owner, class T>
FieldRow(const char*, T Owner::*) -> FieldRow<Owner, T>;

inline constexpr std::tuple layer_fields{
    FieldRow{"layer.name", &Layer::name}, FieldRow{"layer.damping", &Layer::damping},
    FieldRow{"layer.density", &Layer::density}, FieldRow{"layer.kinematic", &Layer::kinematic},
    FieldRow{"layer.frequency", &Layer::frequency}};
static_assert(base::has_row_for_each_member<Layer, decltype(layer_fields)>,
              "a member of Layer has no row in layer_fields");

inline constexpr std::tuple probe_fields{FieldRow{"probe.name", &ProbeSet::name},
                                         FieldRow{"probe.vertices", &ProbeSet::vertices}};
static_assert(base::has_row_for_each_member<ProbeSet, decltype(probe_fields)>,
              "a member of ProbeSet has no row in probe_fields");

namespace rows {

template <class T>
consteval ArrayRow<T> array(const char* name, std::vector<T> Model::*member, const ArrayTraits& traits) {
  return {name, member, traits};
}
template <class T>
consteval ValueRow<T> value(const char* name, T Model::*member) {
  return {name, member};
}
template <class T, class Table>
consteval ListRow<T, Table> list(const char* name, std::vector<T> Model::*member, const Table& fields) {
  return {name, member, fields};
}

inline std::size_t vertices(const Model& m) {
  return m.vertex_count;
}
inline std::size_t joints(const Model& m) {
  return m.joint_count;
}
inline std::size_t forces(const Model& m) {
  return m.force_count;
}
inline bool has_colliders(const Model& m) {
  return m.has_colliders();
}
inline std::size_t surface_vertices(const Model& m) {
  return m.surface_count();
}
template <auto member>
std::size_t entries(const Model& m) {
  return (m.*member).size();
}

inline bool is_implicit(const Model& m) {
  return m.is_implicit();
}
inline bool has_muscles(const Model& m) {
  return m.muscle_count > 0;
}
inline bool has_volume(const Model& m) {
  return !m.volume_gain.empty() || !m.region_volume.empty();
}
inline bool has_ties(const Model& m) {
  return m.has_ties();
}
inline bool has_limits(const Model& m) {
  return m.has_limits();
}
inline bool has_contact(const Model& m) {
  return m.has_contact();
}
inline bool has_mobility(const Model& m) {
  return m.has_limits() || m.has_contact();
}
inline bool has_ignored_contact(const Model& m) {
  return m.has_ignored_contact();
}
inline std::size_t contact_tetrahedra(const Model& m) {
  return m.contact_tetrahedron_count();
}
inline std::size_t contact_boxes(const Model& m) {
  return m.contact_leaf_count() + m.contact_branch_count();
}
inline bool has_skeleton(const Model& m) {
  return m.has_skeleton();
}
inline bool has_forces(const Model& m) {
  return m.force_count > 0;
}

inline constexpr Items a_vertex{.count = vertices}, three_a_vertex{vertices, 3}, four_a_vertex{vertices, 4};
inline constexpr Items offsets_a_vertex{.count = vertices, .more = 1};

inline constexpr Values finite{.promise = Promise::finite}, positive{.promise = Promise::positive};
consteval Values within(float low, float high) {
  return {Promise::range, low, high};
}
consteval Values factor_up_to(float high) {
  return {Promise::factor, 0.0f, high};
}
consteval Values below(Count count, std::size_t each = 1) {
  return {.promise = Promise::index, .count = count, .each = each};
}
consteval Values offsets_into(Count count, std::size_t each = 1) {
  return {.promise = Promise::offsets, .count = count, .each = each};
}

}  // namespace rows

// clang-format off: a row a line where it fits.
inline constexpr auto model_arrays = [] {
  using namespace rows;
  constexpr Needed by_host = Needed::by_host;
  constexpr Stored where_there = Stored::where_there;
  return std::tuple{
      value("unit", &Model::unit), value("rest_origin", &Model::rest_origin),
      value("weight_form", &Model::weight_form), value("momentum_scaled", &Model::momentum_scaled),

      value("vertex_count", &Model::vertex_count),
      array("source_vertex", &Model::source_vertex, {.items = a_vertex, .needed = by_host}),
      array("rest", &Model::rest, {.items = three_a_vertex, .values = finite}),
      array("mass", &Model::mass, {.items = a_vertex, .values = positive, .needed = by_host}),
      // The explicit step is stable below 4; the paper's range is [0, 1].
      array("alpha", &Model::alpha,
            {.items = a_vertex, .values = factor_up_to(4.0f), .buffer = {shader::buffer_alpha}}),
      array("youngs_modulus", &Model::youngs_modulus,
            {.items = a_vertex, .is_there = is_implicit, .values = positive, .needed = by_host}),
      array("stiffness", &Model::stiffness,
            {.items = a_vertex, .is_there = is_implicit, .values = positive, .needed = by_host}),
      array("beta", &Model::beta, {.items = a_vertex, .values = within(0.0f, 1.0f), .needed = by_host}),
      array("fibre", &Model::fibre, {.items = three_a_vertex, .values = finite, .needed = by_host}),
      array("tag", &Model::tag, {.items = a_vertex}), list("layers", &Model::layers, layer_fields),

      array("ring_offset", &Model::ring_offset,
            {.items = offsets_a_vertex, .values = offsets_into(entries<&Model::ring>)}),
      array("ring", &Model::ring, {.values = below(vertices)}),

      array("pull", &Model::pull, {.items = a_vertex, .values = factor_up_to(3.0e38f)}),
      array("share_taken", &Model::share_taken,
            {.items = {entries<&Model::ring>}, .values = within(0.0f, 1.0f)}),
      array("share_given", &Model::share_given,
            {.items = {entries<&Model::ring>}, .values = within(0.0f, 1.0f)}),
      array("region_rest", &Model::region_rest,
            {.items = four_a_vertex, .values = finite, .buffer = {shader::buffer_region_rest}}),

      value("muscle_count", &Model::muscle_count),
      array("muscle_offset", &Model::muscle_offset,
            {.items = offsets_a_vertex,
             .is_there = has_muscles,
             .values = offsets_into(entries<&Model::region_muscle>),
             .stored = where_there,
             .buffer = {shader::buffer_muscle_offset}}),
      array("region_muscle", &Model::region_muscle,
            {.is_there = has_muscles, .stored = where_there, .buffer = {shader::buffer_region_muscle}}),
      array("region_frame", &Model::region_frame,
            {.items = a_vertex,
             .is_there = has_muscles,
             .stored = where_there,
             .buffer = {shader::buffer_region_frame}}),

      array("volume_gain", &Model::volume_gain,
            {.items = a_vertex,
             .is_there = has_volume,
             .values = within(0.0f, 1.0e3f),
             .needed = by_host,
             .stored = where_there}),
      array("region_volume", &Model::region_volume,
            {.items = three_a_vertex,
             .is_there = has_volume,
             .values = within(0.0f, 3.0e38f),
             .stored = where_there,
             .buffer = {shader::buffer_region_volume, true}}),

      array("tie", &Model::tie, {.stored = where_there, .buffer = {shader::buffer_tie}}),
      array("tie_offset", &Model::tie_offset,
            {.items = offsets_a_vertex,
             .is_there = has_ties,
             .values = offsets_into(entries<&Model::tie_index>),
             .stored = where_there,
             .buffer = {shader::buffer_tie_offset}}),
      array("tie_index", &Model::tie_index,
            {.is_there = has_ties,
             .values = below(entries<&Model::tie>),
             .stored = where_there,
             .buffer = {shader::buffer_tie_index}}),
      array("tie_coefficient", &Model::tie_coefficient,
            {.items = {entries<&Model::tie_index>},
             .is_there = has_ties,
             .values = within(least_factor, 0x1p40f),
             .stored = where_there,
             .buffer = {shader::buffer_tie_coefficient}}),

      array("limit", &Model::limit, {.stored = where_there, .buffer = {shader::buffer_limit}}),
      array("limit_offset", &Model::limit_offset,
            {.items = offsets_a_vertex,
             .is_there = has_limits,
             .values = offsets_into(entries<&Model::limit_entry>),
             .stored = where_there,
             .buffer = {shader::buffer_limit_offset}}),
      array("limit_entry", &Model::limit_entry,
            {.items = {entries<&Model::limit>, 4},
             .is_there = has_limits,
             .values = below(entries<&Model::limit>, 4),
             .stored = where_there,
             .buffer = {shader::buffer_limit_entry}}),
      array("mobility", &Model::mobility,
            {.items = a_vertex,
             .is_there = has_mobility,
             .values = factor_up_to(0x1p40f),
             .stored = where_there,
             .buffer = {shader::buffer_mobility}}),

      array("contact", &Model::contact, {.stored = where_there, .buffer = {shader::buffer_contact}}),
      array("contact_near", &Model::contact_near,
            {.is_there = has_contact, .stored = where_there, .buffer = {shader::buffer_contact_near}}),
      array("contact_tetrahedron", &Model::contact_tetrahedron,
            {.items = {.each = 4},
             .is_there = has_contact,
             .may_lack = true,
             .values = below(vertices),
             .stored = where_there,
             .buffer = {shader::buffer_contact_tetrahedron}}),
      array("contact_depth", &Model::contact_depth,
            {.items = {contact_depth_count},
             .is_there = has_contact,
             .values = factor_up_to(4.0f),
             .stored = where_there,
             .buffer = {shader::buffer_contact_depth}}),
      array("contact_number", &Model::contact_number,
            {.items = a_vertex,
             .is_there = has_contact,
             .stored = where_there,
             .buffer = {shader::buffer_contact_number}}),
      array("contact_offset", &Model::contact_offset,
            {.items = offsets_a_vertex,
             .is_there = has_contact,
             .values = offsets_into(entries<&Model::contact_entry>),
             .stored = where_there,
             .buffer = {shader::buffer_contact_offset}}),
      array("contact_entry", &Model::contact_entry,
            {.items = {entries<&Model::contact_tetrahedron>},
             .is_there = has_contact,
             .values = below(entries<&Model::contact_tetrahedron>),
             .stored = where_there,
             .buffer = {shader::buffer_contact_entry}}),
      array("contact_rest_box", &Model::contact_rest_box,
            {.items = {contact_boxes, 8},
             .is_there = has_contact,
             .values = finite,
             .stored = where_there,
             .buffer = {shader::buffer_contact_rest_box}}),
      array("contact_ignored", &Model::contact_ignored,
            {.items = {entries<&Model::contact>},
             .is_there = has_contact,
             .may_lack = true,
             .stored = where_there,
             .buffer = {shader::buffer_contact_ignored}}),
      array("contact_group", &Model::contact_group,
            {.items = {contact_tetrahedra},
             .is_there = has_ignored_contact,
             .stored = where_there,
             .buffer = {shader::buffer_contact_group}}),

      value("joint_count", &Model::joint_count),
      array("skin_offset", &Model::skin_offset,
            {.items = offsets_a_vertex,
             .is_there = has_skeleton,
             .values = offsets_into(entries<&Model::skin_joint>),
             .buffer = {shader::buffer_skin_offset}}),
      array("skin_joint", &Model::skin_joint,
            {.is_there = has_skeleton, .values = below(joints), .buffer = {shader::buffer_skin_joint}}),
      array("skin_weight", &Model::skin_weight,
            {.items = {entries<&Model::skin_joint>},
             .is_there = has_skeleton,
             .values = within(0.0f, 1.0f),
             .buffer = {shader::buffer_skin_weight}}),
      array("carried", &Model::carried,
            {.items = a_vertex,
             .is_there = has_skeleton,
             .may_lack = true,
             .values = within(least_carried, 1.0f),
             .buffer = {shader::buffer_carried}}),

      value("force_count", &Model::force_count),
      array("force_offset", &Model::force_offset,
            {.items = offsets_a_vertex,
             .is_there = has_forces,
             .values = offsets_into(entries<&Model::force_index>),
             .buffer = {shader::buffer_force_offset}}),
      array("force_index", &Model::force_index,
            {.is_there = has_forces, .values = below(forces), .buffer = {shader::buffer_force_index}}),
      array("force_coefficient", &Model::force_coefficient,
            {.items = {entries<&Model::force_index>},
             .is_there = has_forces,
             .values = finite,
             .buffer = {shader::buffer_force_coefficient}}),

      value("collider_count", &Model::collider_count),
      array("spared", &Model::spared,
            {.items = a_vertex,
             .is_there = has_colliders,
             .stored = where_there,
             .buffer = {shader::buffer_spared}}),

      array("surface_vertex", &Model::surface_vertex,
            {.items = {.each = 4}, .values = below(vertices), .buffer = {shader::buffer_surface_vertex}}),
      array("surface_weight", &Model::surface_weight,
            {.items = {entries<&Model::surface_vertex>},
             .values = finite,
             .buffer = {shader::buffer_surface_weight}}),
      array("surface_triangle", &Model::surface_triangle,
            {.items = {.each = 3}, .values = below(surface_vertices), .needed = by_host}),

      array("tetrahedron", &Model::tetrahedron,
            {.items = {.each = 4}, .values = below(vertices), .needed = by_host}),
      list("probes", &Model::probes, probe_fields)};
}();
// clang-format on

inline constexpr std::size_t model_member_count = std::tuple_size_v<decltype(model_arrays)>;
static_assert(base::has_row_for_each_member<Model, decltype(model_arrays)>,
              "a member of Model has no row in model_arrays, or not at its place");
static_assert(base::has_distinct_names(model_arrays));

template <class Row>
inline constexpr bool is_array_row = false;
template <class T>
inline constexpr bool is_array_row<ArrayRow<T>> = true;

// Calls use(row, values) for each array of the model, in the table's order, but not for single values and
// lists of structs.
template <class Use>
void for_each_array(const Model& model, const Use& use) {
  base::for_each_row(model_arrays, [&](const auto& row) {
    if constexpr (is_array_row<std::decay_t<decltype(row)>>) use(row, model.*row.member);
  });
}

// Calls visit for each member, in the table's order: visit(name, member), or visit.optional(name, array) for
// arrays stored only if not empty. For a list of structs, visit.count(name, list) first sees the length (and
// may change it when the model is being read), then visit(name, member) sees each member of each element.
template <class ModelType, class Visitor>
void visit_fields(ModelType& model, Visitor& visit) {
  base::for_each_row(model_arrays, [&](const auto& row) {
    auto& member = model.*row.member;
    if constexpr (is_array_row<std::decay_t<decltype(row)>>) {
      if (row.traits.stored == Stored::where_there)
        visit.optional(row.name, member);
      else
        visit(row.name, member);
    } else if constexpr (requires { row.fields; }) {
      visit.count(row.name, member);
      for (auto& element : member)
        base::for_each_row(row.fields, [&](const auto& field) { visit(field.name, element.*field.member); });
    } else {
      visit(row.name, member);
    }
  });
}

}  // namespace fascicle::model
