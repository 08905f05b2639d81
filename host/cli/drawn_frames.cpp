#include "host/cli/drawn_frames.h"

#include <algorithm>
#include <filesystem>

#include "host/bake/finished_bake.h"
#include "host/base/errors.h"
#include "host/base/text.h"
#include "host/cli/looks.h"
#include "host/formats/character_file.h"
#include "host/formats/surface.h"
#include "host/gltf/gltf_rig.h"
#include "host/model/reach.h"
#include "host/scene/input_files.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;

scene::Scene load_named(const SceneArguments& input) {
  const auto& builtin = scene::builtin_scenes();
  const bool is_builtin =
      std::any_of(builtin.begin(), builtin.end(), [&](const auto& s) { return s.name == input.name; });
  if (!is_builtin && !fs::exists(input.name))
    throw scene::SceneError(
        input.name +
        ": there is no such bake, scene, mesh or character; give a bake's folder, a file, "
        "or a built-in scene" +
        nearest_scene_hint(input.name));
  return load(input);
}

// The skinning is a file's, whose joints may have any size, and so is the embedding of the surface.
std::vector<float> drawable(std::vector<float> metres, const std::filesystem::path& folder, std::uint64_t k) {
  constexpr double unit = 1.0;
  if (!model::is_in_reach(metres, unit))
    throw bake::BakeError(folder.string() + ": frame " + base::number_text(k) +
                          " cannot be drawn: it is absurdly large, or not finite; bake again");
  return metres;
}

}  // namespace

DrawnFrames::DrawnFrames(const RenderArguments& arguments, Log& log) : log_(log) {
  if (fs::is_directory(arguments.input.name)) {
    folder_ = arguments.input.name;
    bake_.emplace(folder_);
    if (bake_->model().has_skeleton()) character_ = folder_ / formats::character_name;
    return;
  }
  const scene::Scene scene = load_named(arguments.input);
  Built built = build(scene, log);
  log_warnings(built.report, log);
  built_ = std::move(built.model);
  character_ = scene::character_file(scene);
  for (const scene::Collider& collider : scene.colliders)
    built_solids_.push_back(scene::bound_solid_of(scene, collider));
}

std::vector<float> DrawnFrames::positions(std::uint64_t k) const {
  if (!bake_) return formats::world_positions(built_.rest, built_.unit, built_.rest_origin);
  const model::Frame frame = bake_->frame(k);
  return formats::world_positions(frame.positions, bake_->model().unit, frame.origin);
}

std::vector<float> DrawnFrames::surface(std::uint64_t k) {
  if (!bake_)
    return formats::world_positions(formats::embed(built_, built_.rest), built_.unit, built_.rest_origin);
  const model::Frame frame = bake_->frame(k);
  std::vector<float> surface = formats::embed(bake_->model(), frame.positions);
  if (!has_read_shapes_) read_shapes();
  if (shapes_) shapes_->add_to(k, surface);
  return drawable(formats::world_positions(surface, bake_->model().unit, frame.origin), folder_, k);
}

void DrawnFrames::read_shapes() {
  has_read_shapes_ = true;
  // Without its file a character is drawn as the flesh carries it.
  if (character_.empty() || !fs::exists(character_)) return;
  const auto warn = [&](const std::string& fault) { log_.warning(fault + "; blend shapes are not drawn"); };
  try {
    bake::read_kept(folder_, [&] { shapes_.emplace(character_, bake_->model(), bake_->fps()); });
  } catch (const base::SceneError& error) {
    warn(error.what());
  } catch (const base::BakeError& error) {
    warn(error.what());
  }
}

std::vector<float> DrawnFrames::skinned_vertices(std::uint64_t k) {
  const OpenBake::Skinned skinned = bake_.value().skinned(k);
  return drawable(formats::world_positions(skinned.positions, bake_->model().unit, skinned.origin), folder_,
                  k);
}

std::vector<float> DrawnFrames::skinned_surface(std::uint64_t k) {
  const model::Model& model = bake_.value().model();
  if (!model.has_skeleton())
    return formats::world_positions(formats::embed(model, model.rest), model.unit, model.rest_origin);
  if (!skin_) {
    if (!fs::exists(character_))
      throw bake::BakeError(character_.string() +
                            ": is missing; it holds the skinning to compare with; bake again");
    skin_.emplace(character_, model, bake_->fps());
  }
  return drawable(skin_->positions(k), folder_, k);
}

std::vector<float> DrawnFrames::lag(std::uint64_t k) {
  if (!bake_) return std::vector<float>(built_.vertex_count, 0.0f);
  return drawable(bake_->lag(bake_->frame(k)), folder_, k);
}

std::vector<scene::Solid> DrawnFrames::solids(std::uint64_t k) {
  return bake_ ? bake_->solids(k) : built_solids_;
}

std::optional<render::Looks> DrawnFrames::looks(Log& log) const {
  if (character_.empty() || !fs::exists(character_)) return std::nullopt;
  return looks_of(character_, model(), log);
}

}  // namespace fascicle::cli
