// Turns a scene's text into a body that can move, again and again, reusing what the last text left.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "host/build/build.h"
#include "host/pipeline/device_choice.h"
#include "host/pipeline/messages.h"
#include "host/scene/input_files.h"
#include "host/scene/scene.h"
#include "host/studio/brush.h"
#include "host/studio/history.h"
#include "host/studio/running_body.h"

namespace fascicle::studio {

// The origin of a text.
struct TextSource {
  std::string name, source;      // Scene::name, Scene::source
  std::filesystem::path folder;  // its file names are relative to this
  std::filesystem::path converter = {};
};

class Workshop {
 public:
  // Limits on bodies kept for undoing changes that need a rebuild, a few at a time. The byte limit counts the
  // arrays of a body's solver. What is kept takes about the same: 0.8 to 1.2 times, for the generated arm and
  // bear with 6,000 to 13,000 vertices.
  static constexpr std::size_t most_bodies = 6;
  static constexpr std::uint64_t most_solver_bytes = std::uint64_t{256} << 20;

  // The device must outlive its bodies.
  Workshop(TextSource source, build::BuildOptions options, const pipeline::ChosenDevice& device);

  // From now on, bodies are for this device, which must outlive them.
  void use(const pipeline::ChosenDevice& device);
  // `paints` replace the files that their keys name. Throws scene::SceneError, build::Cancelled,
  // pipeline::NoSuchDevice, gpu::DeviceLost.
  std::shared_ptr<RunningBody> make(const std::string& text, const Paints& paints, std::uint32_t revision,
                                    const pipeline::Say& say);
  // The meshes to paint on: those of the last text's scene without its paint files. Empty if it has no
  // characters, or cannot be read without its paint. Reuses those of `before` that are the same.
  std::vector<PaintPlace> places(const scene::Scene& scene, const std::vector<PaintPlace>& before);
  // Prepares what make() needs for later texts but did not need for the last.
  void warm();

 private:
  // What is kept of a built body, so that returning to it needs no filling and measuring.
  struct KeptBody {
    std::string key;  // build::body_key
    build::BuildMemory build;
    pipeline::SolverMemory solver;
    std::uint64_t bytes = 0;  // of its solver
  };

  scene::Scene read(const std::string& text, const scene::SceneOverrides& more = {});
  // The body's entry, which becomes the newest; a new one if nothing is kept.
  KeptBody& kept_of(const scene::Scene& scene);
  void drop_oldest();

  TextSource source_;
  build::BuildOptions options_;
  const pipeline::ChosenDevice* device_;
  scene::LoadedFiles files_;
  std::list<KeptBody> kept_;  // newest first
  std::string last_text_;
  std::vector<std::string> places_of_;        // files of the characters requested last
  std::vector<std::filesystem::path> given_;  // files replaced by paints
  bool is_warm_ = false;
};

}  // namespace fascicle::studio
