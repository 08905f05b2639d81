// How a frame looks compared with skinning: what a viewer would object to, as numbers relative to their
// limits. 1 is the limit, above is too much. Everything is measured in double on the render mesh, once with
// flesh and once by skinning alone, and depends only on the frames.
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

// stretch   how many times longer a triangle of skin is along any direction than at rest or than under
//           skinning, whichever gives less: stretch and shear. A triangle thinner than the edges around it
//           counts relative to their length, because that is what is visible. 99.9th percentile.
// crossing  triangles that cross others that are not neighbours, if the skin of their two joints does not
//           cross under skinning in the same frame. Pairs that both follow the skeleton do not count.
// distance  of the skin from skinning, divided by the body's thickness there at rest: for the worst joint,
//           median or 90th percentile of its skin, whichever is further over its limit.
// rigid     parts that the rig moves rigidly: their strain from rest. 90th percentile of the worst part.
// jump      how much the skin's speed relative to skinning changes from one frame to the next, divided by
//           the body's thickness: |d(k) - 2 d(k-1) + d(k-2)|, median of the worst joint's skin. 0 in frames 0
//           and 1. A change of velocity moves skin by that change times the length of a frame, so below 60
//           frames a second the limit grows with that length; above, it stays constant, and a change that
//           takes two frames counts half.
// inverted  tetrahedra that are inside out; the limit is 1.2 times those that skinning inverts, plus a few.
enum class LookMeasure { stretch, crossing, distance, rigid, jump, inverted };
inline constexpr std::size_t look_measures = 6;
const char* name_of(LookMeasure measure);

// For LookMeasure::distance, in thicknesses of the body: for the median and for the farthest tenth of a
// joint's skin.
inline constexpr double half_distance_limit = 0.55, tenth_distance_limit = 1.0;
// A joint with fewer render vertices has no percentiles and is left out of measures by joint.
inline constexpr std::size_t least_skin_vertices = 12;

struct LookScore {
  double value = 0.0, limit = 1.0;  // in the measure's own units
  double score = 0.0;               // 1 if the value is at the limit
  std::uint32_t joint = 0;          // where it is worst
};

struct LookScores {
  std::array<LookScore, look_measures> of{};
  LookMeasure cause() const;  // the measure with the worst score
  const LookScore& worst() const { return of[static_cast<std::size_t>(cause())]; }
};

// Whether a look can be measured: the model has a render mesh and a skeleton.
bool has_look(const model::Model& model);
// For the scene's model, shared by all that measure a look; empty if there is no look to measure.
std::optional<LookBody> look_body_of(const scene::Scene& scene, const model::Model& model);

class Look {
 public:
  // Both must outlive it. `fps`: rate of the frames it will see.
  Look(const model::Model& model, const LookBody& body, double fps);

  // For a frame with positions and skinned. Frames must come in order: jumps are measured against the two
  // before.
  LookScores of(const model::Frame& frame);
  // Records a frame as a preceding one, without scoring it.
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
  // From vertices' values: for each joint the value that `share` of its skin exceed; returns the worst joint.
  LookScore worst_joint(const std::vector<double>& values, double share, double limit);

  const model::Model& model_;
  const LookBody& body_;
  double jump_limit_;
  TriangleTree tree_;
  std::vector<std::uint8_t> follows_;  // per triangle: whether it follows the skeleton
  std::vector<double> trust_;          // per triangle: least height over the edges around it, at most 1
  std::vector<std::vector<std::uint32_t>> vertices_;  // render vertices, by joint
  std::array<std::vector<float>, 3> deviation_;  // flesh minus skinning: now, one frame before, two before
  std::vector<std::pair<double, std::uint32_t>> values_;  // of the current measure, with their items
};

}  // namespace fascicle::bake
