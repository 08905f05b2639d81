// fascicle validate: checks that several devices produce the same bits from the same drives.
#include <algorithm>
#include <iostream>
#include <memory>

#include <nlohmann/json.hpp>

#include "host/base/file.h"
#include "host/base/text.h"
#include "host/cli/command.h"
#include "host/cli/compare_devices.h"
#include "host/cli/convergence.h"
#include "host/cli/progress.h"
#include "host/cli/text.h"
#include "host/cli/validate_page.h"
#include "host/pipeline/bake_scene.h"
#include "host/pipeline/device_choice.h"

namespace fascicle::cli {
namespace {

using Json = nlohmann::ordered_json;

struct ValidateArguments {
  SceneArguments scene;
  std::string devices = "cpu,vulkan", html;
  std::uint64_t frames = 0;  // 0: all frames of the scene
  unsigned threads = 0;
  bool json = false, oracle = true, converged = false;
};

// For a stage whose output is per model vertex, the vertex's number in the tetrahedral mesh.
std::optional<std::uint32_t> source_number(const model::Model& model, const model::Difference& difference) {
  if (difference.where.stage == model::Stage::embed || difference.item >= model.source_vertex.size())
    return std::nullopt;
  return model.source_vertex[difference.item];
}

Json json_of(const model::Difference& difference, const model::Model& model) {
  Json object{{"frame", difference.where.frame},
              {"substep", difference.where.substep},
              {"stage", model::name_of(difference.where.stage)},
              {"item", difference.item}};
  const std::optional<std::uint32_t> source = source_number(model, difference);
  object["source_vertex"] = source ? Json(*source) : Json();
  object["component"] = difference.component;
  // As text, because JSON has no NaN or infinity.
  object["a"] = {{"value", float_text(difference.a)}, {"bits", bits_text(difference.a)}};
  object["b"] = {{"value", float_text(difference.b)}, {"bits", bits_text(difference.b)}};
  object["ulp"] = difference.ulp;
  return object;
}

Json json_of(const model::Distance& distance, double relative) {
  return {{"largest_m", distance.largest}, {"rms_m", distance.rms}, {"frame", distance.frame},
          {"vertex", distance.vertex},     {"relative", relative},  {"bound", oracle_bound}};
}

Json json_of(const Comparison& comparison, const model::Model& model) {
  Json object{{"a", comparison.a},
              {"b", comparison.b},
              {"by", comparison.exact ? "bits" : "tolerance"},
              {"holds", comparison.holds()}};
  if (!comparison.exact) {
    object["distance"] = json_of(comparison.distance, comparison.relative);
    return object;
  }
  const HashComparison& hashes = comparison.hashes;
  object["identical"] = comparison.holds();
  object["starts_identical"] = !comparison.starts_differ;
  object["values_compared"] = comparison.values;
  object["first_difference"] = comparison.difference ? json_of(*comparison.difference, model) : Json();
  object["unprobed"] = {
      {"frames", hashes.frames},
      {"first_different_frame", hashes.first_different_frame ? Json(*hashes.first_different_frame) : Json()},
      {"last_hash_a", base::hash_text(hashes.last_hash_a)},
      {"last_hash_b", base::hash_text(hashes.last_hash_b)}};
  return object;
}

void print_json(const scene::Scene& scene, const Built& built, const std::vector<ChosenDevice>& devices,
                const Validation& validation) {
  Json object{{"scene", scene.name},
              {"frames", validation.frames},
              {"oracle_frames", validation.oracle_frames},
              {"substeps", built.steps.substeps},
              {"iterations", built.model.is_implicit() ? Json(built.steps.iterations) : Json()},
              {"vertices", built.model.vertex_count},
              {"holds", validation.holds()},
              {"devices", Json::array()},
              {"comparisons", Json::array()},
              {"oracle", Json::array()}};
  for (const ChosenDevice& device : devices)
    object["devices"].push_back({{"device", device.label()},
                                 {"name", device.description().name},
                                 {"driver", device.description().driver},
                                 {"exact", device.description().exact},
                                 {"why_not_exact", device.why_not_exact()}});
  for (const Comparison& comparison : validation.comparisons)
    object["comparisons"].push_back(json_of(comparison, built.model));
  for (const OracleComparison& comparison : validation.oracle) {
    Json entry{{"device", comparison.device}, {"holds", comparison.holds()}};
    entry.update(json_of(comparison.distance, comparison.relative));
    object["oracle"].push_back(entry);
  }
  std::cout << object.dump(2, ' ', false, Json::error_handler_t::replace) << "\n";
}

// "0.0123 mm, 3.1e-05 of the body's extent at most, 1.2e-05 mm RMS; bound 0.001"
std::string distance_text(const model::Distance& distance, double relative) {
  return "at most " + number_text(distance.largest * 1e3) + " mm (frame " + std::to_string(distance.frame) +
         ", vertex " + std::to_string(distance.vertex) + "), RMS " + number_text(distance.rms * 1e3) +
         " mm; " + number_text(relative, 2) + " of the body's extent, bound " + number_text(oracle_bound, 2);
}

std::string difference_text(const model::Difference& difference, const Comparison& comparison,
                            const model::Model& model) {
  const bool render = difference.where.stage == model::Stage::embed;
  std::string item = (render ? "render vertex " : "vertex ") + std::to_string(difference.item);
  if (const auto source = source_number(model, difference))
    item += " (" + std::to_string(*source) + " in the mesh)";
  return "first difference\n" +
         columns_text({{"frame", std::to_string(difference.where.frame)},
                       {"substep", std::to_string(difference.where.substep)},
                       {"stage", model::name_of(difference.where.stage)},
                       {"at", item},
                       {"component", std::to_string(difference.component)},
                       {comparison.a, float_text(difference.a) + "  " + bits_text(difference.a)},
                       {comparison.b, float_text(difference.b) + "  " + bits_text(difference.b)},
                       {"ULP", std::to_string(difference.ulp)}});
}

void print_comparison(const Comparison& comparison, const model::Model& model) {
  const std::string pair = comparison.a + " and " + comparison.b + ": ";
  if (!comparison.exact) {
    std::cout << pair << "not both exact, so compared within a tolerance: "
              << (comparison.holds() ? "within" : "NOT within") << ", "
              << distance_text(comparison.distance, comparison.relative) << "\n";
    return;
  }
  if (comparison.holds()) {
    std::cout << pair << "identical: " << count_text(comparison.values)
              << " values of all stages compared by bits over "
              << counted_text(comparison.hashes.frames, "frame", "frames")
              << "; last position hash without probes " << base::hash_text(comparison.hashes.last_hash_a)
              << " on both\n";
    return;
  }
  std::cout << pair << "DIFFERENT\n";
  if (comparison.starts_differ) {
    std::cout << "the states before frame 1 differ: preroll, settling or the cycles before a seamless loop\n";
    if (!comparison.difference && !comparison.hashes.first_different_frame) return;
  }
  if (comparison.difference)
    std::cout << difference_text(*comparison.difference, comparison, model);
  else
    std::cout << "no stage differs when probed: the fault is in how stages are fused\n";
  if (comparison.hashes.first_different_frame)
    std::cout << "without probes position hashes differ from frame "
              << *comparison.hashes.first_different_frame << ": "
              << base::hash_text(comparison.hashes.last_hash_a) << " and "
              << base::hash_text(comparison.hashes.last_hash_b) << "\n";
  else
    std::cout << "without probes all position hashes are the same: the fault is in how stages are probed\n";
}

void print_text(const model::Model& model, const Validation& validation) {
  for (const Comparison& comparison : validation.comparisons) print_comparison(comparison, model);
  for (const OracleComparison& comparison : validation.oracle)
    std::cout << comparison.device
              << " and the oracle: " << (comparison.holds() ? "within the bound" : "BEYOND THE BOUND")
              << " over " << counted_text(validation.oracle_frames, "frame", "frames") << ": "
              << distance_text(comparison.distance, comparison.relative) << "\n";
  if (!validation.oracle.empty())
    std::cout << "  (the bound: float rounding, 6e-8 of the body per substep, is amplified where a region's "
                 "rotation is ill\n"
                 "  conditioned; the paper's bars stay below 3e-5, fine uneven meshes reached 1e-4; a wrong "
                 "formula\n"
                 "  moves the body by several percent)\n";
}

// Shows one bar after another, each named after the current activity.
class ShownProgress {
 public:
  explicit ShownProgress(Log& log) : log_(log) {}
  void update(const std::string& what, std::uint64_t frame, std::uint64_t last) {
    if (what != running_) {
      running_ = what;
      progress_.emplace(log_, what, last);
    }
    progress_->update(frame);
  }
  void end() { progress_.reset(); }

 private:
  Log& log_;
  std::string running_;
  std::optional<Progress> progress_;
};

std::uint64_t frames_of(const ValidateArguments& arguments, const scene::Scene& scene) {
  const std::uint64_t all = scene::frame_count(scene);
  return arguments.frames == 0 ? all : std::min(arguments.frames, all);
}

// --html. The page is written whatever the result.
void write_page(const ValidateArguments& arguments, const std::string& page) {
  base::write_whole_beside_others(std::filesystem::absolute(arguments.html), page);
}

// --converged
ExitCode validate_steps(const ValidateArguments& arguments, const scene::Scene& scene,
                        const DeviceRequest& request, Log& log) {
  Built built = build(scene, log, arguments.scene.no_cache);
  log_warnings(built.report, log);
  if (!scene.solver.auto_substeps && !built.model.has_skeleton()) {
    // Only a build for automatic substeps computes the lowest modes; it is otherwise the same.
    scene::Scene automatic = scene;
    automatic.solver.auto_substeps = true;
    built.model = build(automatic, log, arguments.scene.no_cache).model;
  }
  const ChosenDevice device = choose_device(request, arguments.threads, say_on(log));
  log.info("device: " + device.text());
  ShownProgress progress(log);
  const Convergence convergence =
      measure_convergence(scene, built, device, frames_of(arguments, scene),
                          [&progress](const auto&... at) { progress.update(at...); });
  progress.end();
  if (!arguments.html.empty()) write_page(arguments, convergence_page(scene, convergence));
  std::cout << (arguments.json ? json_text(convergence, scene.name) : table_text(convergence));
  return ExitCode::done;
}

ExitCode validate_scene(const ValidateArguments& arguments, Log& log) {
  std::vector<DeviceRequest> requests =
      parse_device_list(with_all_devices(arguments.devices, devices_for(arguments.devices)));
  for (DeviceRequest& request : requests) request.keeps_pipelines = !arguments.scene.no_cache;
  if (requests.size() < 2 && !arguments.oracle && !arguments.converged)
    throw UsageError("--devices " + arguments.devices +
                     " with --no-oracle leaves nothing to compare; name two devices");
  if (!arguments.html.empty()) refuse_unwritable("--html", arguments.html);
  const scene::Scene scene = load(arguments.scene);
  if (arguments.converged) return validate_steps(arguments, scene, requests.front(), log);
  const Built built = build(scene, log, arguments.scene.no_cache);
  log_warnings(built.report, log);
  std::vector<ChosenDevice> devices;
  for (const DeviceRequest& request : requests) {
    devices.push_back(choose_device(request, arguments.threads, say_on(log)));
    log.info("device: " + devices.back().text());
  }
  const std::uint64_t frames = frames_of(arguments, scene);
  ShownProgress progress(log);
  const Validation validation =
      validate(scene, built, solver_options(scene, built.steps), devices, frames,
               arguments.oracle ? frames : 0, [&progress](const auto&... at) { progress.update(at...); });
  progress.end();

  if (!arguments.html.empty()) write_page(arguments, validation_page(scene, built, devices, validation));
  if (arguments.json)
    print_json(scene, built, devices, validation);
  else
    print_text(built.model, validation);
  return validation.holds() ? ExitCode::done : ExitCode::difference;
}

}  // namespace

void add_validate(CLI::App& app, Command& command) {
  auto* subcommand =
      app.add_subcommand("validate", "Compare devices bit by bit, and with the oracle in double precision");
  const auto arguments = std::make_shared<ValidateArguments>();
  add_scene_options(*subcommand, arguments->scene, "Scene file, mesh, character or built-in name", true);
  subcommand
      ->add_option("--devices", arguments->devices,
                   "Devices to compare with the first one: cpu, cpu:LEVEL (a level of vector instructions), "
                   "vulkan, vulkan:N, all, separated by commas; default: cpu,vulkan")
      ->option_text("LIST");
  subcommand->add_option("--frames", arguments->frames, "Frames to run; default: the whole scene")
      ->check(CLI::Range(std::uint64_t{1}, ~std::uint64_t{0}).description(""))
      ->option_text("N");
  subcommand->add_option("--threads", arguments->threads, "Threads of the CPU solver; 0: one per core")
      ->check(CLI::Range(0U, 1024U).description(""))
      ->option_text("N");
  subcommand->add_flag("--json", arguments->json, "Print one JSON object");
  subcommand
      ->add_option("--html", arguments->html, "Write the findings as a page too; replaces an existing one")
      ->option_text("FILE");
  subcommand->add_flag("--oracle,!--no-oracle", arguments->oracle,
                       "Measure the distance to the oracle; default: on");
  subcommand->add_flag(
      "--converged", arguments->converged,
      "Compare qualities instead of devices: the distance of the skin from a bake with many more substeps");
  add_log_options(*subcommand, command.log);
  subcommand->callback([arguments, &command] {
    command.run = [arguments](Log& log) { return validate_scene(*arguments, log); };
  });
}

}  // namespace fascicle::cli
