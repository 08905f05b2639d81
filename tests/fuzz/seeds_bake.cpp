#include "host/bake/checkpoint.h"
#include "host/bake/kept_start.h"
#include "host/bake/manifest.h"
#include "host/bake/model_file.h"
#include "host/bake/read_frame_cache.h"
#include "host/build/build.h"
#include "host/scene/scene_file.h"
#include "tests/fuzz/seeds.h"

namespace fascicle::fuzz {
namespace {

const std::string bar_text =
    "[bar]\nsize = [0.2, 0.1, 0.1]\nvertices = [2, 2, 2]\n[layers.fat]\nalpha = 0.5\n[pin.end]\nwhere = { "
    "box = { "
    "minimum = [-1, -1, -1], maximum = [0.01, 1, 1] } }\n";

std::string frames_file() {
  bake::CacheHeader header;
  header.vertex_count = 2;
  header.frames = 2;
  std::string bytes = bake::encode_cache_header(header);
  model::Frame frame;
  frame.positions = {0, 0, 0, 1, 2, 3};
  for (frame.index = 0; frame.index <= header.frames; ++frame.index)
    bytes += bake::encode_cache_record(header, frame);
  return bytes;
}

bake::Checkpoint sample_checkpoint() {
  bake::Checkpoint sample;
  sample.identity = {{"scene", "a"}};
  sample.state.positions = sample.state.velocities = {0, 0, 0, 1, 2, 3};
  sample.state.rotations = {1, 0, 0, 0, 1, 0, 0, 0};
  return sample;
}

}  // namespace

void add_bake_seeds(std::vector<Seed>& seeds) {
  const fascicle::scene::Scene scene = fascicle::scene::parse_scene({"a", "a.toml", bar_text, {}}, {});
  build::Report report;
  const model::Model model = build::build_model(scene, report);
  seeds.push_back({"frames", "three", frames_file()});
  seeds.push_back({"model", "bar", bake::encode_model(model)});
  const bake::Checkpoint checkpoint = sample_checkpoint();
  seeds.push_back({"checkpoint", "two", bake::checkpoint_text(checkpoint)});
  drive::LeadIn lead_in;
  lead_in.state = checkpoint.state;
  seeds.push_back({"start", "two", bake::start_bytes(lead_in, checkpoint.identity)});
  bake::BakeOptions options;
  options.formats = {"pc2"};
  options.warnings = {"a warning"};
  bake::Progress progress;
  progress.position_hashes = {1, 2};
  seeds.push_back({"manifest", "bar", bake::manifest_text(scene, model, options, 7, progress)});
}

}  // namespace fascicle::fuzz
