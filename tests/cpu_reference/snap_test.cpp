// The device's treatment of denormals must have no effect: thanks to the snap alone, a whole solver gives the
// same bits with flush-to-zero and denormals-are-zero.
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "tests/support/test_models.h"

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace fascicle::cpu_reference_without_snap {
enum class Simd;  // the same as cpu_reference::Simd
struct SolverMemory;
std::unique_ptr<model::Solver> make_cpu_solver(const model::Model& model, const model::SolverOptions& options,
                                               unsigned threads, Simd simd, SolverMemory* memory);
}  // namespace fascicle::cpu_reference_without_snap

namespace fascicle::tests {

namespace {

#if defined(__x86_64__)

using cpu_reference::Simd;

// The solver with and without the snap.
struct WithSnap {
  static std::unique_ptr<model::Solver> make(const model::Model& model, Simd simd) {
    return cpu_reference::make_cpu_solver(model, {}, 1, simd);
  }
};
struct WithoutSnap {
  static std::unique_ptr<model::Solver> make(const model::Model& model, Simd simd) {
    return cpu_reference_without_snap::make_cpu_solver(
        model, {}, 1, static_cast<cpu_reference_without_snap::Simd>(simd), nullptr);
  }
};

// Sets flush-to-zero for results and denormals-are-zero for operands on this thread, as long as it exists.
class Flushing {
 public:
  explicit Flushing(bool on) : before_(_mm_getcsr()) {
    // Bit 15 of MXCSR flushes results, bit 6 treats denormal operands as zero (Intel SDM 1, 10.2.3).
    constexpr unsigned flush = 0x8040;
    _mm_setcsr(on ? before_ | flush : before_ & ~flush);
  }
  ~Flushing() { _mm_setcsr(before_); }
  Flushing(const Flushing&) = delete;
  Flushing& operator=(const Flushing&) = delete;

 private:
  unsigned before_;
};

// A bar that is pushed once. Every other vertex has no stiffness, and its motion decays below the smallest
// normal number, 2^-126: a substep leaves a quarter of a velocity, so 100 of them leave 2^-200. The others
// give the regions something to rotate.
template <class Solver>
std::vector<model::State> states(Simd simd, bool flush) {
  model::Model model = make_model(kuhn_bar(3, 2, 2, 0.25), {.alpha = 0.5f});
  for (std::uint32_t i = 0; i < model.vertex_count; i += 2) model.alpha[i] = 0.0f;
  fill_weights(model);
  TestDrive drive = quiet_drive(model, 1.0 / 240.0);
  for (float& decay : drive.decay) decay = 0.25f;
  const std::unique_ptr<model::Solver> solver = Solver::make(model, simd);
  model::State state = solver->save();
  for (std::size_t k = 0; k < state.velocities.size(); ++k)
    state.velocities[k] = 0.01f * static_cast<float>(k % 7) - 0.03f;
  solver->load(state);
  const Flushing flushing(flush);
  std::vector<model::State> seen;
  for (int frame = 0; frame < 100; ++frame) {
    solver->submit(drive.get(), {}, nullptr);
    solver->collect();
    seen.push_back(solver->save());
  }
  return seen;
}

TEST(SnapOfWholeStages, HidesWhetherTheDeviceFlushesDenormals) {
  for (const Simd simd : cpu_reference::available_simd())
    EXPECT_TRUE(states<WithSnap>(simd, true) == states<WithSnap>(simd, false)) << name_of(simd);
}

// The control: without the snap the difference is detected.
TEST(SnapOfWholeStages, WithoutItFlushingIsSeen) {
  for (const Simd simd : {Simd::scalar, Simd::baseline})
    EXPECT_FALSE(states<WithoutSnap>(simd, true) == states<WithoutSnap>(simd, false)) << name_of(simd);
}

#else

TEST(SnapOfWholeStages, HidesWhetherTheDeviceFlushesDenormals) {
  GTEST_SKIP()
      << "SKIPPED: the CPU is not an x86-64, and this test does not know how to make it flush denormals";
}

#endif

}  // namespace

}  // namespace fascicle::tests
