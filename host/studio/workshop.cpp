#include "host/studio/workshop.h"

#include <utility>
#include <variant>

#include "host/pipeline/build_scene.h"
#include "host/scene/scene_edit.h"
#include "host/scene/scene_file.h"
#include "host/studio/scene_keys.h"

namespace fascicle::studio {

Workshop::Workshop(TextSource source, build::BuildOptions options, const pipeline::ChosenDevice& device)
    : source_(std::move(source)), options_(std::move(options)), device_(device) {}

scene::Scene Workshop::read(const std::string& text, const scene::SceneOverrides& more) {
  scene::SceneOverrides overrides = more;
  overrides.converter = source_.converter;
  scene::Scene scene =
      scene::parse_scene({source_.name, source_.source, text, source_.folder, &files_}, overrides);
  scene.input_hashes.insert(scene.input_hashes.begin(), {source_.source, scene::hash_of(text)});
  return scene;
}

std::shared_ptr<RunningBody> Workshop::make(const std::string& text, const PaintText& paint,
                                            std::uint32_t revision, const pipeline::Say& say) {
  if (given_) files_.give(*given_, std::nullopt);
  given_.reset();
  const std::string file = paint ? paint_key(scene::edited_tables(text, source_.source)) : std::string();
  if (!file.empty()) {
    given_ = source_.folder / file;
    files_.give(*given_, *paint);
  }
  scene::Scene scene = read(text);
  pipeline::Built built = is_warm_ ? pipeline::build_scene_again(scene, options_, memory_)
                                   : pipeline::build_scene(scene, options_, say);
  body_key_ = build::body_key(scene).value_or("");
  last_text_ = text;
  return std::make_shared<RunningBody>(std::move(scene), std::move(built), device_, revision);
}

std::shared_ptr<const PaintGround> Workshop::ground(const scene::Scene& scene,
                                                    const std::shared_ptr<const PaintGround>& before) {
  const auto* painted = std::get_if<rig::Character>(&scene.geometry);
  if (painted == nullptr || !scene.characters.empty()) return nullptr;
  const std::string file = scene::character_file(scene).string();
  if (before && file == ground_of_ && before->hash() == rig::surface_hash(painted->surface)) return before;
  std::vector<rig::PaintedAttribute> own = painted->painted;
  if (!scene.paint.empty()) try {
      scene::SceneOverrides unpainted;
      unpainted.set = {std::string(paint_path) + "="};
      own = std::get<rig::Character>(read(last_text_, unpainted).geometry).painted;
    } catch (const scene::SceneError&) {
      return nullptr;  // it cannot be without its paint
    }
  ground_of_ = file;
  return std::make_shared<const PaintGround>(painted->surface, std::move(own));
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
