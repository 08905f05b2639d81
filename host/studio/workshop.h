// From a scene's text to a body that can move, again and again: what the last text left is used for the next.
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

// Where a text comes from.
struct TextSource {
  std::string name, source;      // Scene::name, Scene::source
  std::filesystem::path folder;  // what its file names are relative to
  std::filesystem::path converter = {};
};

class Workshop {
 public:
  // Bodies that are kept at once: changes that build anew are taken back a few at a time. What is counted are
  // the arrays of a body's solver. What is kept of it takes about as much: 0.8 to 1.2 times, of the made arm
  // and bear of 6,000 to 13,000 vertices.
  static constexpr std::size_t most_bodies = 6;
  static constexpr std::uint64_t most_solver_bytes = std::uint64_t{256} << 20;

  // The device must outlive all bodies.
  Workshop(TextSource source, build::BuildOptions options, const pipeline::ChosenDevice& device);

  // Throws scene::SceneError, build::Cancelled, pipeline::NoSuchDevice.
  // `paints` stand for the files that their keys name.
  std::shared_ptr<RunningBody> make(const std::string& text, const Paints& paints, std::uint32_t revision,
                                    const pipeline::Say& say);
  // The meshes of the last text's scene without their paint files, to be painted on; none where it has no
  // characters, or cannot be read without its paint. Those of `before` where they are the same.
  std::vector<PaintPlace> places(const scene::Scene& scene, const std::vector<PaintPlace>& before);
  // Does for the last text what make() will need for the next ones and did not need for that.
  void warm();

 private:
  // What is kept of a body that was built, so that one that comes again is not filled and measured again.
  struct KeptBody {
    std::string key;  // build::body_key
    build::BuildMemory build;
    pipeline::SolverMemory solver;
    std::uint64_t bytes = 0;  // of its solver
  };

  scene::Scene read(const std::string& text, const scene::SceneOverrides& more = {});
  // The body's, which is the newest from now on; an empty one where nothing is kept of it.
  KeptBody& kept_of(const scene::Scene& scene);
  void drop_oldest();

  TextSource source_;
  build::BuildOptions options_;
  const pipeline::ChosenDevice& device_;
  scene::LoadedFiles files_;
  std::list<KeptBody> kept_;  // the newest first
  std::string last_text_;
  std::vector<std::string> places_of_;        // files of the characters that were asked for last
  std::vector<std::filesystem::path> given_;  // files that paints stand for
  bool is_warm_ = false;
};

}  // namespace fascicle::studio
