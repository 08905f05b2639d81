// Helpers of `fascicle bench`: bodies, time per substep, memory bandwidth, process size.
#pragma once

#include <cstdint>
#include <vector>

#include "host/cli/exit_codes.h"
#include "host/cli/log.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/pipeline/device_choice.h"

namespace fascicle::cli {

// A bar with about `vertices` vertices, five times as long as thick, hanging by its top end. Beta is 0.7
// along the bar, so that the weights depend on fibres.
struct BenchBody {
  model::Model model;
  model::SolverOptions options;
  std::array<std::uint32_t, 3> grid{};  // vertices along each axis; filled: those of the regular bar
};
enum class BenchMesh {
  regular,
  filled
};  // Kuhn's tetrahedra, jittered; or the mesher's, inside the same boundary
const char* name_of(BenchMesh mesh);
BenchBody bench_body(std::uint32_t vertices, model::Integrator integrator,
                     BenchMesh mesh = BenchMesh::regular);

// A frame of this body: `substeps` of 1/600 s under gravity.
class BenchDrive {
 public:
  BenchDrive(const model::Model& model, std::uint32_t substeps);
  model::Drive drive() const;

 private:
  std::uint32_t substeps_;
  std::array<float, 3> gravity_;
  std::vector<float> decay_;
};

// Substeps per sample, at most 200: enough that timer resolution and thread start-up do not matter.
std::uint32_t bench_substeps(std::uint32_t vertices, std::uint32_t passes, bool quick);

// The same for a device of unknown speed: finds, by trial, 2 to 4000 substeps that take about `seconds`.
std::uint32_t substeps_in(double seconds, model::Solver& solver, const model::Model& model);

// Seconds for one frame, without reading anything back.
double timed_frame(model::Solver& solver, const model::Drive& drive);

// a = b + s c on arrays of 64 MiB with this many threads, GB/s: three words moved per element, best of a few
// passes.
double triad_rate(unsigned threads);

// Memory of this process, now and at its peak since the last reset; 0 if unavailable.
std::uint64_t resident_bytes();
std::uint64_t peak_resident_bytes();
void reset_peak();

}  // namespace fascicle::cli
