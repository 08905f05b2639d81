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
    fields.contact_box.resize(6 * std::size_t{model.contact_leaf_count()});
    fields.contact_branch_box.resize(6 * std::size_t{model.contact_branch_count()});
    fields.contact_found.assign(model.contact.size(), shader::no_contact);
    fields.contact_place.resize(10 * model.contact.size());
    fields.contact_range.resize(2 * std::size_t{model.contact_block_count()});
    fields.contact_blocks.resize(2 * std::size_t{model.contact_leaf_count()});
    fields.contact_crowd.resize(model.vertex_count);
    fields.contact_impulse.resize(3 * model.contact.size());
    fields.pressed.resize(vector_stride * n);
  }
  fields.surface.resize(3 * std::size_t{model.surface_count()});
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
