// Painting on a character: which vertices a brush reaches, and what it leaves on them.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/rig/character.h"
#include "host/rig/paint.h"

namespace fascicle::studio {

using rig::Vector3d;

// The render mesh that is painted on, in the bind pose, and what its own file has painted there.
class PaintGround {
 public:
  PaintGround(const mesh::SurfaceMesh& surface, std::vector<rig::PaintedAttribute> own);

  struct Reached {
    std::uint32_t vertex = 0;
    double distance = 0.0;  // m, from the place
  };
  // Vertices within the radius that hang together with the one next to the place: not what lies near across
  // air. That one is reached however small the radius is, up to `farthest` from the place.
  std::vector<Reached> reached(const Vector3d& place, double radius, double farthest) const;
  // From the place to the next vertex, m.
  double distance_to(const Vector3d& place) const;

  const std::string& hash() const { return hash_; }
  const mesh::SurfaceMesh& surface() const { return surface_; }
  const std::vector<rig::PaintedAttribute>& own() const { return own_; }
  // Of length 1, or 0 where the triangles around have no area.
  const Vector3d& normal(std::uint32_t vertex) const { return normal_[point_of_[vertex]]; }

 private:
  std::uint32_t nearest(const Vector3d& place) const;

  mesh::SurfaceMesh surface_;
  std::vector<rig::PaintedAttribute> own_;
  std::string hash_;
  // Vertices at one place are one point.
  std::vector<std::uint32_t> point_of_, vertex_offset_, vertex_;
  std::vector<Vector3d> place_, normal_;
  std::vector<std::uint32_t> neighbour_offset_, neighbour_;
};

// A character of the scene as the brush meets it.
struct PaintPlace {
  std::string key;                            // that names its paint file
  std::string name;                           // of the character; empty: the only one
  std::shared_ptr<const PaintGround> ground;  // in the space of its own file
  Vector3d offset = Vector3d::Zero();         // m: from that to where its bind pose stands in the scene's
  bool is_rigid = false;                      // it has no flesh, and is not painted
  bool operator==(const PaintPlace&) const = default;
};

// Which of them is under a place of the scene's bind pose; null without any.
const PaintPlace* place_under(std::span<const PaintPlace> places, const Vector3d& place);

// How much less a brush leaves towards its rim.
enum class Falloff { smooth, linear, constant };

struct Brush {
  const rig::PaintKind* kind = nullptr;
  float value = 0.0f;     // of a kind that is no direction
  double radius = 0.0;    // m
  double strength = 1.0;  // (0, 1]: share of the way to the value at the middle
  Falloff falloff = Falloff::smooth;
  bool is_mirrored = false;  // about x = 0
  bool erases = false;       // what its own file has is there again
};

// What is painted on a ground, while it is worked on.
class Painting {
 public:
  // The paint is of this ground.
  Painting(std::shared_ptr<const PaintGround> ground, const rig::Paint& paint);

  // `along`: the stroke's direction there, or 0: directions are then left as they are. Kinds of whole numbers
  // and _RIGID are there or not: strength and falloff are nothing to them.
  void stamp(const Brush& brush, const Vector3d& place, const Vector3d& along);
  rig::Paint paint() const;
  // Of all vertices, with what the character's own file has below.
  std::vector<float> shown(const rig::PaintKind& kind) const;
  // Whether anything is shown that differs from what holds without paint.
  bool has(const rig::PaintKind& kind) const;

 private:
  struct Sheet {
    std::vector<float> values;  // what is shown
    std::vector<char> is_set;   // of a vertex
    bool has_own = false;
  };
  void stamp_once(const Brush& brush, const Vector3d& place, const Vector3d& along, double farthest);
  void mix(const Brush& brush, std::uint32_t vertex, double share, const Vector3d& along);
  Sheet& sheet_of(const rig::PaintKind& kind);
  const Sheet& sheet_of(const rig::PaintKind& kind) const;
  float own_value(const rig::PaintKind& kind, std::uint32_t vertex, std::size_t component) const;

  std::shared_ptr<const PaintGround> ground_;
  std::vector<Sheet> sheets_;  // of each kind
};

}  // namespace fascicle::studio
