#include "host/bake/torn_contact.h"

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "host/bake/look_report.h"
#include "host/base/text.h"
#include "host/model/overlap.h"

namespace fascicle::bake {

std::vector<DrivenFlesh> driven_flesh(const scene::Scene& scene, const model::Model& model,
                                      drive::DriveSource& drives, const std::function<bool()>& goes_on) {
  constexpr double poses_per_second = 10.0, most_poses = 200.0;
  constexpr double apart = 1.0, longest_before = 0.5, step_before = 1.0 / 30.0;  // s
  constexpr std::size_t most_found = 2;
  std::vector<DrivenFlesh> found;
  if (!model.has_contact() || !model.has_skeleton() || !scene.characters.empty()) return found;
  const model::OverlapMeter overlap(model);
  const auto depth_in = [&](std::uint64_t frame) {
    return overlap.of(drives.state_on_skeleton(frame).positions).deepest;
  };
  const auto frames_of = [&](double seconds) {
    return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::llround(seconds * scene.fps)));
  };
  const double bearable = deepest_for_contact * model::extent(model);
  const std::uint64_t last = scene::cycle_frames(scene);
  const std::uint64_t step =
      std::max(frames_of(1.0 / poses_per_second),
               static_cast<std::uint64_t>(std::ceil(static_cast<double>(last) / most_poses)));
  std::vector<DrivenFlesh> poses;
  for (std::uint64_t frame = 0; frame <= last; frame += step) {
    if (goes_on && !goes_on()) return found;
    if (const double depth = depth_in(frame); depth > bearable)
      poses.push_back({.depth = depth, .frame = frame});
  }
  std::stable_sort(poses.begin(), poses.end(),
                   [](const DrivenFlesh& a, const DrivenFlesh& b) { return a.depth > b.depth; });
  for (DrivenFlesh& pose : poses) {
    const bool is_near = std::any_of(found.begin(), found.end(), [&](const DrivenFlesh& other) {
      const std::uint64_t way =
          other.frame > pose.frame ? other.frame - pose.frame : pose.frame - other.frame;
      return way < frames_of(apart);
    });
    if (is_near || found.size() == most_found) continue;
    const std::uint64_t back = std::min(frames_of(step_before), frames_of(longest_before));
    const std::uint64_t earliest = pose.frame - std::min(pose.frame, frames_of(longest_before));
    pose.first = pose.frame;
    pose.starts_deep = true;
    while (pose.starts_deep && pose.first > earliest) {
      pose.first -= std::min(back, pose.first - earliest);
      pose.starts_deep = depth_in(pose.first) > 0.5 * bearable;
    }
    found.push_back(pose);
  }
  return found;
}

TriedFrames frames_to_try(const scene::Scene& scene, const DrivenFlesh& driven) {
  TriedFrames frames = frames_to_try(scene, driven.frame);
  frames.first = std::min(frames.first, driven.first);
  frames.has_lead_in = true;
  // Flesh that begins inside other flesh has a way to go.
  if (driven.starts_deep) frames.settling = std::max(frames.settling, (driven.frame - frames.first) / 2);
  return frames;
}

bool tears(const TriedLook& with_contact, const TriedLook& without) {
  if (!without.is_finite) return false;
  if (!with_contact.is_finite) return true;
  const double with = with_contact.worst.score;
  return with > 1.0 && (without.worst.score <= 1.0 || without.worst.score < 0.5 * with);
}

std::string torn_contact_warning(const scene::Scene& scene, const DrivenFlesh& driven,
                                 const TriedLook& with_contact, const TriedLook& without) {
  const auto& skeleton = std::get<rig::Character>(scene.geometry).skeleton;
  const std::string with = with_contact.is_finite
                               ? "look " + base::short_text(with_contact.worst.score)
                               : std::string("they end with positions that are not finite");
  return "contact of the body with itself is left out, because it would tear the skin at joint \"" +
         skeleton[with_contact.worst.joint].name + "\": the clip moves flesh " +
         base::short_text(driven.depth) + " m into other flesh (frame " + base::number_text(driven.frame) +
         "); of the frames around it, " + base::number_text(with_contact.first + 1) + " to " +
         base::number_text(with_contact.last) + " were tried: " + with + " with contact, " +
         base::short_text(without.worst.score) +
         " without (1 is the limit); --set contact.unless_torn=false keeps it, and [contact] ignore leaves "
         "out only some parts";
}

}  // namespace fascicle::bake
