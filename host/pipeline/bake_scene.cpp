#include "host/pipeline/bake_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include <unistd.h>

#include "host/bake/checkpoint.h"
#include "host/bake/expected_look.h"
#include "host/bake/folder.h"
#include "host/bake/identity.h"
#include "host/bake/options.h"
#include "host/bake/torn_contact.h"
#include "host/base/content_hash.h"
#include "host/build/cache.h"
#include "host/build/filled_body.h"
#include "host/drive/drive_source.h"
#include "host/pipeline/long_wait.h"
#include "host/pipeline/text.h"
#include "host/rig/pose.h"

namespace fascicle::pipeline {
namespace {

// s of the clip's first and last key; empty without keys.
std::optional<std::pair<double, double>> key_times(const rig::Clip& clip) {
  std::optional<std::pair<double, double>> range;
  const auto add = [&](const std::vector<double>& times) {
    if (times.empty()) return;
    if (!range) range = {times.front(), times.back()};
    range = {std::min(range->first, times.front()), std::max(range->second, times.back())};
  };
  for (const rig::Channel& channel : clip.channels) add(channel.times);
  for (const rig::WeightChannel& channel : clip.weights) add(channel.times);
  return range;
}

const rig::Clip* clip_of(const scene::Scene& scene) {
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  return character == nullptr ? nullptr : rig::find_clip(*character, scene.clip);
}

// A warning if many of the frames lie outside the clip's keys, where it stands still, or empty. Handles do so
// by intention, and so does a pose.
std::string warning_of_held_frames(const scene::Scene& scene, const rig::Clip& clip) {
  constexpr double longest_unsaid = 0.5;  // s
  const auto keys = key_times(clip);
  if (!keys || keys->first == keys->second) return "";
  const double handles = static_cast<double>(scene.motion.handles) / scene.fps;
  // A held end includes the handles after it.
  const double start = scene.start + handles, end = scene.end - (scene.motion.hold > 0.0 ? 0.0 : handles);
  const double before = std::min(keys->first, end) - start, after = end - std::max(keys->second, start);
  const auto held = [&](const char* pose, double seconds) {
    return std::string("its ") + pose + " pose is held for " +
           counted_text(static_cast<std::uint64_t>(std::lround(seconds * scene.fps)), "frame", "frames");
  };
  std::string text;
  if (before > longest_unsaid)
    text = held("first", before) + (start + before < end
                                        ? "; --start " + number_text(keys->first, 4) + " leaves them out"
                                        : std::string());
  if (after > longest_unsaid)
    text += (text.empty() ? "" : ", and ") + held("last", after) +
            (end - after > start ? "; --end " + number_text(keys->second, 4) + " leaves them out" : "");
  if (text.empty()) return "";
  return "the clip has keys from " + number_text(keys->first, 4) + " to " + number_text(keys->second, 4) +
         " s: " + text;
}

// A warning about the clip before anything is built, or empty.
std::string warning_of_clip(const scene::Scene& scene) {
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  if (character == nullptr) return "";
  if (const rig::Clip* clip = clip_of(scene)) return warning_of_held_frames(scene, *clip);
  if (!character->clips.empty()) return "";
  const std::uint64_t frames = scene::frame_count(scene);
  return "the character has no clip: " +
         (frames == 1 ? std::string("its rest pose is baked")
                      : "its skeleton stands still for " + count_text(frames) + " frames") +
         "; export it with an animation, or give --end for a longer bake";
}

// False for a robot, which has no flesh to feel anything.
bool is_soft(const model::Model& model) {
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (!model.is_kinematic(i)) return true;
  return false;
}

// A warning if the skeleton accelerates flesh beyond the limit on what it feels, or empty.
std::string warning_of_throws(const scene::Scene& scene, const model::Model& model,
                              drive::DriveSource& drives, const drive::DriveSource::GoesOn& goes_on) {
  constexpr std::size_t most_named = 4;
  if (!is_soft(model)) return "";
  const std::vector<drive::DriveSource::Thrown> thrown = drives.thrown(goes_on);
  if (thrown.empty()) return "";
  const auto& skeleton = std::get<rig::Character>(scene.geometry).skeleton;
  std::string text = "the clip accelerates flesh beyond motion.acceleration_limit, " +
                     number_text(drives.acceleration_limit(thrown.front().joint), 3) +
                     " m/s^2, and flesh feels only that much: ";
  for (std::size_t k = 0; k < std::min(thrown.size(), most_named); ++k)
    text += (k == 0 ? "joint " : ", ") + skeleton[thrown[k].joint].name + " by " +
            number_text(thrown[k].acceleration, 3) + " at " + number_text(thrown[k].time, 3) + " s (frame " +
            std::to_string(thrown[k].frame) + ")";
  if (thrown.size() > most_named) text += ", and " + std::to_string(thrown.size() - most_named) + " more";
  // Until the first key its pose is held, and then the skeleton moves at once.
  const rig::Clip* clip = clip_of(scene);
  const auto keys = clip != nullptr ? key_times(*clip) : std::nullopt;
  if (keys && keys->first > scene.start && thrown.front().time <= keys->first + 2.0 / scene.fps)
    return text + "; there the clip's first key ends a pose that is held: --start " +
           number_text(keys->first, 4) + " begins with the motion";
  return text + "; look for keys that jump there, or raise the limit if the motion is meant";
}

// A warning if a root jumps, or empty. Flesh is carried along, which looks wrong where speed was meant.
std::string warning_of_jumps(const scene::Scene& scene, const model::Model& model,
                             drive::DriveSource& drives) {
  if (!is_soft(model)) return "";
  const std::vector<drive::Timeline::Jump> jumps = drives.jumps();
  if (jumps.empty()) return "";
  const drive::Timeline::Jump& first = jumps.front();
  const std::string root = scene.characters.empty()
                               ? std::string("the root")
                               : "the root of " + scene.characters[first.character].settings.name;
  return root + " jumps by " + number_text(first.distance, 3) + " m in frame " + std::to_string(first.frame) +
         (jumps.size() > 1 ? ", and " + count_text(jumps.size() - 1) + " more do" : std::string()) +
         ": flesh is carried along and does not feel it; if that is meant, list the times in motion.cuts, "
         "and if "
         "it is a quick motion, set motion.cut_distance above its length";
}

// Caches starts next to the filled bodies, under keys that include the hash of the build programs.
void keep_starts(const build::BuildOptions& paths, bake::BakeOptions& options) {
  const std::optional<std::string> programs = build::hash_of_programs(paths);
  if (!programs) return;
  const build::Cache cache(paths.cache);
  const auto name = [programs = *programs](const std::string& key) {
    base::ContentHash hash;
    hash.add(std::string_view("start"));
    hash.add(std::string_view(programs));
    hash.add(std::string_view(key));
    return hash.text();
  };
  options.find_start = [cache, name](const std::string& key) { return cache.find(name(key)); };
  options.keep_start = [cache, name](const std::string& key, std::string_view bytes) {
    cache.put(name(key), bytes);
  };
}

constexpr const char* how_to_go_on =
    "; finished frames are kept: --resume continues the bake, on this device or on another (--device cpu)";

// Takes the next of the request's devices that can run the model.
void take_device(PreparedBake& prepared, const BakeRequest& request, const Say& say) {
  for (;;) {
    DeviceRequest device = request.devices.at(prepared.devices_tried++);
    device.keeps_pipelines = !request.build.cache.empty();
    device.cache = request.build.cache;
    try {
      prepared.simulation = choose_simulation(device, request.threads, prepared.built.model,
                                              solver_options(prepared.scene, prepared.built.steps), say);
      return;
    } catch (const NoSuchDevice& error) {
      if (prepared.devices_tried == request.devices.size()) throw;
      say_warning(say, error.what());
    } catch (const gpu::DeviceLost& error) {
      if (prepared.devices_tried == request.devices.size())
        throw DeviceFailed(std::string("the device failed: ") + error.what() + how_to_go_on);
      say_warning(say, error.what());
    }
  }
}

// Runs `work` on the current device; if it fails, on the next one, until none is left.
template <class Work>
auto on_a_device(PreparedBake& prepared, const BakeRequest& request, const Say& say, const Work& work) {
  const auto go_on_after = [&](const std::string& what) {
    say_warning(say, what + "; the next device continues");
    prepared.warnings.push_back(what + "; another device continued");
    // Destroy the solver before its device.
    prepared.simulation.solver.reset();
    try {
      take_device(prepared, request, say);
    } catch (const NoSuchDevice& none) {
      throw DeviceFailed(what + "; and " + none.what() + how_to_go_on);
    }
  };
  for (;;) {
    try {
      return work();
    } catch (const gpu::DeviceError& error) {
      const ChosenDevice& device = prepared.simulation.device;
      const std::string what =
          device.label() + " (" + device.description().name + ") failed: " + error.what();
      if (prepared.devices_tried == request.devices.size()) throw DeviceFailed(what + how_to_go_on);
      go_on_after(what);
    } catch (const NoSuchDevice& error) {
      // A device that ran one solver may have no memory for the next one.
      if (prepared.devices_tried == request.devices.size()) throw;
      go_on_after(error.what());
    }
  }
}

bool is_interrupted(const BakeRequest& request) {
  return request.interrupted != nullptr && request.interrupted->load();
}

void make_solver_if_none(PreparedBake& prepared) {
  Simulation& simulation = prepared.simulation;
  if (!simulation.solver)
    simulation.solver = simulation.device.make_solver(prepared.built.model,
                                                      solver_options(prepared.scene, prepared.built.steps));
}

// Bakes the frames for a trial of their look.
bake::TriedLook tried_on_a_device(PreparedBake& prepared, const BakeRequest& request, const Say& say,
                                  drive::DriveSource& drives, const bake::TriedFrames& frames,
                                  std::uint64_t most_over = std::numeric_limits<std::uint64_t>::max()) {
  LongWait wait(say);
  return on_a_device(prepared, request, say, [&] {
    make_solver_if_none(prepared);
    return bake::try_look(prepared.scene, prepared.built.model, *prepared.look_body, drives,
                          *prepared.simulation.solver, frames, [&](const bake::TriedLook& tried) {
                            wait.go_on("still before frame 0, checking the look of frames " +
                                       count_text(frames.first + 1) + " to " + count_text(frames.last));
                            if (request.on_lead_in) request.on_lead_in();
                            return !is_interrupted(request) && tried.frames_over < most_over;
                          });
  });
}

// What the bake that is to be resumed decided about contact.unless_torn: BakeOptions::contact_left_out.
// Nothing if there is none.
std::optional<std::string> decided_before(const scene::Scene& scene, const BakeRequest& request) {
  const std::filesystem::path& folder = request.output.folder;
  if (!scene.contact.unless_torn || !request.output.resume || request.writes_nothing ||
      !bake::holds_bake(folder))
    return std::nullopt;
  const auto checkpoint = bake::read_checkpoint(folder / bake::checkpoint_name);
  return checkpoint ? bake::contact_left_out(checkpoint->identity) : std::nullopt;
}

// The device goes from one to the other; the solver stays behind and ends, because it refers to both.
void hand_device(PreparedBake& from, PreparedBake& to) {
  from.simulation.solver.reset();
  to.simulation.device = std::move(from.simulation.device);
  to.devices_tried = from.devices_tried;
  to.warnings = from.warnings;
}

// contact.unless_torn: the same bake without contact of the body with itself, if trials show that this tears
// the skin; else null. `prepared` has a device afterwards if there were trials.
std::unique_ptr<PreparedBake> without_torn_contact(PreparedBake& prepared, const BakeRequest& request,
                                                   const Say& say) {
  const scene::Scene& scene = prepared.scene;
  if (!scene.contact.unless_torn || !scene.contact.self || !prepared.look_body || !bake::can_try_look(scene))
    return nullptr;
  drive::DriveSource drives(scene, prepared.built.model, prepared.built.steps.substeps);
  LongWait wait(say);
  const std::vector<bake::DrivenFlesh> found = bake::driven_flesh(scene, prepared.built.model, drives, [&] {
    wait.go_on("still before frame 0, looking for poses that lay flesh into flesh");
    return !is_interrupted(request);
  });
  prepared.is_undecided = is_interrupted(request);
  for (const bake::DrivenFlesh& driven : found) {
    if (prepared.is_undecided) return nullptr;
    if (!prepared.simulation.solver) take_device(prepared, request, say);
    bake::TriedFrames frames = bake::frames_to_try(scene, driven);
    const bake::TriedLook with =
        tried_on_a_device(prepared, request, say, drives, frames, bake::enough_frames_over);
    prepared.is_undecided = is_interrupted(request);
    if (prepared.is_undecided) return nullptr;
    prepared.tried = with;
    if (with.is_finite && with.worst.score <= 1.0) continue;
    auto other = std::make_unique<PreparedBake>();
    other->scene = scene;
    other->scene.contact.self = false;
    other->built = build_scene(other->scene, request.build, say);
    other->look_body = bake::look_body_of(other->scene, other->built.model);
    hand_device(prepared, *other);
    drive::DriveSource same_drives(other->scene, other->built.model, other->built.steps.substeps);
    frames.last = with.last;
    const bake::TriedLook without = tried_on_a_device(*other, request, say, same_drives, frames);
    prepared.is_undecided = is_interrupted(request);
    if (!prepared.is_undecided && bake::tears(with, without)) {
      other->tried = without;
      other->contact_left_out = bake::torn_contact_warning(scene, driven, with, without);
      return other;
    }
    hand_device(*other, prepared);
    other.reset();
    on_a_device(prepared, request, say, [&] {
      make_solver_if_none(prepared);
      return true;
    });
    if (prepared.is_undecided) return nullptr;
  }
  return nullptr;
}

}  // namespace

std::unique_ptr<PreparedBake> prepare_bake(scene::Scene given, const BakeRequest& request, const Say& say) {
  auto made = std::make_unique<PreparedBake>();
  made->scene = std::move(given);
  const auto warn = [&](const std::string& text) {
    if (text.empty()) return;
    say_warning(say, text);
    made->warnings.push_back(text);
  };
  // Check these before building, not after.
  bake::number_of_first(made->scene, request.output);
  (void)bake::formats_to_write(request.output);
  warn(warning_of_clip(made->scene));
  const bake::BakeOutput& output = request.output;
  if (!request.writes_nothing && !output.overwrite && !output.resume && bake::holds_bake(output.folder))
    throw bake::FolderInUse(
        output.folder.string() +
        ": already holds a bake; --resume continues it, --overwrite starts again, or choose another -o");
  const std::optional<std::string> left_out = decided_before(made->scene, request);
  if (left_out) made->contact_left_out = *left_out;
  if (!made->contact_left_out.empty()) made->scene.contact.self = false;
  made->built = build_scene(made->scene, request.build, say);
  say_warnings(made->built.report, say);
  made->look_body = bake::look_body_of(made->scene, made->built.model);
  if (!left_out)
    if (auto other = without_torn_contact(*made, request, say)) made = std::move(other);
  warn(made->contact_left_out);

  PreparedBake& prepared = *made;
  const scene::Scene& scene = prepared.scene;
  const Built& built = prepared.built;
  drive::DriveSource drives(scene, built.model, built.steps.substeps);
  LongWait wait(say);
  const auto goes_on = [&] {
    wait.go_on("still before frame 0, looking for how hard the clip throws the flesh");
    return !is_interrupted(request);
  };
  const std::string throws = warning_of_throws(scene, built.model, drives, goes_on);
  if (!is_interrupted(request)) {
    warn(throws);
    warn(warning_of_jumps(scene, built.model, drives));
    if (prepared.look_body)
      prepared.expected = bake::expected_look(scene, built.model, *prepared.look_body, drives, goes_on);
  }
  if (is_interrupted(request)) {
    prepared.expected.reset();
    prepared.is_undecided = true;
  }
  if (!prepared.simulation.solver) take_device(prepared, request, say);
  if (prepared.expected && prepared.expected->score >= bake::least_tried_score && bake::can_try_look(scene)) {
    prepared.tried = tried_on_a_device(prepared, request, say, drives,
                                       bake::frames_to_try(scene, prepared.expected->frame));
    // The frames decide, because the estimate may be off by half. If both exceed the limit, the estimate
    // names the remedy.
    if (prepared.tried->worst.score > 1.0)
      warn(prepared.expected->score > 1.0
               ? bake::expected_look_warning(scene, built.model, *prepared.expected)
               : bake::tried_look_warning(scene, *prepared.tried));
  }
  return made;
}

bake::BakeResult run_bake(PreparedBake& prepared, const BakeRequest& request, const Say& say) {
  if (prepared.is_undecided) {
    bake::BakeResult result;
    result.interrupted = true;
    return result;
  }
  std::string device_before;
  return on_a_device(prepared, request, say, [&] {
    bake::BakeOptions options;
    static_cast<bake::BakeOutput&>(options) = request.output;
    // Keep the failed device's frames, unless the next device's bits would differ.
    const std::string device = bake::identity_of(prepared.simulation.device.description());
    if (!device_before.empty()) {
      options.resume = device == device_before;
      options.overwrite = !options.resume;
    }
    device_before = device;
    options.substeps = prepared.built.steps.substeps;
    options.iterations = prepared.built.steps.iterations;
    options.device = prepared.simulation.device.description();
    for (const build::Warning& warning : prepared.built.report.warnings)
      options.warnings.push_back(warning.text);
    options.warnings.insert(options.warnings.end(), prepared.warnings.begin(), prepared.warnings.end());
    options.expected_look = prepared.expected;
    options.tried_look = prepared.tried;
    options.contact_left_out = prepared.contact_left_out;
    if (prepared.look_body) options.look_body = &*prepared.look_body;
    options.open_ends = open_ends_of(prepared.built.report);
    options.interrupted = request.interrupted;
    options.on_frame = request.on_frame;
    options.on_lead_in = [&request, wait = std::make_shared<LongWait>(say),
                          frames = std::uint64_t{0}]() mutable {
      wait->go_on("still before frame 0, frame " + count_text(++frames) + " of the lead-in");
      if (request.on_lead_in) request.on_lead_in();
    };
    if (!request.build.cache.empty()) keep_starts(request.build, options);
    return bake::bake(prepared.scene, prepared.built.model, *prepared.simulation.solver, options);
  });
}

void say_result(const bake::BakeResult& result, const Say& say) {
  if (result.clamped.regions > 0)
    say_warning(say, "muscles: " + std::to_string(result.clamped.regions) +
                         (result.clamped.regions == 1 ? " region" : " regions") + " in frame " +
                         std::to_string(result.clamped.frame) +
                         " would bulge or thin by more than a factor of four, which is the limit; a lower "
                         "gain avoids it");
  for (const std::string& image : result.missing_images)
    say_warning(say, "the character's image " + image +
                         " was not found; character.glb has a white pixel in its place");
  for (const std::string& warning : result.report.warnings) say_warning(say, warning);
  if (result.interrupted) return;
  if (result.look)
    for (const std::string& warning : result.look->warnings) say_warning(say, warning);
  for (const std::string& note : result.report.notes) say_info(say, note);
}

void refuse_unwritable(const std::string& option, const std::string& file, bool folders) {
  if (file.empty()) return;
  std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
  std::error_code ignored;
  while (folders && !std::filesystem::exists(folder, ignored) && folder.has_relative_path())
    folder = folder.parent_path();
  if (!std::filesystem::is_directory(folder, ignored) || ::access(folder.c_str(), W_OK) != 0)
    throw bake::BakeError(option + " " + file + ": " + folder.string() +
                          " is not a writable folder; choose another");
}

}  // namespace fascicle::pipeline
