#include <algorithm>

#include "host/rig/pose.h"
#include "host/scene/scene_characters.h"
#include "host/scene/scene_check.h"
#include "host/scene/scene_file.h"
#include "host/scene/scene_keys.h"
#include "host/scene/scene_values.h"

namespace fascicle::scene {
namespace {

const rig::Clip* clip_of(const toml::table& root, const Scene& scene) {
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  if (character == nullptr) return nullptr;
  try {
    return rig::find_clip(*character, scene.clip);
  } catch (const SceneError& error) {
    const toml::table& table = table_at(root, "character");
    const toml::node* node = table.get("clip");
    fail(node != nullptr ? node->source() : table.source(), "character.clip", error.what());
  }
}

// Whether nothing moves: a sculpted character in its rest pose, without a clip, forces or colliders.
bool is_rest_bake(const toml::table& root, const Scene& scene) {
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  std::string rest = name_of(Rest::sculpted);
  read(table_at(root, "motion"), "rest", rest);
  return character != nullptr && character->clips.empty() && scene.forces.empty() &&
         scene.colliders.empty() && rest == name_of(Rest::sculpted);
}

}  // namespace

std::string clip_name(const Scene& scene) {
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  const rig::Clip* clip = character != nullptr ? rig::find_clip(*character, scene.clip) : nullptr;
  return clip != nullptr ? clip->name : std::string();
}

void read_time(const toml::table& root, Scene& scene) {
  const toml::table& table = table_at(root, "scene");
  const rig::Clip* clip = clip_of(root, scene);
  const toml::node* end = table.get("end");
  if (end == nullptr) {
    // A clip with a single key is a pose, and is baked as one frame.
    if (clip != nullptr)
      scene.end = clip->duration * scene.fps < 0.5 ? scene.start + 1.0 / scene.fps : clip->duration;
    else if (is_rest_bake(root, scene))
      scene.end = scene.start + 1.0 / scene.fps;
    else
      scene.end = scene.start + Scene{}.end;
  }
  // If the end follows from the clip, the start must be at fault.
  const toml::node* start = table.get("start");
  const toml::source_region& blame = end != nullptr     ? end->source()
                                     : start != nullptr ? start->source()
                                                        : root.source();
  const double frames = (scene.end - scene.start) * scene.fps;
  if (!(frames >= 0.5)) {
    fail(blame, "scene.end", "lies less than a frame after scene.start; nothing would be baked");
  }
  if (frames > most_frames)
    fail(blame, "scene.end", "asks for more than 10 million frames; end earlier or lower fps");
}

namespace {

// s. Given this long to follow, a character's flesh is not crushed by the first frame.
constexpr double default_preroll = 0.5;

// Handles extend the hold if there is one, and otherwise the end.
void add_handles(Scene& scene) {
  const double seconds = static_cast<double>(scene.motion.handles) / scene.fps;
  scene.start -= seconds;
  (scene.motion.hold > 0.0 ? scene.motion.hold : scene.end) += seconds;
}

}  // namespace

void read_motion(const toml::table& root, Scene& scene) {
  const toml::table& table = table_at(root, "motion");
  const bool is_character = std::holds_alternative<rig::Character>(scene.geometry);
  const auto refuse = [&](const char* key, const std::string& what) {
    fail(table.get(key)->source(), join_path("motion", key), what);
  };
  Motion& motion = scene.motion;
  if (is_character) {
    motion.rest = Rest::sculpted;
    motion.preroll = default_preroll;
  }
  // Characters made in code have dense enough keys.
  const bool from_file =
      is_character &&
      ((scene.characters.empty() && table_at(root, "character").contains("file")) ||
       std::any_of(scene.characters.begin(), scene.characters.end(),
                   [](const PlacedCharacter& one) { return !one.file.empty() && !is_still_prop(one); }));
  motion.interpolation = from_file ? KeyInterpolation::smooth : KeyInterpolation::as_authored;
  read_keys(table, motion);
  std::sort(motion.cuts.begin(), motion.cuts.end());

  if (!is_character) {
    if (motion.rest == Rest::sculpted)
      refuse("rest",
             "sculpted needs a skeleton, in whose frames gravity changes; use weightless, or a "
             "[character]");
    if (table.contains("interpolation"))
      refuse("interpolation", "takes a [character], whose clip has keys; leave it out");
    if (motion.acceleration_limit)
      refuse("acceleration_limit", "takes a [character], whose joints accelerate; leave it out");
    if (motion.cut_distance) refuse("cut_distance", "takes a [character], whose root jumps; leave it out");
    if (scene.flesh.exaggerate != 1.0)
      fail(table_at(root, "flesh").get("exaggerate")->source(), "flesh.exaggerate",
           "takes a [character], whose skeleton accelerates flesh; leave it out");
    if (motion.preroll > 0.0) refuse("preroll", "takes a [character]; leave it out");
    if (motion.loop > 1) refuse("loop", "takes a [character], whose clip it repeats; leave it out");
    if (motion.seamless) refuse("seamless", "takes a [character], whose clip it repeats; leave it out");
    if (!motion.cuts.empty()) refuse("cuts", "takes a [character], whose clip it cuts; leave it out");
  }
  if (motion.seamless && motion.loop > 1)
    refuse("loop", "conflicts with seamless, which writes one cycle; leave one of them out");
  if (motion.seamless && motion.hold > 0.0)
    refuse("hold", "conflicts with seamless, which ends as it begins; leave one of them out");
  if (motion.handles > 0 && (motion.seamless || motion.loop > 1))
    refuse("handles",
           "conflicts with seamless and loop, which repeat the clip; leave handles out, or the others");
  if (motion.interpolation == KeyInterpolation::smooth)
    smooth_clips(scene, motion.seamless || motion.loop > 1);
  add_handles(scene);
  const double frames = (scene.end - scene.start) * scene.fps * motion.loop + motion.hold * scene.fps;
  if (frames > most_frames)
    fail(table.source(), "motion", "loop and hold make more than 10 million frames; lower loop, hold or fps");
}

}  // namespace fascicle::scene
