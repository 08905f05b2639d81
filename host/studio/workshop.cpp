#include "host/studio/workshop.h"

#include <utility>

#include "host/pipeline/build_scene.h"
#include "host/scene/scene_file.h"

namespace fascicle::studio {

Workshop::Workshop(TextSource source, build::BuildOptions options, const pipeline::ChosenDevice& device)
    : source_(std::move(source)), options_(std::move(options)), device_(device) {}

scene::Scene Workshop::read(const std::string& text) {
  scene::SceneOverrides overrides;
  overrides.converter = source_.converter;
  scene::Scene scene =
      scene::parse_scene({source_.name, source_.source, text, source_.folder, &files_}, overrides);
  scene.input_hashes.insert(scene.input_hashes.begin(), {source_.source, scene::hash_of(text)});
  return scene;
}

std::shared_ptr<RunningBody> Workshop::make(const std::string& text, std::uint32_t revision,
                                            const pipeline::Say& say) {
  scene::Scene scene = read(text);
  pipeline::Built built = is_warm_ ? pipeline::build_scene_again(scene, options_, memory_)
                                   : pipeline::build_scene(scene, options_, say);
  body_key_ = build::body_key(scene).value_or("");
  last_text_ = text;
  return std::make_shared<RunningBody>(std::move(scene), std::move(built), device_, revision);
}

bool Workshop::needs_new_body(const std::string& text) {
  return build::body_key(read(text)).value_or("") != body_key_;
}

void Workshop::warm() {
  if (is_warm_ || last_text_.empty()) return;
  (void)pipeline::build_scene_again(read(last_text_), options_, memory_);
  is_warm_ = true;
}

}  // namespace fascicle::studio
