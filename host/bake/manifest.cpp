#include "host/bake/manifest.h"

#include <algorithm>
#include <limits>

#include "host/bake/bake.h"
#include "host/bake/checkpoint.h"
#include "host/bake/model_file.h"
#include "host/bake/outputs.h"
#include "host/bake/read_frame_cache.h"
#include "host/bake/sealed_json.h"
#include "host/base/json_text.h"
#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/base/version.h"
#include "host/formats/blender_script.h"
#include "host/formats/character_file.h"
#include "host/formats/formats.h"
#include "host/formats/rest_mesh.h"
#include "host/formats/surface_objects.h"
#include "host/model/surroundings.h"
#include "host/scene/scene_json.h"

namespace fascicle::bake {

using scene::Json;
using scene::json_of;

namespace fs = std::filesystem;

namespace {

constexpr const char* kind = "fascicle bake";

Json json_of(const model::Model& model, std::uint64_t hash) {
  std::vector<std::uint64_t> vertices(model.layers.size(), 0);
  std::vector<double> mass(model.layers.size(), 0.0);
  const std::vector<char> is_beside = model::surroundings_of(model).vertices;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    ++vertices.at(model.layer_of(i));
    if (is_beside[i] == 0) mass.at(model.layer_of(i)) += model.mass[i];
  }
  Json layers = Json::array();
  for (std::size_t k = 0; k < model.layers.size(); ++k)
    layers.push_back({{"name", model.layers[k].name},
                      {"vertices", vertices[k]},
                      {"mass", mass[k]},
                      {"damping", model.layers[k].damping},
                      {"frequency", model.layers[k].frequency}});
  Json probes = Json::object();
  for (const model::ProbeSet& probe : model.probes) probes[probe.name] = probe.vertices.size();
  return {{"hash", base::hash_text(hash)},
          {"unit", model.unit},
          {"rest_origin", model.rest_origin},
          {"weights", name_of(model.weight_form)},
          {"momentum_scaled", model.momentum_scaled},
          {"vertices", model.vertex_count},
          {"tetrahedra", model.tetrahedron_count()},
          {"surface_vertices", model.surface_count()},
          {"surface_triangles", model.surface_triangle.size() / 3},
          {"joints", model.joint_count},
          {"muscles", model.muscle_count},
          {"layers", std::move(layers)},
          {"probes", std::move(probes)}};
}

std::string text_in(const fs::path& folder) {
  return base::read_input_if_there(folder / manifest_name, base::most_json_bytes).value_or("");
}

// Null if it is not one of ours, or damaged.
Json manifest_of_text(const std::string& text) {
  Json manifest = Json::parse(base::shallow_json(text), nullptr, false);
  return manifest.is_object() && manifest.value("kind", Json()) == kind && !is_damaged(manifest) ? manifest
                                                                                                 : Json();
}
Json manifest_in(const fs::path& folder) {
  return manifest_of_text(text_in(folder));
}

std::vector<std::string> files_of(const Json& manifest) {
  std::vector<std::string> names;
  if (const auto files = manifest.find("files"); files != manifest.end() && files->is_array())
    for (const Json& name : *files)
      if (name.is_string()) names.push_back(name.get<std::string>());
  return names;
}

Json json_of(const DeviceDescription& device) {
  return {{"solver", device.solver}, {"name", device.name},
          {"driver", device.driver}, {"float_controls", device.float_controls},
          {"exact", device.exact},   {"threads", device.threads}};
}

Json json_of(const std::vector<OpenEndEntry>& ends) {
  Json list = Json::array();
  for (const OpenEndEntry& end : ends)
    list.push_back({{"joint", end.joint},
                    {"became", end.became},
                    {"width_m", end.width},
                    {"edges", end.edges},
                    {"vertex", end.vertex}});
  return list;
}

Json json_of(const drive::LeadInSummary& led) {
  const auto or_null = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  return {{"preroll_frames", led.preroll_frames},
          {"settle_frames", led.settle_frames},
          {"was_kept", led.was_kept},
          {"settled_speed", or_null(led.settled_speed)},
          {"cycles", led.cycles},
          {"cycle_jump", or_null(led.jump)}};
}

void read_count(const Json& json, const char* key, std::uint64_t& out) {
  if (!json.is_object()) return;
  if (const auto entry = json.find(key); entry != json.end() && entry->is_number_unsigned())
    out = entry->get<std::uint64_t>();
}

Json json_of(const std::optional<LookSummary>& look) {
  if (!look) return nullptr;
  return {{"worst", look->worst},
          {"frame", look->frame},
          {"joint", look->joint},
          {"cause", look->cause},
          {"frames_over", look->frames_over}};
}

Json json_of(const std::optional<ExpectedLook>& expected, const scene::Scene& scene,
             const model::Model& model) {
  if (!expected) return nullptr;
  return {{"score", expected->score},
          {"frame", expected->frame},
          {"joint", std::get<rig::Character>(scene.geometry).skeleton[expected->joint].name},
          {"layer", model.layers[expected->layer].name},
          {"stiffer", expected->stiffer}};
}

Json json_of(const std::optional<TriedLook>& tried, const scene::Scene& scene) {
  if (!tried) return nullptr;
  return {{"first", tried->first + 1},
          {"last", tried->last},
          {"score", tried->worst.score},
          {"frame", tried->frame},
          {"joint", std::get<rig::Character>(scene.geometry).skeleton[tried->worst.joint].name},
          {"cause", name_of(tried->cause)},
          {"frames_over", tried->frames_over}};
}

// Reads what json_of wrote; entries that are missing or of the wrong type keep their defaults.
drive::LeadInSummary lead_in_of(const Json& json) {
  drive::LeadInSummary led;
  if (!json.is_object()) return led;
  const auto read = [&](const char* key, auto& out) {
    if (const auto entry = json.find(key); entry != json.end() && entry->is_number())
      out = entry->get<double>();
  };
  read_count(json, "preroll_frames", led.preroll_frames);
  read_count(json, "settle_frames", led.settle_frames);
  read("settled_speed", led.settled_speed);
  read_count(json, "cycles", led.cycles);
  read("cycle_jump", led.jump);
  return led;
}

}  // namespace

const char* name_of(Status status) {
  switch (status) {
    case Status::running:
      return "running";
    case Status::interrupted:
      return "interrupted";
    case Status::not_finite:
      return "not-finite";
    case Status::failed:
      return "failed";
    case Status::complete:
      return "complete";
  }
  return "";
}

std::vector<std::string> file_names(const model::Model& model, const std::vector<std::string>& formats) {
  std::vector<std::string> names{manifest_name, checkpoint_name, model_file_name};
  if (model.has_skeleton()) names.push_back(formats::character_name);
  if (model.surface_count() > 0) {
    names.push_back(formats::rest_name);
    names.push_back(formats::blender_script_name);
    // Written only if the file has materials.
    if (model.has_skeleton()) {
      names.push_back(formats::rest_materials_name);
      names.push_back(std::string(formats::textures_folder) + '/');
    }
  }
  for (const formats::Format& format : all_formats())
    if (format.name.empty() || std::find(formats.begin(), formats.end(), format.name) != formats.end())
      names.push_back(format.file);
  return names;
}

std::vector<std::string> all_file_names() {
  std::vector<std::string> names{manifest_name,
                                 checkpoint_name,
                                 model_file_name,
                                 formats::character_name,
                                 formats::rest_name,
                                 formats::rest_materials_name,
                                 formats::blender_script_name,
                                 std::string(formats::textures_folder) + '/'};
  for (const formats::Format& format : all_formats()) names.push_back(format.file);
  return names;
}

std::string manifest_text(const scene::Scene& scene, const model::Model& model, const BakeOptions& options,
                          std::uint64_t hash, const Progress& progress) {
  Json hashes = Json::array();
  for (const std::uint64_t value : progress.position_hashes) hashes.push_back(base::hash_text(value));
  Json inputs = Json::array();
  for (const auto& [file, file_hash] : scene.input_hashes)
    inputs.push_back({{"file", file}, {"xxh3_64", file_hash}});
  // Frame 0 is the pose at the start and is written too.
  const std::uint64_t frames_done = hashes.empty() ? 0 : hashes.size() - 1;
  std::vector<std::string> warnings = options.warnings;
  warnings.insert(warnings.end(), progress.warnings.begin(), progress.warnings.end());
  if (progress.look)
    warnings.insert(warnings.end(), progress.look->warnings.begin(), progress.look->warnings.end());
  const std::uint64_t first_number = number_of_first(scene, options);
  Json of_scene = json_of(scene);
  of_scene["solver"]["substeps"] = substeps_of(scene, options);
  of_scene["solver"]["iterations"] = iterations_of(scene, options);
  std::vector<std::string> files = file_names(model, options.formats);
  if (!progress.frames_kept) std::erase(files, cache_name);
  files.insert(files.end(), progress.exported.begin(), progress.exported.end());
  Json manifest{
      {"kind", kind},
      {"version", sealed_json_version},
      {"fascicle", {{"version", base::fascicle_version}, {"solver_version", base::solver_version}}},
      {"status", name_of(progress.status)},
      {"message", progress.message},
      {"frames_done", frames_done},
      {"frames", scene::frame_count(scene)},
      {"files", std::move(files)},
      {"formats", options.formats},
      {"output",
       {{"fps", scene.fps},
        {"first_frame", first_number},
        {"handles", scene.motion.handles},
        {"range",
         {first_number + scene.motion.handles,
          first_number + scene::frame_count(scene) - scene.motion.handles}},
        {"first_frame_seconds", scene.start},
        {"meters_per_unit", 1},
        {"up_axis", "Y"},
        {"handedness", "right"},
        {"usd_skel", options.usd_skel},
        {"glb_stride", options.glb.stride},
        {"glb_error", options.glb.error ? Json(*options.glb.error) : Json(nullptr)},
        {"glb_tolerance", options.glb.tolerance ? Json(*options.glb.tolerance) : Json(nullptr)},
        {"glb_compress", options.glb.compress ? Json(*options.glb.compress) : Json(nullptr)}}},
      {"device", json_of(options.device)},
      {"scene", std::move(of_scene)},
      {"lead_in", json_of(progress.lead_in)},
      {"clamped_muscles", {{"regions", progress.clamped.regions}, {"frame", progress.clamped.frame}}},
      {"loop_jump", progress.loop_jump ? Json(*progress.loop_jump) : Json(nullptr)},
      {"look", json_of(progress.look)},
      {"expected_look", json_of(options.expected_look, scene, model)},
      {"tried_look", json_of(options.tried_look, scene)},
      {"inputs", std::move(inputs)},
      {"model", json_of(model, hash)},
      {"warnings", warnings},
      {"open_ends", json_of(options.open_ends)},
      {"timings",
       {{"solver_seconds", progress.timings.solver},
        {"writing_seconds", progress.timings.writing},
        {"total_seconds", progress.timings.total},
        {"runs", progress.timings.runs}}},
      {"position_hashes", std::move(hashes)}};
  if (!progress.frames_kept) manifest["frames_kept"] = false;
  return sealed_text(std::move(manifest), 2) + '\n';
}

std::string frames_not_kept_text(const fs::path& folder) {
  return folder.string() +
         ": the frames of this bake were not kept (--keep-frames false); bake again with --overwrite and "
         "without that option";
}

std::optional<ManifestSummary> read_manifest(const fs::path& folder) {
  const Json manifest = manifest_in(folder);
  if (manifest.is_null()) return std::nullopt;
  ManifestSummary summary;
  summary.files = files_of(manifest);
  const auto text_at = [](const Json& object, const char* key) {
    const auto entry = object.find(key);
    return entry != object.end() && entry->is_string() ? entry->get<std::string>() : std::string();
  };
  summary.status = text_at(manifest, "status");
  summary.message = text_at(manifest, "message");
  if (const auto kept = manifest.find("frames_kept"); kept != manifest.end() && kept->is_boolean())
    summary.frames_kept = kept->get<bool>();
  read_count(manifest, "frames_done", summary.frames_done);
  read_count(manifest, "frames", summary.frames);
  if (const auto device = manifest.find("device"); device != manifest.end() && device->is_object())
    summary.device = text_at(*device, "solver") + ", " + text_at(*device, "name");
  if (const auto warnings = manifest.find("warnings"); warnings != manifest.end() && warnings->is_array())
    for (const Json& warning : *warnings)
      if (warning.is_string()) summary.warnings.push_back(warning.get<std::string>());
  if (const auto scene = manifest.find("scene"); scene != manifest.end() && scene->is_object()) {
    summary.scene_name = text_at(*scene, "name");
    summary.scene_source = text_at(*scene, "source");
    summary.scene_text = text_at(*scene, "text");
  }
  if (const auto inputs = manifest.find("inputs"); inputs != manifest.end() && inputs->is_array())
    for (const Json& input : *inputs)
      if (input.is_object())
        summary.input_hashes.emplace_back(text_at(input, "file"), text_at(input, "xxh3_64"));
  if (const auto hashes = manifest.find("position_hashes"); hashes != manifest.end() && hashes->is_array()) {
    for (const Json& hash : *hashes)
      summary.position_hashes.push_back(hash.is_string() ? hash.get<std::string>() : "");
    if (!summary.position_hashes.empty()) summary.last_position_hash = summary.position_hashes.back();
  }
  const auto timings = manifest.find("timings");
  const auto seconds = [&](const char* key) {
    if (timings == manifest.end() || !timings->is_object()) return 0.0;
    const auto entry = timings->find(key);
    return entry != timings->end() && entry->is_number() ? entry->get<double>() : 0.0;
  };
  summary.timings = {.solver = seconds("solver_seconds"),
                     .writing = seconds("writing_seconds"),
                     .total = seconds("total_seconds"),
                     .runs = static_cast<std::uint64_t>(std::clamp(seconds("runs"), 1.0, 1e9))};
  if (const auto output = manifest.find("output"); output != manifest.end()) {
    read_count(*output, "first_frame", summary.first_number);
    read_count(*output, "handles", summary.handles);
    if (output->is_object())
      if (const auto fps = output->find("fps"); fps != output->end())
        summary.fps = fps->is_number() ? fps->get<double>() : std::numeric_limits<double>::quiet_NaN();
  }
  if (const auto led = manifest.find("lead_in"); led != manifest.end()) summary.lead_in = lead_in_of(*led);
  if (const auto clamped = manifest.find("clamped_muscles"); clamped != manifest.end()) {
    read_count(*clamped, "regions", summary.clamped.regions);
    read_count(*clamped, "frame", summary.clamped.frame);
  }
  return summary;
}

std::vector<std::string> files_listed(const fs::path& folder) {
  const std::string text = text_in(folder);
  if (const Json manifest = manifest_of_text(text); !manifest.is_null()) return files_of(manifest);
  std::vector<std::string> names;
  if (text.find('"' + std::string(kind) + '"') == std::string::npos) return names;
  const std::size_t begin = text.find("\"files\"");
  if (begin == std::string::npos) return names;
  const std::string list = text.substr(begin, text.find(']', begin) - begin);
  for (std::string& name : all_file_names())
    if (list.find('"' + name + '"') != std::string::npos) names.push_back(std::move(name));
  return names;
}

ManifestSummary manifest_of(const fs::path& folder) {
  if (!fs::exists(folder)) throw BakeError(folder.string() + ": no such folder");
  std::optional<ManifestSummary> manifest = read_manifest(folder);
  if (!manifest)
    throw BakeError(folder.string() + ": holds no bake (" + manifest_name + " is missing or damaged)");
  return std::move(*manifest);
}

namespace {

void write_status(const fs::path& folder, Json& manifest, Status status, const std::string& message) {
  const fs::path path = folder / manifest_name;
  manifest["status"] = name_of(status);
  manifest["message"] = message;
  try {
    base::write_whole(path, sealed_text(manifest, 2) + '\n');
  } catch (const std::system_error&) {
    // The text without indentation is shorter. Padding it with spaces overwrites all old bytes, without a
    // later step that a crash could prevent.
    std::string text = sealed_text(manifest);
    base::File file(path, base::FileMode::modify);
    const std::uint64_t room = file.size();
    if (text.size() + 1 > room) throw;
    text.resize(room - 1, ' ');
    file.write_at(0, text + '\n');
    file.sync();
  }
}

}  // namespace

void set_status(const fs::path& folder, Status status, const std::string& message) {
  Json manifest = manifest_in(folder);
  if (manifest.is_null()) return;
  write_status(folder, manifest, status, message);
}

void set_running_from(const fs::path& folder, std::uint64_t frame) {
  Json manifest = manifest_in(folder);
  if (manifest.is_null()) return;
  Json& hashes = manifest["position_hashes"];
  if (hashes.is_array() && hashes.size() > frame + 1) {
    hashes.erase(hashes.begin() + static_cast<std::ptrdiff_t>(frame + 1), hashes.end());
    manifest["frames_done"] = frame;
  }
  write_status(folder, manifest, Status::running, "");
}

void add_to_manifest(const fs::path& folder, const std::vector<std::string>& files) {
  Json manifest = manifest_in(folder);
  if (!manifest.is_object() || !manifest["files"].is_array())
    throw BakeError((folder / manifest_name).string() +
                    ": is missing or damaged; bake again with --overwrite");
  Json& list = manifest["files"];
  for (const std::string& name : files)
    if (std::find(list.begin(), list.end(), name) == list.end()) list.push_back(name);
  base::write_whole(folder / manifest_name, sealed_text(std::move(manifest), 2) + '\n');
}

}  // namespace fascicle::bake
