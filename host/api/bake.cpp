// Bakes and devices of the C API.
#include <atomic>
#include <cmath>
#include <limits>

#include "host/api/boundary.h"
#include "host/api/handles.h"
#include "host/bake/options.h"
#include "host/bake/outputs.h"
#include "host/pipeline/bake_scene.h"

namespace fascicle::api {
namespace {

constexpr double not_given = std::numeric_limits<double>::quiet_NaN();

std::optional<double> given_of(double value) {
  return std::isnan(value) ? std::nullopt : std::optional<double>(value);
}

pipeline::BakeRequest request_of(const fascicle_bake_options& options) {
  pipeline::BakeRequest request;
  if (options.folder == nullptr || *options.folder == 0)
    throw BadArgument("options.folder is empty; give the folder to write");
  request.output.folder = options.folder;
  request.output.formats = texts_of(options.formats, options.format_count, "options.formats");
  const std::vector<std::string> known = bake::accepted_formats();
  for (const std::string& format : request.output.formats)
    if (std::find(known.begin(), known.end(), format) == known.end())
      throw BadArgument("options.formats: there is no \"" + format + "\"; see fascicle_format_name");
  request.output.glb.stride = options.glb_stride;
  request.output.glb.error = given_of(options.glb_error);
  request.output.glb.tolerance = given_of(options.glb_tolerance);
  request.output.glb.compress = given_of(options.glb_compress);
  if (options.glb_stride == 0) throw BadArgument("options.glb_stride is 0; it must be at least 1");
  for (const auto& [name, length] : {std::pair("glb_error", request.output.glb.error),
                                     std::pair("glb_tolerance", request.output.glb.tolerance),
                                     std::pair("glb_compress", request.output.glb.compress)})
    if (length && !(*length >= 0.0 && std::isfinite(*length)))
      throw BadArgument(std::string("options.") + name + " is not a length; give metres, or NaN for none");
  if (options.first_frame < -1)
    throw BadArgument("options.first_frame is " + std::to_string(options.first_frame) +
                      "; it must be at least 0, or -1 for none");
  if (options.first_frame >= 0) request.output.first_number = static_cast<std::uint64_t>(options.first_frame);
  if (options.overwrite != 0 && options.resume != 0)
    throw BadArgument("options.overwrite and options.resume exclude each other; set one");
  request.output.keep_frames = options.keep_frames != 0;
  request.output.usd_skel = options.usd_skel != 0;
  request.output.overwrite = options.overwrite != 0;
  request.output.resume = options.resume != 0;
  request.devices = pipeline::parse_device_order(options.device == nullptr ? "auto" : options.device);
  check_threads(options.threads);
  request.threads = options.threads;
  request.build.mesher = text_of(options.mesher);
  request.build.cache = cache_of(options.cache);
  return request;
}

}  // namespace
}  // namespace fascicle::api

using namespace fascicle;

void fascicle_bake_options_init(fascicle_bake_options* options, size_t struct_size) {
  fascicle_bake_options defaults{};
  defaults.first_frame = -1;
  defaults.keep_frames = 1;
  defaults.glb_stride = 1;
  defaults.glb_error = defaults.glb_tolerance = defaults.glb_compress = api::not_given;
  api::fill(options, struct_size, defaults);
}

fascicle_status fascicle_bake_run(const fascicle_scene* scene, const fascicle_bake_options* options,
                                  fascicle_bake** bake) {
  if (bake != nullptr) *bake = nullptr;
  return api::guarded([&] {
    api::must_have(scene, "scene");
    const auto taken = api::taken(options, fascicle_bake_options_init, "options");
    pipeline::BakeRequest request = api::request_of(taken);
    std::atomic<bool> cancelled = false;
    const auto report = [&](fascicle_phase phase, std::uint64_t done, std::uint64_t total) {
      if (taken.progress != nullptr && taken.progress(taken.progress_user, phase, done, total) != 0)
        cancelled = true;
    };
    request.interrupted = &cancelled;
    request.on_frame = [&](std::uint64_t frame, std::uint64_t frames) {
      report(FASCICLE_PHASE_FRAMES, frame, frames);
    };
    std::uint64_t led = 0;
    request.on_lead_in = [&] { report(FASCICLE_PHASE_LEAD_IN, led++, 0); };
    request.build.is_cancelled = [&] {
      report(FASCICLE_PHASE_BUILD, 0, 0);
      return cancelled.load();
    };
    if (request.build.is_cancelled()) throw api::Cancelled("cancelled before the model was built");
    const pipeline::Say say = api::say_to(taken.log, taken.log_user);
    pipeline::refuse_unwritable("options.folder", (request.output.folder / "").string(), true);
    const auto prepared = pipeline::prepare_bake(scene->scene, request, say);
    auto made = std::make_unique<fascicle_bake>();
    made->result = pipeline::run_bake(*prepared, request, say);
    for (const auto& file : made->result.files) made->files.push_back(file.string());
    pipeline::say_result(made->result, say);
    const bool interrupted = made->result.interrupted;
    const std::uint64_t done = made->result.frames_done;
    if (bake != nullptr) *bake = made.release();
    if (interrupted)
      throw api::Cancelled("cancelled after frame " + std::to_string(done) + " of " +
                           std::to_string(scene::frame_count(prepared->scene)) +
                           "; the same bake with options.resume continues");
  });
}

void fascicle_bake_destroy(fascicle_bake* bake) {
  delete bake;
}

uint64_t fascicle_bake_frames(const fascicle_bake* bake) {
  return bake == nullptr ? 0 : bake->result.frames_done;
}

const char* fascicle_bake_position_hash(const fascicle_bake* bake) {
  return bake == nullptr ? nullptr : bake->result.last_position_hash.c_str();
}

size_t fascicle_bake_file_count(const fascicle_bake* bake) {
  return bake == nullptr ? 0 : bake->files.size();
}

const char* fascicle_bake_file(const fascicle_bake* bake, size_t index) {
  return index < fascicle_bake_file_count(bake) ? bake->files[index].c_str() : nullptr;
}

double fascicle_bake_look(const fascicle_bake* bake) {
  return bake == nullptr || !bake->result.look ? api::not_given : bake->result.look->worst;
}

const char* fascicle_format_name(size_t index) {
  return api::text_or_null([&] {
    const std::vector<std::string>& names = bake::format_names();
    return index < names.size() ? names[index].c_str() : nullptr;
  });
}

void fascicle_device_options_init(fascicle_device_options* options, size_t struct_size) {
  api::fill(options, struct_size, fascicle_device_options{});
}

fascicle_status fascicle_device_open(const char* name, const fascicle_device_options* options,
                                     fascicle_device** device) {
  return api::guarded_make(device, [&] {
    const auto taken = api::taken(options, fascicle_device_options_init, "options");
    pipeline::DeviceRequest request = pipeline::parse_device(name == nullptr ? "auto" : name);
    api::check_threads(taken.threads);
    request.cache = api::cache_of(taken.cache);
    request.keeps_pipelines = !request.cache.empty();
    auto made = std::make_unique<fascicle_device>();
    made->device = std::make_shared<pipeline::ChosenDevice>(
        pipeline::choose_device(request, taken.threads, api::say_to(taken.log, taken.log_user)));
    made->text = made->device->text();
    return made;
  });
}

void fascicle_device_destroy(fascicle_device* device) {
  api::destroy_in_own_process(device);
}

const char* fascicle_device_text(const fascicle_device* device) {
  return device == nullptr ? nullptr : device->text.c_str();
}

int fascicle_device_is_exact(const fascicle_device* device) {
  return device != nullptr && device->device->description().exact ? 1 : 0;
}
