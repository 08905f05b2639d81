// What is stepped before frame 0 and not written: the preroll, the settling, and the cycles that a seamless
// loop needs.
#pragma once

#include <functional>
#include <optional>

#include "host/drive/drive_source.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::drive {

// What the manifest says of it.
struct LeadInSummary {
  std::uint64_t preroll_frames = 0;
  std::uint64_t settle_frames = 0;
  std::optional<double> settled_speed;  // m/s, root mean square over the free vertices, after settling
  std::uint64_t cycles = 0;
  bool was_kept = false;       // taken from an earlier bake, not stepped now
  std::optional<double> jump;  // m: how far a vertex ended from where it began in the last of them
};

struct LeadIn {
  LeadInSummary summary;
  model::State state;    // before frame 1; its frame is 0
  bool stopped = false;  // `stop` asked for it; the state is then unusable
};

// Steps the solver through all of it. The same bits on every exact device; the solver's own state is that
// before frame 1 afterwards. `stop` is asked before each frame.
LeadIn lead_in(const scene::Scene& scene, const model::Model& model, DriveSource& drives,
               model::Solver& solver, const std::function<bool()>& stop = {});

// m, the largest distance of a vertex from where it is in `state`, in the world.
double largest_distance(const model::Model& model, const std::vector<float>& positions,
                        const std::array<double, 3>& origin, const model::State& state);

}  // namespace fascicle::drive
