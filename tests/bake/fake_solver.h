// A bake for tests of the frame loop: a body of two tetrahedra, and a solver whose frames depend on all
// earlier frames through simple arithmetic.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/bake/bake.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::tests {

// Two tetrahedra with a common face: five vertices with other numbers than in the source, unit 1/2 m, layers
// `fat` and `bone` (the last vertex, kinematic), a probe `tip` of two vertices, a surface of three render
// vertices.
model::Model two_tetrahedra();

// Settings for `frames` frames at 24 fps, starting at 0.5 s.
scene::Scene short_scene(std::uint64_t frames);

struct FakeOptions {
  std::optional<std::uint64_t> not_finite_at;  // this frame's positions contain a NaN and an infinity
  unsigned microseconds = 0;                   // duration of a frame
  std::function<void(std::uint64_t frame)> on_submit;
};

class FakeSolver final : public model::Solver {
 public:
  explicit FakeSolver(const model::Model& model, FakeOptions options = {});
  void submit(const model::Drive& drive, model::Read what, model::Probe* probe = nullptr) override;
  model::Frame collect() override;
  model::State save() const override;
  void load(const model::State& state) override;

  std::size_t most_in_flight() const { return most_in_flight_; }

 private:
  const model::Model& model_;
  FakeOptions options_;
  model::State state_;
  std::deque<model::Frame> frames_;
  std::size_t most_in_flight_ = 0;
};

// A temporary folder that is removed with its contents.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

std::string read_text(const std::filesystem::path& path);
void write_text(const std::filesystem::path& path, const std::string& text);

// Options for a bake of all formats into `folder`.
bake::BakeOptions options_for(const std::filesystem::path& folder);

// All files below a folder with their content; the manifest without its timings, which differ between
// identical bakes. Omits the checkpoint, whose frame depends on when it was written.
std::vector<std::pair<std::string, std::string>> content_of(const std::filesystem::path& folder);

}  // namespace fascicle::tests
