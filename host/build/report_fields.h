// The fields of a Report and of its members, for a byte archive. A missing field is a compile error.
#pragma once

#include <concepts>
#include <type_traits>

#include "host/build/build.h"

namespace fascicle::build {

// T is Of or const Of.
template <class T, class Of>
concept Is = std::same_as<std::remove_const_t<T>, Of>;

template <class Visit, class... Fields>
void visit_each(Visit& visit, Fields&... fields) {
  (visit(fields), ...);
}

template <Is<Warning> T, class Visit>
void for_each_field(T& warning, Visit& visit) {
  auto& [text, vertices, is_of_flesh, is_of_gravity] = warning;
  visit_each(visit, text, vertices, is_of_flesh, is_of_gravity);
}

template <Is<JointReport> T, class Visit>
void for_each_field(T& report, Visit& visit) {
  auto& [name, parent, share, openness, is_bone, ends_chain, is_kinematic, reason] = report;
  visit_each(visit, name, parent, share, openness, is_bone, ends_chain, is_kinematic, reason);
}

template <Is<RigidReport> T, class Visit>
void for_each_field(T& report, Visit& visit) {
  auto& [name, joint, reason, vertices] = report;
  visit_each(visit, name, joint, reason, vertices);
}

template <Is<FibreReport> T, class Visit>
void for_each_field(T& report, Visit& visit) {
  auto& [constraints, rounds, iterations, edges, flipped_edges, bent_edges, without, seconds] = report;
  visit_each(visit, constraints, rounds, iterations, edges, flipped_edges, bent_edges, without, seconds);
}

template <Is<LayerShare> T, class Visit>
void for_each_field(T& share, Visit& visit) {
  auto& [name, vertices, volume, mass, youngs_modulus] = share;
  visit_each(visit, name, vertices, volume, mass, youngs_modulus);
}

template <Is<Finding> T, class Visit>
void for_each_field(T& finding, Visit& visit) {
  auto& [count, vertices] = finding;
  visit_each(visit, count, vertices);
}

template <Is<Spread> T, class Visit>
void for_each_field(T& spread, Visit& visit) {
  auto& [low, high] = spread;
  visit_each(visit, low, high);
}

template <Is<SurfaceFindings> T, class Visit>
void for_each_field(T& findings, Visit& visit) {
  auto& [parts, loose_vertices, flat_triangles, open_edges, non_manifold_edges, non_manifold_vertices,
         turned_edges, inverted_parts, intersections, genus] = findings;
  visit_each(visit, parts, loose_vertices, flat_triangles, open_edges, non_manifold_edges,
             non_manifold_vertices, turned_edges, inverted_parts, intersections, genus);
}

template <Is<OpenEnds> T, class Visit>
void for_each_field(T& ends, Visit& visit) {
  auto& [vertex, edges, joint, width, fate] = ends;
  visit_each(visit, vertex, edges, joint, width, fate);
}

template <Is<CageReport> T, class Visit>
void for_each_field(T& cage, Visit& visit) {
  auto& [has_skin, is_cage, reason, findings, ends, skin_volume, skin_spacing, spacing, edges, alpha, offset,
         cut_tetrahedra, wrap_seconds, fill_seconds, cut_seconds] = cage;
  visit_each(visit, has_skin, is_cage, reason, findings, ends, skin_volume, skin_spacing, spacing, edges,
             alpha, offset, cut_tetrahedra, wrap_seconds, fill_seconds, cut_seconds);
}

template <Is<FillReport> T, class Visit>
void for_each_field(T& fill, Visit& visit) {
  auto& [riders, least_weight, cage] = fill;
  visit_each(visit, riders, least_weight, cage);
}

template <Is<Report> T, class Visit>
void for_each_field(T& report, Visit& visit) {
  auto& [vertices, tetrahedra, surface_vertices, surface_triangles, volume, mass, mean_edge, shortest_edge,
         longest_edge, flipped_tetrahedra, region_fallbacks, vertex_fallbacks, skipped_regions,
         pinned_vertices, fill, joints, rigid_parts, bone_islands_before, bone_islands, bone_vertices_added,
         fibres, layers, warnings, body_from_cache, is_kept, seconds] = report;
  visit_each(visit, vertices, tetrahedra, surface_vertices, surface_triangles, volume, mass, mean_edge,
             shortest_edge, longest_edge, flipped_tetrahedra, region_fallbacks, vertex_fallbacks,
             skipped_regions, pinned_vertices, fill, joints, rigid_parts, bone_islands_before, bone_islands,
             bone_vertices_added, fibres, layers, warnings, body_from_cache, is_kept, seconds);
}

}  // namespace fascicle::build
