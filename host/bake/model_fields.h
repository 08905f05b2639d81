// Every field of a Model, in one list: the model's hash and the model's file both go through it, so a field
// that is added here is in both.
#pragma once

#include "host/model/model.h"

namespace fascicle::bake {

// Calls visit(name, field) for each field, in a fixed order. Lists of structs are shown as their length
// (visit.count, which may change the list's size when the model is being read) and then element by element.
// visit.optional is for arrays that most models lack: an empty one leaves no trace, neither in the hash nor
// in the file.
template <class ModelType, class Visitor>
void visit_fields(ModelType& model, Visitor& visit) {
  visit("unit", model.unit);
  visit("rest_origin", model.rest_origin);
  visit("weight_form", model.weight_form);
  visit("momentum_scaled", model.momentum_scaled);
  visit("vertex_count", model.vertex_count);
  visit("source_vertex", model.source_vertex);
  visit("rest", model.rest);
  visit("mass", model.mass);
  visit("alpha", model.alpha);
  visit("youngs_modulus", model.youngs_modulus);
  visit("stiffness", model.stiffness);
  visit("beta", model.beta);
  visit("fibre", model.fibre);
  visit("tag", model.tag);
  visit.count("layers", model.layers);
  for (auto& layer : model.layers) {
    visit("layer.name", layer.name);
    visit("layer.damping", layer.damping);
    visit("layer.density", layer.density);
    visit("layer.kinematic", layer.kinematic);
    visit("layer.frequency", layer.frequency);
  }
  visit("ring_offset", model.ring_offset);
  visit("ring", model.ring);
  visit("pull", model.pull);
  visit("share_taken", model.share_taken);
  visit("share_given", model.share_given);
  visit("region_rest", model.region_rest);
  visit("muscle_count", model.muscle_count);
  visit.optional("muscle_offset", model.muscle_offset);
  visit.optional("region_muscle", model.region_muscle);
  visit.optional("region_frame", model.region_frame);
  visit.optional("volume_gain", model.volume_gain);
  visit.optional("region_volume", model.region_volume);
  visit.optional("tie", model.tie);
  visit.optional("tie_offset", model.tie_offset);
  visit.optional("tie_index", model.tie_index);
  visit.optional("tie_coefficient", model.tie_coefficient);
  visit.optional("limit", model.limit);
  visit.optional("limit_offset", model.limit_offset);
  visit.optional("limit_entry", model.limit_entry);
  visit.optional("mobility", model.mobility);
  visit("joint_count", model.joint_count);
  visit("skin_offset", model.skin_offset);
  visit("skin_joint", model.skin_joint);
  visit("skin_weight", model.skin_weight);
  visit("carried", model.carried);
  visit("force_count", model.force_count);
  visit("force_offset", model.force_offset);
  visit("force_index", model.force_index);
  visit("force_coefficient", model.force_coefficient);
  visit("surface_vertex", model.surface_vertex);
  visit("surface_weight", model.surface_weight);
  visit("surface_triangle", model.surface_triangle);
  visit("tetrahedron", model.tetrahedron);
  visit.count("probes", model.probes);
  for (auto& probe : model.probes) {
    visit("probe.name", probe.name);
    visit("probe.vertices", probe.vertices);
  }
}

}  // namespace fascicle::bake
