// What the tests of the frame loop bake: a body of two tetrahedra and a solver whose frames follow from all
// of its history by a few lines of arithmetic.
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

// Two tetrahedra on a common face: five vertices with numbers that differ from the source's, unit 1/2 m,
// layers `fat` and `bone` (the last vertex, kinematic), a probe `tip` of two vertices, a surface of three
// render vertices.
model::Model two_tetrahedra();

// Settings for `frames` frames at 24 fps from 0.5 s on.
scene::Scene short_scene(std::uint64_t frames);

struct FakeOptions {
  std::optional<std::uint64_t> not_finite_at;  // this frame's positions hold a NaN and an infinity
  unsigned microseconds = 0;                   // a frame takes
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

// A folder of its own, removed with all it holds.
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

// Options of a bake of all formats into `folder`.
bake::BakeOptions options_for(const std::filesystem::path& folder);

// All files below a folder with their content; of the manifest, without what may differ between two equal
// bakes (timings). The checkpoint is left out: where it stands depends on when it was taken.
std::vector<std::pair<std::string, std::string>> content_of(const std::filesystem::path& folder);

}  // namespace fascicle::tests
