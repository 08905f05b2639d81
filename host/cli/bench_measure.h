// What `fascicle bench` runs: bodies, a substep's time, the memory's rate, the process's size.
#pragma once

#include <cstdint>
#include <vector>

#include "host/cli/exit_codes.h"
#include "host/cli/log.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/pipeline/device_choice.h"

namespace fascicle::cli {

// A bar five times as long as thick, hung by its top end, about `vertices` vertices. With beta 0.7 along it,
// so that weights are a fibre's.
struct BenchBody {
  model::Model model;
  model::SolverOptions options;
  std::array<std::uint32_t, 3> grid{};  // vertices along each axis; of a filled one as it would be regular
};
enum class BenchMesh {
  regular,
  filled
};  // Kuhn's tetrahedra, jittered; or the mesher's inside their boundary
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

// Substeps of one sample: enough that a clock's and a thread's start do not count, at most 200.
std::uint32_t bench_substeps(std::uint32_t vertices, std::uint32_t passes, bool quick);

// The same of a device of unknown speed: as many as take about `seconds`, 2 to 4000, found by trying.
std::uint32_t substeps_in(double seconds, model::Solver& solver, const model::Model& model);

// Seconds that a frame takes, of which nothing is read back.
double timed_frame(model::Solver& solver, const model::Drive& drive);

// a = b + s c on arrays of 64 MiB on this many threads, GB/s: three words moved an element, the best of a few
// passes.
double triad_rate(unsigned threads);

// Of this process: what it holds now, and at most since the last reset; 0 where the system does not tell.
std::uint64_t resident_bytes();
std::uint64_t peak_resident_bytes();
void reset_peak();

}  // namespace fascicle::cli
