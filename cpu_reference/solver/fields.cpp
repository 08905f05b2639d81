#include "cpu_reference/solver/fields.h"

#include <algorithm>

namespace fascicle::cpu_reference {

void size_fields(const model::Model& model, Fields& fields) {
  const std::size_t n = std::size_t{slice_count(model.vertex_count)} * slice_size;
  fields.vertices.resize(vertex_stride * n);
  fields.regions.resize(region_stride * n);
  fields.velocities.resize(vector_stride * n);
  if (model.has_skeleton()) {
    for (Floats* field : {&fields.skinned, &fields.skinned_before, &fields.gravity})
      field->resize(vector_stride * n);
    if (!model.carried.empty()) fields.skinned_velocities.resize(vector_stride * n);
  }
  if (model.has_ties()) fields.tied.resize(vector_stride * n);
  if (model.is_implicit())
    for (Floats* field : {&fields.positions_before, &fields.velocities_before, &fields.iterate_before,
                          &fields.predicted, &fields.goals})
      field->resize(vector_stride * n);
  if (model.has_limits()) {
    fields.lack.resize(model.limit.size());
    fields.some_lack.resize(slice_count(static_cast<std::uint32_t>(model.limit.size())));
    fields.term_place.resize(model.limit.size());
    fields.load.resize(model.vertex_count);
  }
  if (model.has_contact()) {
    fields.contact_found.assign(model.contact.size(), shader::no_contact);
    fields.contact_place.resize(10 * model.contact.size());
    fields.contact_crowd.resize(model.vertex_count);
    fields.contact_impulse.resize(3 * model.contact.size());
  }
  fields.surface.resize(3 * std::size_t{model.surface_count()});
}

void size_plain_contact_fields(const model::Model& model, Fields& fields) {
  fields.contact_box.resize(6 * std::size_t{model.contact_leaf_count()});
  fields.contact_branch_box.resize(6 * std::size_t{model.contact_branch_count()});
  fields.contact_first.resize(model.contact_tetrahedron_count());
  fields.contact_next.resize(model.contact.size());
}

Column vectors_of(const Floats& field) {
  return {field, vector_stride, 0, 3};
}

Column positions_of(const Fields& fields) {
  return {fields.vertices, vertex_stride, 0, 3};
}

Column rotations_of(const Fields& fields) {
  return {fields.regions, region_stride, rotation_place, 4};
}

namespace {

// The linear map row by row, then the translation.
std::vector<Column> transforms_of(const Fields& fields) {
  const auto part = [&](std::size_t place, std::size_t width) {
    return Column{fields.regions, region_stride, place, width};
  };
  return {part(0, 3), part(4, 3), part(8, 3), part(3, 1), part(7, 1), part(11, 1)};
}

}  // namespace

std::vector<Column> columns_of(const Fields& fields, model::Field field) {
  using model::Field;
  switch (field) {
    case Field::position:
      return {positions_of(fields)};
    case Field::velocity:
      return {vectors_of(fields.velocities)};
    case Field::rotation:
      return {rotations_of(fields)};
    case Field::transform:
      return transforms_of(fields);
    case Field::goal:
      return {vectors_of(fields.goals)};
    case Field::skinned:
      return {vectors_of(fields.skinned)};
    case Field::skinned_before:
      return {vectors_of(fields.skinned_before)};
    case Field::skinned_velocity:
      return {vectors_of(fields.skinned_velocities)};
    case Field::gravity:
      return {vectors_of(fields.gravity)};
    case Field::surface:
      return {{fields.surface, 3, 0, 3}};
    case Field::position_before:
      return {vectors_of(fields.positions_before)};
    case Field::velocity_before:
      return {vectors_of(fields.velocities_before)};
    case Field::predicted:
      return {vectors_of(fields.predicted)};
    case Field::iterate_before:
      return {vectors_of(fields.iterate_before)};
    case Field::tied:
      return {vectors_of(fields.tied)};
    case Field::lack:
      return {{fields.lack, 1, 0, 1}};
    case Field::limit_load:
      return {{fields.load, 1, 0, 1}};
    case Field::contact_crowd:
      return {{fields.contact_crowd, 1, 0, 1}};
    case Field::contact_impulse:
      return {{fields.contact_impulse, 3, 0, 3}};
    case Field::contact_box:
    case Field::contact_branch_box:
    case Field::contact_found:
    case Field::contact_place:
    case Field::contact_first:
    case Field::contact_next:
      break;
  }
  return {};
}

std::vector<float> gathered(std::uint32_t count, std::span<const Column> columns) {
  std::size_t width = 0;
  for (const Column& column : columns) width += column.width;
  std::vector<float> values(count * width);
  std::size_t place = 0;
  for (const Column& column : columns) {
    const float* from = column.field.data() + column.place;
    float* to = values.data() + place;
    for (std::uint32_t i = 0; i < count; ++i, from += column.stride, to += width)
      std::copy_n(from, column.width, to);
    place += column.width;
  }
  return values;
}

void scatter(std::span<const float> values, std::size_t width, Floats& field, std::size_t stride,
             std::size_t place) {
  float* to = field.data() + place;
  for (std::size_t from = 0; from < values.size(); from += width, to += stride)
    std::copy_n(values.data() + from, width, to);
}

}  // namespace fascicle::cpu_reference
