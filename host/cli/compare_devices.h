// Validation of devices against each other and against the oracle, and its results.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/cli/exit_codes.h"
#include "host/model/model.h"
#include "host/model/validate.h"
#include "host/pipeline/build_scene.h"
#include "host/pipeline/device_choice.h"
#include "host/scene/scene.h"

namespace fascicle::cli {

// Largest distance allowed between a float solver and the oracle, and between an inexact device and the CPU,
// as a fraction of the body's largest extent.
//
// Each substep rounds a position by about 2^-24 of the working unit, which is within a factor of two of the
// body's extent: 6e-8. In a damped body errors die out; in an undamped one modes drift apart in phase,
// roughly in proportion to the number of substeps. The rotation adds 3e-5 degrees in a well-shaped region,
// but a thin or nearly flat one-ring barely determines its rotation, so float and double diverge sooner
// there. Measured: the bars of figures 6 to 8 stay below 3e-5 over 600 frames; TetGen's mesh of the bunny
// with edges from 0.9 to 21 mm reached 1.1e-4. 1e-3 leaves a factor of nine above the worst case seen. A
// wrong formula, weight or index moves the body by several percent.
inline constexpr double oracle_bound = 1e-3;

// Two devices run without a probe, as in a bake.
struct HashComparison {
  std::uint64_t frames = 0;
  std::optional<std::uint64_t> first_different_frame;
  std::uint64_t last_hash_a = 0, last_hash_b = 0;
};

// One device compared with the first of the list.
struct Comparison {
  std::string a, b;
  bool exact = true;                            // both devices are exact: compared bit by bit
  std::uint64_t values = 0;                     // stage outputs compared
  std::optional<model::Difference> difference;  // if exact
  HashComparison hashes;                        // if exact
  bool starts_differ = false;  // if exact: whether the states before frame 1 differ, e.g. after preroll
  model::Distance distance;    // if inexact
  double relative = 0.0;       // distance.largest relative to the extent
  bool holds() const;
};

struct OracleComparison {
  std::string device;
  model::Distance distance;
  double relative = 0.0;
  bool holds() const { return relative <= oracle_bound; }
};

struct Validation {
  std::uint64_t frames = 0, oracle_frames = 0;
  double extent = 0.0;  // m, the body's largest
  std::vector<Comparison> comparisons;
  std::vector<OracleComparison> oracle;
  bool holds() const;
};

// Runs `frames` frames on every device and compares each with the first; then compares `oracle_frames` frames
// (0: none) with the oracle. `on_frame` receives the current activity, its frame and its last frame. Throws
// bake::NotFinite if positions become non-finite.
Validation validate(
    const scene::Scene& scene, const Built& built, const model::SolverOptions& options,
    const std::vector<ChosenDevice>& devices, std::uint64_t frames, std::uint64_t oracle_frames,
    const std::function<void(const std::string& what, std::uint64_t frame, std::uint64_t frames)>& on_frame);

}  // namespace fascicle::cli
