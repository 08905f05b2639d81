#include "tests/bake/fake_solver.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>

#include <nlohmann/json.hpp>
#include <stdlib.h>
#include <unistd.h>

#include "host/bake/outputs.h"
#include "host/formats/surface.h"

namespace fascicle::tests {

namespace fs = std::filesystem;

model::Model two_tetrahedra() {
  model::Model m;
  m.unit = 0.5;
  m.rest_origin = {10.0, 0.0, -3.0};
  m.vertex_count = 5;
  m.source_vertex = {3, 4, 0, 1, 2};
  m.rest = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
  m.mass = {1.0, 2.0, 3.0, 4.0, 5.0};
  m.alpha = {0.5f, 0.5f, 0.5f, 0.5f, 0.0f};
  m.beta.assign(5, 0.0f);
  m.fibre.assign(15, 0.0f);
  m.tag = {0, 0, 0, 0, 1u | shader::tag_kinematic};
  m.layers = {{.name = "fat", .damping = 1.0, .density = 900.0}, {.name = "bone", .kinematic = true}};
  m.ring_offset = {0, 4, 8, 12, 16, 20};
  for (std::uint32_t i = 0; i < 5; ++i)
    for (std::uint32_t j = 0; j < 5; ++j)
      if (j != i) m.ring.push_back(j);
  m.pull.assign(5, 1.0f);
  m.share_taken.assign(20, 0.125f);
  m.share_given.assign(20, 0.125f);
  m.region_rest.assign(20, 0.0f);
  m.surface_vertex = {0, 1, 2, 3, 0, 1, 2, 3, 1, 2, 3, 4};
  m.surface_weight = {1, 0, 0, 0, 0.25f, 0.25f, 0.25f, 0.25f, 0.125f, 0.125f, 0.25f, 0.5f};
  m.surface_triangle = {0, 1, 2};
  m.tetrahedron = {0, 1, 2, 3, 1, 4, 2, 3};
  m.probes = {{"tip", {1, 3}}};
  return m;
}

scene::Scene short_scene(std::uint64_t frames) {
  scene::Scene scene;
  scene.name = "fake";
  scene.source = "builtin:fake";
  scene.text = "[solver]\nsubsteps = 2\n";
  scene.input_hashes = {{"meshes/body.mesh", "0123456789abcdef"}};
  scene.layers.resize(2);
  scene.layers[0].name = "fat";
  scene.layers[0].alpha = 0.5;
  scene.layers[0].damping = 1.0;
  scene.layers[0].density = 900.0;
  scene.layers[1].name = "bone";
  scene.layers[1].kinematic = true;
  scene.layers[1].where = {scene::BoneDistance{0.0, 0.01}};
  scene.solver.substeps = 2;
  scene.fps = 24.0;
  scene.start = 0.5;
  scene.end = 0.5 + static_cast<double>(frames) / 24.0;
  return scene;
}

FakeSolver::FakeSolver(const model::Model& model, FakeOptions options) : model_(model), options_(options) {}

void FakeSolver::submit(const model::Drive& drive, model::Read what, model::Probe*) {
  if (options_.microseconds > 0) ::usleep(options_.microseconds);
  ++state_.frame;
  if (options_.on_submit) options_.on_submit(state_.frame);
  state_.origin = drive.origin;
  const auto h = static_cast<float>(drive.h) * static_cast<float>(drive.substeps);
  for (std::size_t i = 0; i < state_.positions.size(); ++i) {
    if (model_.is_kinematic(static_cast<std::uint32_t>(i / 3))) continue;
    float& velocity = state_.velocities[i];
    float& memory = state_.rotations[i];  // state that only the checkpoint stores
    const float pull = model_.rest[i] - state_.positions[i];
    memory = 0.5f * memory + pull;
    velocity = velocity * 0.96875f + 20.0f * h * memory + h * drive.gravity[i % 3];
    state_.positions[i] = (state_.positions[i] - drive.origin_shift[i % 3]) + h * velocity;
  }
  model::Frame frame{
      .index = state_.frame, .origin = state_.origin, .positions = {}, .velocities = {}, .surface = {}};
  if (what.positions) frame.positions = state_.positions;
  if (what.velocities) frame.velocities = state_.velocities;
  if (what.surface) frame.surface = formats::embed(model_, state_.positions);
  // It has no skeleton: skinning leaves its body at rest.
  if (what.skinned) frame.skinned = model_.rest;
  if (options_.not_finite_at == state_.frame) {
    frame.positions.at(3 * 1 + 2) = std::numeric_limits<float>::quiet_NaN();
    frame.positions.at(3 * 2) = -2e9f;  // beyond model::farthest
  }
  frames_.push_back(std::move(frame));
  most_in_flight_ = std::max(most_in_flight_, frames_.size());
}

model::Frame FakeSolver::collect() {
  model::Frame frame = std::move(frames_.at(0));
  frames_.pop_front();
  return frame;
}

model::State FakeSolver::save() const {
  if (!frames_.empty()) throw std::logic_error("saved while a frame was in flight");
  return state_;
}

void FakeSolver::load(const model::State& state) {
  if (state.positions.size() != model_.rest.size()) throw std::invalid_argument("state of another model");
  state_ = state;
  frames_.clear();
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "fascicle_bake_XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::string read_text(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
}

bake::BakeOptions options_for(const fs::path& folder) {
  bake::BakeOptions options;
  options.folder = folder;
  options.formats = bake::format_names();
  options.device = {.solver = "cpu", .name = "fake", .driver = "none", .float_controls = "all", .threads = 1};
  return options;
}

std::vector<std::pair<std::string, std::string>> content_of(const fs::path& folder) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& item : fs::recursive_directory_iterator(folder)) {
    if (!item.is_regular_file() || item.path().filename() == "checkpoint") continue;
    std::string text = read_text(item.path());
    if (item.path().filename() == "manifest.json") {
      nlohmann::json manifest = nlohmann::json::parse(text);
      manifest.erase("timings");
      manifest.erase("checksum");  // it covers the timings
      text = manifest.dump(1);
    }
    files.emplace_back(fs::relative(item.path(), folder).string(), text);
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace fascicle::tests
