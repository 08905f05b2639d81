#include "host/studio/workshop.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <variant>

#include "host/pipeline/build_scene.h"
#include "host/scene/scene_edit.h"
#include "host/scene/scene_file.h"
#include "host/studio/scene_keys.h"

namespace fascicle::studio {

Workshop::Workshop(TextSource source, build::BuildOptions options, const pipeline::ChosenDevice& device)
    : source_(std::move(source)), options_(std::move(options)), device_(&device) {}

void Workshop::use(const pipeline::ChosenDevice& device) {
  device_ = &device;
  for (KeptBody& kept : kept_) kept.solver = {};
}

scene::Scene Workshop::read(const std::string& text, const scene::SceneOverrides& more) {
  scene::SceneOverrides overrides = more;
  overrides.converter = source_.converter;
  scene::Scene scene =
      scene::parse_scene({source_.name, source_.source, text, source_.folder, &files_}, overrides);
  scene.input_hashes.insert(scene.input_hashes.begin(), {source_.source, scene::hash_of(text)});
  return scene;
}

std::shared_ptr<RunningBody> Workshop::make(const std::string& text, const Paints& paints,
                                            std::uint32_t revision, const pipeline::Say& say) {
  for (const std::filesystem::path& file : std::exchange(given_, {})) files_.give(file, std::nullopt);
  for (const auto& [key, file] : paint_files(scene::edited_tables(text, source_.source))) {
    const auto paint = paints.find(key);
    if (paint == paints.end()) continue;
    given_.push_back(source_.folder / file);
    files_.give(given_.back(), *paint->second);
  }
  scene::Scene scene = read(text);
  KeptBody& kept = kept_of(scene);
  pipeline::Built built = is_warm_ ? pipeline::build_scene_again(scene, options_, kept.build)
                                   : pipeline::build_scene(scene, options_, say);
  last_text_ = text;
  kept.bytes = model::solver_bytes(built.model);
  auto body =
      std::make_shared<RunningBody>(std::move(scene), std::move(built), *device_, revision, kept.solver);
  kept.solver = body->memory();
  drop_oldest();
  return body;
}

Workshop::KeptBody& Workshop::kept_of(const scene::Scene& scene) {
  const std::string key = build::body_key(scene).value_or("");
  // Drop entries of failed or cancelled builds, unless they are of the same body, which can reuse them.
  std::erase_if(kept_, [&](const KeptBody& kept) { return kept.bytes == 0 && kept.key != key; });
  const auto found = std::ranges::find(kept_, key, &KeptBody::key);
  if (found != kept_.end())
    kept_.splice(kept_.begin(), kept_, found);
  else
    kept_.emplace_front().key = key;
  return kept_.front();
}

// Call after a successful build, so that a failed one evicts nothing. The newest entry stays, however large.
void Workshop::drop_oldest() {
  const auto is_too_much = [&] {
    std::uint64_t bytes = 0;
    for (const KeptBody& kept : kept_) bytes += kept.bytes;
    return kept_.size() > most_bodies || bytes > most_solver_bytes;
  };
  while (kept_.size() > 1 && is_too_much()) kept_.pop_back();
}

namespace {

struct OneCharacter {
  PaintPlace place;
  const rig::Character* character = nullptr;
  std::string file;  // identifies the character
};

std::vector<OneCharacter> characters_of(const scene::Scene& scene) {
  std::vector<OneCharacter> all;
  if (const auto* only = std::get_if<rig::Character>(&scene.geometry); only && scene.characters.empty())
    all.push_back({{.key = std::string(paint_path), .name = {}, .ground = nullptr},
                   only,
                   scene::character_file(scene).string()});
  for (const scene::PlacedCharacter& one : scene.characters)
    all.push_back({{.key = "character." + one.settings.name + ".paint",
                    .name = one.settings.name,
                    .ground = nullptr,
                    .offset = one.bind_offset,
                    .is_rigid = one.settings.rigid},
                   &one.own,
                   one.file.string() + one.settings.made});
  return all;
}

}  // namespace

std::vector<PaintPlace> Workshop::places(const scene::Scene& scene, const std::vector<PaintPlace>& before) {
  std::vector<OneCharacter> all = characters_of(scene);
  std::vector<PaintPlace> places;
  const std::vector<std::string> of_before = std::exchange(places_of_, {});
  std::optional<scene::Scene> unpainted;
  std::vector<OneCharacter> all_unpainted;
  for (std::size_t k = 0; k < all.size(); ++k) {
    OneCharacter& one = all[k];
    const bool is_known = k < before.size() && k < of_before.size() && of_before[k] == one.file &&
                          before[k].key == one.place.key &&
                          before[k].ground->hash() == rig::surface_hash(one.character->surface);
    if (is_known) {
      one.place.ground = before[k].ground;
    } else {
      if (!unpainted) try {
          scene::SceneOverrides without;
          for (const auto& [key, file] : paint_files(scene::edited_tables(last_text_, source_.source)))
            without.set.push_back(key + "=");
          unpainted = read(last_text_, without);
          all_unpainted = characters_of(*unpainted);
        } catch (const scene::SceneError&) {
          return {};  // the scene cannot be read without its paint
        }
      one.place.ground =
          std::make_shared<const PaintGround>(one.character->surface, all_unpainted.at(k).character->painted);
    }
    places_of_.push_back(one.file);
    places.push_back(std::move(one.place));
  }
  return places;
}

void Workshop::warm() {
  if (is_warm_ || last_text_.empty()) return;
  const scene::Scene scene = read(last_text_);
  (void)pipeline::build_scene_again(scene, options_, kept_of(scene).build);
  is_warm_ = true;
}

}  // namespace fascicle::studio
