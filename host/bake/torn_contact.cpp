#include "host/bake/torn_contact.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/bake/look_report.h"
#include "host/base/text.h"
#include "host/model/overlap.h"

namespace fascicle::bake {

std::optional<DrivenFlesh> driven_flesh(const scene::Scene& scene, const model::Model& model,
                                        drive::DriveSource& drives) {
  constexpr double poses_per_second = 10.0, most_poses = 200.0, longest_before = 0.5;  // s
  if (!model.has_contact() || !model.has_skeleton()) return std::nullopt;
  const std::uint64_t last = scene::cycle_frames(scene);
  const auto step = static_cast<std::uint64_t>(
      std::ceil(std::max({1.0, scene.fps / poses_per_second, static_cast<double>(last) / most_poses})));
  const model::OverlapMeter overlap(model);
  std::vector<double> depths;  // of frames 0, step, 2 step, ...
  for (std::uint64_t frame = 0; frame <= last; frame += step)
    depths.push_back(overlap.of(drives.state_on_skeleton(frame).positions).deepest);
  const auto deepest = std::max_element(depths.begin(), depths.end());
  const double bearable = deepest_for_contact * model::extent(model);
  if (!(*deepest > bearable)) return std::nullopt;
  const auto before =
      static_cast<std::ptrdiff_t>(std::ceil(longest_before * scene.fps / static_cast<double>(step)));
  auto first = deepest;
  while (first != depths.begin() && deepest - first<before&& * first> 0.5 * bearable) --first;
  const auto frame_of = [&](std::vector<double>::iterator pose) {
    return step * static_cast<std::uint64_t>(pose - depths.begin());
  };
  return DrivenFlesh{*deepest, frame_of(deepest), frame_of(first)};
}

TriedFrames frames_to_try(const scene::Scene& scene, const DrivenFlesh& driven) {
  TriedFrames frames = frames_to_try(scene, driven.frame);
  frames.first = std::min(frames.first, driven.first);
  return frames;
}

bool tears(const TriedLook& with_contact, const TriedLook& without) {
  const double with = with_contact.worst.score;
  return with > 1.0 && (without.worst.score <= 1.0 || without.worst.score < 0.5 * with);
}

std::string torn_contact_warning(const DrivenFlesh& driven, const TriedLook& with_contact,
                                 const TriedLook& without) {
  return "contact of the body with itself is left out: the clip moves flesh " +
         base::short_text(driven.depth) + " m into other flesh by frame " + base::number_text(driven.frame) +
         ", and contact would tear the skin (frames " + base::number_text(with_contact.first + 1) + " to " +
         base::number_text(with_contact.last) + " were tried: look " +
         base::short_text(with_contact.worst.score) + " with contact, " +
         base::short_text(without.worst.score) +
         " without); --set contact.unless_torn=false keeps it, and [contact] ignore leaves out only some "
         "parts";
}

}  // namespace fascicle::bake
