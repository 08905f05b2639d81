#include "host/cli/command.h"

#include <filesystem>
#include <map>
#include <vector>

#include <unistd.h>

#include "host/bake/bake.h"
#include "host/build/cache.h"
#include "host/build/stiffness.h"
#include "host/cli/text.h"
#include "host/scene/scene_table.h"

namespace fascicle::cli {
namespace {

constexpr std::size_t warning_vertices_shown = 8;

}  // namespace

std::string warning_text(const build::Warning& warning) {
  if (warning.vertices.empty()) return warning.text;
  std::string text = warning.text + " (vertices";
  for (std::size_t k = 0; k < warning.vertices.size() && k < warning_vertices_shown; ++k)
    text += " " + std::to_string(warning.vertices[k]);
  return text + (warning.vertices.size() > warning_vertices_shown ? " ...)" : ")");
}

std::string nearest_scene_hint(const std::string& name) {
  std::vector<std::string> names;
  for (const scene::BuiltinScene& scene : scene::builtin_scenes()) names.push_back(scene.name);
  return scene::nearest_name_hint(name, names);
}

void add_log_options(CLI::App& subcommand, LogOptions& log) {
  auto* quiet = subcommand.add_flag_callback(
      "-q,--quiet", [&log] { log.verbosity = Verbosity::quiet; }, "Say nothing on stderr but errors");
  auto* verbose = subcommand.add_flag_callback(
      "-v,--verbose", [&log] { log.verbosity = Verbosity::verbose; }, "Say more on stderr");
  quiet->excludes(verbose);
  const std::map<std::string, LogFormat> formats{{"text", LogFormat::text}, {"json", LogFormat::json}};
  subcommand.add_option("--log-format", log.format, "stderr as text or as JSON, one object a line")
      ->transform(CLI::CheckedTransformer(formats).description(""))
      ->option_text("text|json");
}

void add_glb_options(CLI::App& subcommand, bake::GlbOptions& glb) {
  auto* stride =
      subcommand.add_option("--glb-stride", glb.stride, "glb: a morph target every N frames; default: 1");
  stride->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1000000}).description(""))->option_text("N");
  subcommand
      .add_option("--glb-error", glb.error,
                  "glb: as few morph targets as keep a viewer within M metres of every baked frame; 0.002 is "
                  "a good start")
      ->check(CLI::NonNegativeNumber.description(""))
      ->excludes(stride)
      ->option_text("M");
  subcommand
      .add_option(
          "--glb-tolerance", glb.tolerance,
          "glb: leave vertices to skinning that stand within M metres of it; a millionth of the body's "
          "diagonal without it")
      ->check(CLI::NonNegativeNumber.description(""))
      ->option_text("M");
  subcommand
      .add_option("--glb-compress", glb.compress,
                  "glb: for viewers on the web, quantise so that no vertex moves by more than M metres, and "
                  "compress (EXT_meshopt_compression, which Blender does not read); 0.0001 is a good start")
      ->check(CLI::PositiveNumber.description(""))
      ->option_text("M");
}

void add_usd_options(CLI::App& subcommand, bool& skel) {
  subcommand.add_flag("--usd-skel", skel,
                      "usda: beside the baked points the character by skinning alone, as UsdSkel, with the "
                      "purpose guide");
}

void log_report(const bake::SinkReport& report, Log& log) {
  for (const std::string& note : report.notes) log.info(note);
  for (const std::string& warning : report.warnings) log.warning(warning);
}

void add_scene_options(CLI::App& subcommand, SceneArguments& arguments, const std::string& what,
                       bool required) {
  scene::SceneOverrides& overrides = arguments.overrides;
  subcommand.add_option("SCENE", arguments.name, what)->required(required)->option_text(" ");
  subcommand
      .add_option("--set", overrides.set, "Change a key of the scene, as in layers.fat.alpha=0.2; repeatable")
      ->allow_extra_args(false)
      ->take_all()
      ->check(CLI::Validator(
          [](const std::string& text) {
            const std::size_t equals = text.find('=');
            return equals == std::string::npos || equals == 0 ? "\"" + text + "\" is not KEY=VALUE"
                                                              : std::string();
          },
          ""))
      ->option_text("KEY=VALUE");
  subcommand.add_option("--fps", overrides.fps, "Frames a second");
  subcommand.add_option("--start", overrides.start, "Time of frame 0, s");
  subcommand.add_option("--end", overrides.end, "Time of the last frame, s");
  subcommand.add_option("--clip", overrides.clip,
                        "The character's clip, by name, by the last part of its name, or by number");
  subcommand
      .add_option("--softness", overrides.softness,
                  "How many times as soft all flesh is: 2 halves its stiffness, 0.5 doubles it")
      ->option_text("X");
  subcommand
      .add_option("--exaggerate", overrides.exaggerate,
                  "How many times as far flesh trails and jiggles; at 0 only gravity and forces move it")
      ->option_text("X");
  subcommand
      .add_option("--only", overrides.only,
                  "Simulate only the flesh of this joint and of those below it; repeatable")
      ->allow_extra_args(false)
      ->take_all()
      ->option_text("JOINT");
  subcommand.add_flag(
      "--no-cache", arguments.no_cache,
      "Do not use or fill the cache of filled bodies, states before the first frame and compiled shaders "
      "($FASCICLE_CACHE_DIR, else ~/.cache/fascicle)");
  subcommand
      .add_option(
          "--rest", overrides.rest,
          "What the rest shape is: hung by gravity already (sculpted), or shaped without (weightless)")
      ->option_text("sculpted|weightless");
  subcommand
      .add_option("--interpolation", overrides.interpolation,
                  "What dense linear keys are: samples of a smooth motion (smooth), or corners between "
                  "straight lines (as-authored)")
      ->option_text("smooth|as-authored");
  subcommand
      .add_option(
          "--preroll", overrides.preroll,
          "Frames, or seconds as in 0.5s, in which the bind pose goes over into the first pose before "
          "frame 0")
      ->option_text("N|Ns");
  subcommand.add_option(
      "--settle", overrides.settle,
      "Seconds, at most, in which the flesh comes to rest in the first pose before frame 0");
  subcommand.add_option("--loop", overrides.loop, "How often the clip is played")->option_text("N");
  subcommand.add_flag("--seamless", overrides.seamless,
                      "Play the clip before frame 0 until it ends as it began, then write one cycle");
  subcommand.add_option("--hold", overrides.hold, "Seconds in which the clip's last pose is held");
  subcommand
      .add_option("--handles", overrides.handles,
                  "Frames more before the start and after the end, simulated and written; their numbers lie "
                  "around --first-frame and the last")
      ->option_text("N");
  subcommand
      .add_option("--cage", overrides.cage,
                  "Surfaces and characters: fill the skin itself or a cage around it (auto, off, wrap)")
      ->option_text("MODE");
  subcommand
      .add_option("--cage-detail", overrides.cage_detail,
                  "A cage closes gaps narrower than the body's diagonal divided by N (100)")
      ->option_text("N");
  subcommand
      .add_option("--rigid", overrides.rigid,
                  "Characters: skin that follows its joints alone, by the name of a joint, an object or a "
                  "material; may be repeated")
      ->option_text("NAME");
  subcommand
      .add_option("--resolution", overrides.resolution,
                  "How fine: a number of vertices (20000), or an edge length with its unit (20mm)")
      ->option_text("SIZE");
}

void refuse_unwritable(const std::string& option, const std::string& file, bool folders) {
  if (file.empty()) return;
  std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
  std::error_code ignored;
  while (folders && !std::filesystem::exists(folder, ignored) && folder.has_relative_path())
    folder = folder.parent_path();
  if (!std::filesystem::is_directory(folder, ignored) || ::access(folder.c_str(), W_OK) != 0)
    throw bake::BakeError(option + " " + file + ": " + folder.string() +
                          " is not a folder that can be written to; choose another");
}

scene::Scene load(const SceneArguments& arguments) {
  try {
    return scene::load_scene(arguments.name, arguments.overrides);
  } catch (const scene::SceneError& error) {
    if (!scene::has_overrides(arguments.overrides)) throw;
    // Whose fault is it? If the scene loads as it stands, the command line's.
    const std::string message = error.what();
    scene::load_scene(arguments.name);
    throw UsageError(message);
  }
}

Built build(scene::Scene& scene, Log& log, bool no_cache) {
  Built built;
  build::BuildOptions options;
  if (!no_cache) options.cache = build::default_cache_folder();
  built.model = build::build_model(scene, built.report, options);
  build::choose_steps(scene, built.model, built.report);
  if (built.report.body_from_cache) log.detail("the filled body came from " + options.cache.string());
  log.detail("model: " + count_text(built.report.vertices) + " vertices, " +
             count_text(built.report.tetrahedra) + " tetrahedra, built in " +
             duration_text(built.report.seconds));
  return built;
}

void log_warnings(const build::Report& report, Log& log) {
  for (const build::Warning& warning : report.warnings) log.warning(warning_text(warning));
}

model::SolverOptions solver_options(const scene::Scene& scene) {
  model::SolverOptions options;
  if (scene.solver.integrator == model::name_of(model::Integrator::implicit_step))
    options.integrator = model::Integrator::implicit_step;
  else if (scene.solver.integrator != model::name_of(model::Integrator::explicit_step))
    throw scene::SceneError(scene.source + ": solver.integrator: there is no \"" + scene.solver.integrator +
                            "\"; use \"explicit\" or \"implicit\"");
  options.iterations = scene.solver.iterations;
  for (const model::Rotation rotation : {model::Rotation::qcp, model::Rotation::mueller2016})
    if (scene.solver.rotation == model::name_of(rotation)) {
      options.rotation = rotation;
      return options;
    }
  throw scene::SceneError(scene.source + ": solver.rotation: there is no \"" + scene.solver.rotation +
                          "\"; use \"qcp\" or \"mueller2016\"");
}

}  // namespace fascicle::cli
