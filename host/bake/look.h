// How a frame looks beside skinning: what a viewer would object to, as numbers over their limits. 1 is the
// limit, above is too much. Everything is measured in double on the render mesh, once with flesh and once by
// skinning alone, and depends only on the frames.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/bake/look_body.h"
#include "host/bake/triangle_tree.h"
#include "host/model/model.h"
#include "host/model/solver.h"

namespace fascicle::bake {

// stretch   how many times longer a triangle of skin is along any direction than at rest and than under
//           skinning, whichever it is nearer to: stretch and shear. A triangle thinner than the edges around
//           it counts by their length: what it moves by is then what is seen. 99.9th percentile.
// crossing  triangles that cross others, no neighbours, of two joints whose skin does not cross under
//           skinning in the same frame. Two triangles that both follow the skeleton cross there too.
// distance  of the skin from skinning, over the body's thickness there at rest: of the worst joint half of
//           its skin, or a tenth, whichever is further over its limit.
// rigid     parts that the rig moves rigidly: their strain from rest. 90th percentile of the worst part.
// jump      how much skin's speed relative to skinning changes from one frame to the next, by the body's
//           thickness: |d(k) - 2 d(k-1) + d(k-2)|, of the worst joint half of its skin. 0 in frames 0 and 1.
//           A change of velocity moves skin by it times the length of a frame, so below 60 frames a second
//           the limit grows with that length; above, it stays, and a change that takes two frames counts
//           half.
// inverted  tetrahedra that are inside out; the limit is 1.2 times those that skinning turns, and a few.
enum class LookMeasure { stretch, crossing, distance, rigid, jump, inverted };
inline constexpr std::size_t look_measures = 6;
const char* name_of(LookMeasure measure);

// Of LookMeasure::distance, body's thicknesses: the farther half of a joint's skin, and its farthest tenth.
inline constexpr double half_distance_limit = 0.55, tenth_distance_limit = 1.0;
// A joint with fewer render vertices has no percentiles; its skin is not looked at by joint.
inline constexpr std::size_t least_skin_vertices = 12;

struct LookScore {
  double value = 0.0, limit = 1.0;  // as the measure has them
  double score = 0.0;               // 1 where the value is the limit
  std::uint32_t joint = 0;          // where it is worst
};

struct LookScores {
  std::array<LookScore, look_measures> of{};
  LookMeasure cause() const;  // of the worst score
  const LookScore& worst() const { return of[static_cast<std::size_t>(cause())]; }
};

// Whether there is something to look at and to look beside: a render mesh and a skeleton.
bool has_look(const model::Model& model);
// Of the scene's model, for all that looks at it; nothing where there is no look to take.
std::optional<LookBody> look_body_of(const scene::Scene& scene, const model::Model& model);

class Look {
 public:
  // Both must outlive it. `fps`: of the frames that it will see.
  Look(const model::Model& model, const LookBody& body, double fps);

  // Of a frame with positions and skinned. Frames must come in order: jumps are seen against the two before.
  LookScores of(const model::Frame& frame);
  // Takes a frame as one before, without its scores.
  void remember(const model::Frame& frame);

 private:
  void shift_history();
  LookScore stretch(const std::vector<float>& flesh, const std::vector<float>& skin);
  LookScore crossing(const std::vector<float>& flesh, const std::vector<float>& skin);
  LookScore distance();
  LookScore rigid(const std::vector<float>& flesh);
  LookScore jump();
  LookScore inverted(const model::Frame& frame) const;
  std::uint32_t joint_of_triangle(std::size_t triangle) const;
  // Of the vertices' values, by joint: the largest of the values that the share of a joint's skin lies above.
  LookScore worst_joint(const std::vector<double>& values, double share, double limit);

  const model::Model& model_;
  const LookBody& body_;
  double jump_limit_;
  TriangleTree tree_;
  std::vector<std::uint8_t> follows_;  // of a triangle: whether only what follows the skeleton carries it
  std::vector<double> trust_;          // of a triangle: its least height over the edges around it, at most 1
  std::vector<std::vector<std::uint32_t>> vertices_;  // render vertices, by joint
  std::array<std::vector<float>, 3> deviation_;       // flesh less skinning: now, a frame before, two before
  std::vector<std::pair<double, std::uint32_t>> values_;  // of the measure in hand, with what has them
};

}  // namespace fascicle::bake
