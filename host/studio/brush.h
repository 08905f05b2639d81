// Painting on a character: which vertices a brush reaches, and what it changes there.
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

// The render mesh to paint on, in the bind pose, and what the character's file already has painted.
class PaintGround {
 public:
  PaintGround(const mesh::SurfaceMesh& surface, std::vector<rig::PaintedAttribute> own);

  struct Reached {
    std::uint32_t vertex = 0;
    double distance = 0.0;  // m, from the centre
  };
  // Vertices within the radius that are connected with the nearest one, so paint does not jump across gaps.
  // The nearest one is reached however small the radius is, up to `farthest` from the place.
  std::vector<Reached> reached(const Vector3d& place, double radius, double farthest) const;
  // The number of vertices within the radius, connected or not.
  std::size_t count_within(const Vector3d& place, double radius) const;
  // From the place to the nearest vertex, m.
  double distance_to(const Vector3d& place) const;

  const std::string& hash() const { return hash_; }
  const mesh::SurfaceMesh& surface() const { return surface_; }
  const std::vector<rig::PaintedAttribute>& own() const { return own_; }
  // Unit length, or 0 if the surrounding triangles have no area.
  const Vector3d& normal(std::uint32_t vertex) const { return normal_[point_of_[vertex]]; }

 private:
  std::uint32_t nearest(const Vector3d& place) const;

  mesh::SurfaceMesh surface_;
  std::vector<rig::PaintedAttribute> own_;
  std::string hash_;
  // Vertices at the same position form one point.
  std::vector<std::uint32_t> point_of_, vertex_offset_, vertex_;
  std::vector<Vector3d> place_, normal_;
  std::vector<std::uint32_t> neighbour_offset_, neighbour_;
};

// A character of the scene that can be painted.
struct PaintPlace {
  std::string key;                            // the key that names its paint file
  std::string name;                           // the character's; empty: the only one
  std::shared_ptr<const PaintGround> ground;  // in its file's space
  Vector3d offset = Vector3d::Zero();         // m: from its file's space to its bind pose in the scene
  bool is_rigid = false;                      // has no flesh, and cannot be painted
  bool operator==(const PaintPlace&) const = default;
};

// The character nearest to a place in the scene's bind pose; null if there is none.
const PaintPlace* place_under(std::span<const PaintPlace> places, const Vector3d& place);

// How the brush weakens towards its rim.
enum class Falloff { smooth, linear, constant };

struct Brush {
  const rig::PaintKind* kind = nullptr;
  float value = 0.0f;     // unless the kind is a direction
  double radius = 0.0;    // m
  double strength = 1.0;  // (0, 1]: fraction of the change to the value, at the centre
  Falloff falloff = Falloff::smooth;
  bool is_mirrored = false;  // at the plane x = 0
  bool erases = false;       // restores what the character's file has
};

// Limit on the vertices that the brush reaches at the places of one message, all together: about a second's
// work.
inline constexpr std::size_t most_reached = std::size_t{1} << 25;
// Whether the brush may reach more. `places`: in the scene's bind pose.
bool reaches_too_many(const Brush& brush, std::span<const PaintPlace> grounds,
                      std::span<const std::array<double, 3>> places);

// Paint being edited.
class Painting {
 public:
  // `paint` must be for this ground.
  Painting(std::shared_ptr<const PaintGround> ground, const rig::Paint& paint);

  // `along`: the stroke's direction there, or 0 to leave directions unchanged. Integer kinds and _RIGID
  // ignore strength and falloff.
  void stamp(const Brush& brush, const Vector3d& place, const Vector3d& along);
  rig::Paint paint() const;
  // Values of all vertices; those of the character's file where nothing is painted.
  std::vector<float> shown(const rig::PaintKind& kind) const;
  // Whether any value differs from the unpainted default.
  bool has(const rig::PaintKind& kind) const;

 private:
  struct Sheet {
    std::vector<float> values;  // as shown
    std::vector<char> is_set;   // per vertex
    bool has_own = false;
  };
  void stamp_once(const Brush& brush, const Vector3d& place, const Vector3d& along, double farthest);
  void mix(const Brush& brush, std::uint32_t vertex, double share, const Vector3d& along);
  Sheet& sheet_of(const rig::PaintKind& kind);
  const Sheet& sheet_of(const rig::PaintKind& kind) const;
  float own_value(const rig::PaintKind& kind, std::uint32_t vertex, std::size_t component) const;

  std::shared_ptr<const PaintGround> ground_;
  std::vector<Sheet> sheets_;  // per kind
};

}  // namespace fascicle::studio
