// Runs under the Khronos validation layer with synchronization validation.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gpu/experiments.h"
#include "tests/gpu/validated.h"
#include "tests/support/bar_model.h"

namespace fascicle::tests {
namespace {

struct Ignore : model::Probe {
  void on_stage(const model::Where&, std::span<const float>) override {}
};

class Validation : public ValidatedTest {
 protected:
  // The messages of a run that uses everything: skeleton, muscles, forces, origin shifts, probes, frames in
  // flight.
  std::vector<std::string> messages_of(const gpu::Experiments& experiments) {
    std::vector<std::string> messages;
    gpu::DeviceOptions options;
    options.validation = true;
    options.on_validation_message = [&](const std::string& message) { messages.push_back(message); };
    {
      const model::Model m =
          make_bar({.skeleton = true, .muscle = true, .forces = true, .odd_vertices = true});
      gpu::Device device(*index, options);
      EXPECT_TRUE(device.self_test());
      const auto solver = gpu::make_experimental_solver(device, m, {}, experiments);
      BarMotion motion(m, 3);
      const model::Read read{.positions = true, .velocities = true, .surface = true};
      for (std::uint64_t k = 1; k <= 4; ++k) solver->submit(motion.drive(k), read);
      for (std::uint64_t k = 1; k <= 4; ++k) solver->collect();
      const model::State state = solver->save();
      Ignore probe;
      solver->submit(motion.drive(5), {}, &probe);
      solver->load(state);
      solver->submit(motion.drive(5), read);
    }
    return messages;
  }
};

TEST_F(Validation, HasNothingToSay) {
  const std::vector<std::string> messages = messages_of({});
  for (const std::string& message : messages) ADD_FAILURE() << message;
}

// The control: without the barriers between stages, the layer reports the hazard.
TEST_F(Validation, SeesAPlantedHazard) {
  const std::vector<std::string> messages = messages_of({.leave_out_barriers = true});
  bool seen = false;
  for (const std::string& message : messages) seen |= message.find("SYNC-HAZARD") != std::string::npos;
  EXPECT_TRUE(seen) << messages.size() << " messages, none of a hazard";
}

}  // namespace
}  // namespace fascicle::tests
