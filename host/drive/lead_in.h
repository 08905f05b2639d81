// What is simulated before frame 0 and not written: preroll, settling, and the cycles that a seamless loop
// needs.
#pragma once

#include <functional>
#include <optional>

#include "host/drive/drive_source.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::drive {

// As reported in the manifest.
struct LeadInSummary {
  std::uint64_t preroll_frames = 0;
  std::uint64_t settle_frames = 0;
  std::optional<double> settled_speed;  // m/s, root mean square over the free vertices, after settling
  std::uint64_t cycles = 0;
  bool was_kept = false;       // taken from an earlier bake, not simulated now
  std::optional<double> jump;  // m: largest distance between a vertex's end and start in the last cycle
};

struct LeadIn {
  LeadInSummary summary;
  model::State state;    // before frame 1; its frame number is 0
  bool stopped = false;  // `stop` returned true; the state is then unusable
};

// Runs the solver through the lead-in. The same bits on every exact device; the solver is left in the state
// before frame 1. `stop` is called before each frame.
LeadIn lead_in(const scene::Scene& scene, const model::Model& model, DriveSource& drives,
               model::Solver& solver, const std::function<bool()>& stop = {});

// m, the largest distance of a vertex from its position in `state`, in the world.
double largest_distance(const model::Model& model, const std::vector<float>& positions,
                        const std::array<double, 3>& origin, const model::State& state);

}  // namespace fascicle::drive
