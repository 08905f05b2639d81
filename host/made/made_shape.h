// Bodies modelled in code: a smooth union of round cones along a skeleton, turned into an even, closed
// triangle mesh with skin weights. Uses only + - * / and sqrt, so that every machine produces the same bits.
#pragma once

#include <cstddef>
#include <vector>

#include "host/rig/character.h"

namespace fascicle::made {

using Eigen::Vector3d;

// A capsule whose radius changes linearly from one end to the other. Metres.
struct RoundCone {
  Vector3d from, to;
  double from_radius = 0.0, to_radius = 0.0;
  std::size_t joint = 0;  // the joint whose flesh it is
  double blend = 0.0;     // width of the fillet between it and all earlier parts
};

struct Sculpture {
  std::vector<RoundCone> parts;
  double floor = -1e30;  // the body is cut flat below this height, for soles
};

struct FieldSample {
  double distance = 0.0;  // < 0 inside; a bound on the distance to the surface where parts blend
  Vector3d gradient = Vector3d::Zero();
};
FieldSample sample_field(const Sculpture& sculpture, const Vector3d& point);

// The part whose own surface is nearest to a point or, if the point is inside, the one that contains it most
// deeply.
std::size_t nearest_part(const Sculpture& sculpture, const Vector3d& point);

// The surface: closed, manifold, facing outward, with edge lengths near `spacing` (their 99th percentile is
// below 2.5 times the 1st). Details thinner than two spacings are lost. Surface nets with a vertex for each
// sheet in a cell (Gibson 1998, Nielson 2004), symmetric in x, then Delaunay flips and tangential smoothing,
// projected back onto the field.
mesh::SurfaceMesh polygonise(const Sculpture& sculpture, double spacing);

struct PartMass {
  double mass = 0.0;  // volume, m^3
  Vector3d centre = Vector3d::Zero();
};
// The body's volume by joint, from samples `spacing` apart; `joints` is the number of joints.
std::vector<PartMass> masses_of_joints(const Sculpture& sculpture, std::size_t joints, double spacing);

// Computes the character's joints and weights from its surface and skeleton. Each vertex belongs to its
// nearest part's joint, and the weights diffuse along the skin, over a width that grows with the distance to
// that joint's bone (after "bone heat", Baran and Popovic 2007). At most 6 per vertex, with sum 1. Bones run
// from a joint to its child joints.
void bind_skin(const Sculpture& sculpture, rig::Character& character);

}  // namespace fascicle::made
