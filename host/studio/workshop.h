// From a scene's text to a body that can move, again and again: what the last text left is used for the next.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

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
  // The device must outlive all bodies.
  Workshop(TextSource source, build::BuildOptions options, const pipeline::ChosenDevice& device);

  // Throws scene::SceneError, build::Cancelled, pipeline::NoSuchDevice.
  // `paint` stands for the file that character.paint names.
  std::shared_ptr<RunningBody> make(const std::string& text, const PaintText& paint, std::uint32_t revision,
                                    const pipeline::Say& say);
  // Whether a text's body has to be built anew, which takes long. Throws scene::SceneError.
  bool needs_new_body(const std::string& text);
  // The mesh of the last text's scene without its paint file, to be painted on; null where there is not
  // exactly one character. That of `before` where it is the same.
  std::shared_ptr<const PaintGround> ground(const scene::Scene& scene,
                                            const std::shared_ptr<const PaintGround>& before);
  // Does for the last text what make() will need for the next ones and did not need for that.
  void warm();

 private:
  scene::Scene read(const std::string& text, const scene::SceneOverrides& more = {});

  TextSource source_;
  build::BuildOptions options_;
  const pipeline::ChosenDevice& device_;
  scene::LoadedFiles files_;
  build::BuildMemory memory_;
  std::string body_key_;  // of what the memory holds
  std::string last_text_, ground_of_;
  std::optional<std::filesystem::path> given_;  // the file that a paint stands for
  bool is_warm_ = false;
};

}  // namespace fascicle::studio
