// The seam between the frame loop and the implementations: Oracle (double), CpuSolver and VulkanSolver
// (float, same bits).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "host/model/model.h"
#include "host/model/stages.h"
#include "shaders/shared.h"

namespace fascicle::model {

// Interleaves items of a_width and b_width floats, in the layout of stage_width for region (12 and 4) and
// integrate (3 and 3).
std::vector<float> side_by_side(std::span<const float> a, std::size_t a_width, std::span<const float> b,
                                std::size_t b_width);

struct SolverOptions {
  Integrator integrator = Integrator::explicit_step;
  Rotation rotation = Rotation::qcp;
  std::uint32_t iterations = 20;  // implicit integrator only, per substep
  double viscosity = 0.0;         // s, implicit integrator only: second_order_share in implicit.h
};

// Throws std::invalid_argument if the model was not built for the options' integrator.
void check_options(const Model& model, const SolverOptions& options);

// A map that leaves everything in place if rest origin and frame origin are the same.
inline constexpr shader::Bone bone_at_rest{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0};

// A break in the skeleton's motion, such as a cut or a teleport. Before the substep, all history is carried
// from the motion that ends to the one that begins, see carried(). Poses have joint_count bones and are one
// substep apart.
struct Cut {
  std::uint32_t substep = 0;                 // in the frame
  std::array<double, 3> origin{0, 0, 0};     // metres: origin of the new motion
  std::span<const shader::Bone> before, at;  // the old motion, a substep before the cut and at it
  std::span<const shader::Bone> to, after;   // the new motion, at the cut and a substep after it
};

// What moves the body through one frame. Every span holds substeps x count items, and need not live longer
// than the call of submit().
struct Drive {
  std::uint32_t substeps = 1;
  double h = 0.0;                               // s; solvers use float(h) and float(1/h)
  std::array<double, 3> origin{0, 0, 0};        // metres: what this frame's positions are relative to
  std::array<float, 3> origin_shift{0, 0, 0};   // origin less the last frame's origin, working units
  std::array<float, 3> gravity{0, 0, 0};        // working units / s^2, to which bones add their changes
  std::span<const shader::Bone> bones;          // joint_count per substep
  std::span<const shader::Muscle> muscles;      // muscle_count per substep
  std::span<const shader::Force> forces;        // force_count per substep
  std::span<const shader::Collider> colliders;  // collider_count per substep
  std::span<const float> decay;                 // exp(-damping h), one per layer (per frame, not per substep)
  std::span<const Cut> cuts = {};  // by ascending substep; up to the first cut, bones are relative to the
                                   // last frame's origin, and origin_shift is 0
};

// Throws std::invalid_argument if a drive's spans do not fit the model.
void check_drive(const Model& model, const Drive& drive);

// The frame's first substep for the float solvers: numbers rounded to float, first_* 0.
shader::Substep first_substep(const Model& model, const Drive& drive);

// Which buffers of a frame to read back.
struct Read {
  bool positions = false;
  bool velocities = false;
  bool surface = false;
  bool skinned = false;
};
inline Read operator|(Read a, Read b) {
  return {a.positions || b.positions, a.velocities || b.velocities, a.surface || b.surface,
          a.skinned || b.skinned};
}

struct Frame {
  std::uint64_t index = 0;  // submissions since the solver was made or loaded, counted from State::frame
  std::array<double, 3> origin{0, 0, 0};  // metres
  std::vector<float> positions;           // 3n, working units relative to origin, or empty
  std::vector<float> velocities;          // 3n, working units / s, or empty
  std::vector<float> surface;             // 3m, or empty
  std::vector<float> skinned = {};        // 3n: where skinning alone would put the vertices; empty without a
                                          // skeleton
};

// All history of a solver: save() then load() continues with the same bits.
struct State {
  std::uint64_t frame = 0;  // frames done
  std::array<double, 3> origin{0, 0, 0};
  std::vector<float> positions;   // 3n
  std::vector<float> velocities;  // 3n
  std::vector<float> rotations;   // 4n: quaternion w x y z of each region, where the next extraction starts
  std::vector<float> skinned;     // 3n: skinned positions of the last substep; empty without a skeleton
  std::vector<float> skinned_velocities = {};  // 3n, of the last substep; empty without Model::carried
  // Implicit only: positions and velocities before the last substep, and that substep's length. Empty and 0
  // if there was no substep yet or a cut came after it; then the next substep is backward Euler.
  std::vector<float> positions_before = {};   // 3n or empty, relative to `origin`
  std::vector<float> velocities_before = {};  // 3n or empty
  double step_before = 0.0;                   // s
  bool operator==(const State&) const = default;
};

// The state before the first frame: every vertex skinned to `pose` (joint_count bones; without a skeleton:
// the rest positions), at rest, with each rotation the one nearest to its vertex's blended bones. Computed in
// double, rounded once.
State initial_state(const Model& model, std::span<const shader::Bone> pose,
                    const std::array<double, 3>& origin);

// The state carried over a cut, computed in double and rounded once. With s and u a vertex's skinned position
// and velocity in the motion that ends, s' and u' in the one that begins, and R the rotation from the one
// nearest to the old blended bone map to the one nearest to the new,
//   q' = s' + R (q - s),   v' = u' + R (v - u),
// and the regions' rotations are turned by R: relative to the skeleton nothing changes. Positions and
// velocities before the last substep are cleared.
State carried(const Model& model, const State& state, double h, const Cut& cut);

// The state of the body at rest, before any state is loaded: every bone leaves its vertices in place.
State rest_state(const Model& model);

// Throws std::invalid_argument if a state's arrays do not fit the model.
void check_state(const Model& model, const State& state);

struct Where {
  std::uint64_t frame = 0;
  std::uint32_t substep = 0;
  Stage stage = Stage::skin;
  std::uint32_t iteration = 0;  // for region, goal and relax of an implicit substep
};

// Receives every stage's output of every substep. The span is valid until on_stage returns.
struct Probe {
  virtual ~Probe() = default;
  virtual void on_stage(const Where& where, std::span<const float> values) = 0;
};

struct Solver {
  virtual ~Solver() = default;
  // Queues a frame; several may be in flight. With a probe, stages run one by one and are shown in order
  // before submit returns; without a probe, an implementation may fuse them. Both give the same bits.
  virtual void submit(const Drive& drive, Read what, Probe* probe = nullptr) = 0;
  // The oldest frame not yet collected, with the buffers requested in its submit.
  virtual Frame collect() = 0;
  // State after all frames submitted so far.
  virtual State save() const = 0;
  // Replaces all history. Throws std::invalid_argument if the sizes do not fit the model.
  virtual void load(const State& state) = 0;
};

}  // namespace fascicle::model
