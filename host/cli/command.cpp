#include "host/cli/command.h"

#include <cmath>
#include <map>
#include <vector>

#include "host/bake/bake.h"
#include "host/base/nearest_name.h"
#include "host/build/cache.h"
#include "host/cli/interrupt.h"
#include "host/cli/text.h"
#include "host/scene/scene_table.h"

namespace fascicle::cli {
std::string nearest_scene_hint(const std::string& name) {
  std::vector<std::string> names;
  for (const scene::BuiltinScene& scene : scene::builtin_scenes()) names.push_back(scene.name);
  return base::nearest_name_hint(name, names);
}

void add_log_options(CLI::App& subcommand, LogOptions& log) {
  auto* quiet = subcommand.add_flag_callback(
      "-q,--quiet", [&log] { log.verbosity = Verbosity::quiet; }, "Print only errors on stderr");
  auto* verbose = subcommand.add_flag_callback(
      "-v,--verbose", [&log] { log.verbosity = Verbosity::verbose; }, "Print more on stderr");
  quiet->excludes(verbose);
  const std::map<std::string, LogFormat> formats{
      {"text", LogFormat::text}, {"json", LogFormat::json}, {"openjd", LogFormat::openjd}};
  subcommand
      .add_option("--log-format", log.format,
                  "Format of stderr: text; json, one object per line; openjd, with the lines that an Open "
                  "Job Description farm reads")
      ->transform(CLI::CheckedTransformer(formats).description(""))
      ->option_text("text|json|openjd");
}

namespace {

template <class IsWanted>
CLI::Validator finite_number(const IsWanted& is_wanted, const std::string& wanted) {
  return CLI::Validator(
      [is_wanted, wanted](const std::string& text) {
        double value = 0.0;
        const bool is_right =
            CLI::detail::lexical_cast(text, value) && std::isfinite(value) && is_wanted(value);
        return is_right ? std::string() : "\"" + text + "\" is not a number " + wanted;
      },
      "");
}

}  // namespace

CLI::Validator number_from(double least, double most) {
  return finite_number([=](double value) { return value >= least && value <= most; },
                       "from " + number_text(least) + " to " + number_text(most));
}

CLI::Validator positive_number(double most) {
  return finite_number([=](double value) { return value > 0.0 && value <= most; },
                       "above 0 and up to " + number_text(most));
}

void add_glb_options(CLI::App& subcommand, formats::GlbOptions& glb) {
  auto* stride =
      subcommand.add_option("--glb-stride", glb.stride, "glb: a morph target every N frames; default: 1");
  stride->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1000000}).description(""))->option_text("N");
  subcommand
      .add_option("--glb-error", glb.error,
                  "glb: use as few morph targets as keep every displayed frame within M metres of the bake; "
                  "0.002 is a good start")
      ->check(number_from(0.0, 1e6))
      ->excludes(stride)
      ->option_text("M");
  subcommand
      .add_option("--glb-tolerance", glb.tolerance,
                  "glb: leave vertices within M metres of skinning to skinning; default: a millionth of the "
                  "body's diagonal")
      ->check(number_from(0.0, 1e6))
      ->option_text("M");
  subcommand
      .add_option("--glb-compress", glb.compress,
                  "glb: for viewers on the web, quantise so that no vertex moves by more than M metres, and "
                  "compress (EXT_meshopt_compression, which Blender does not read); 0.0005 is a good start")
      ->check(positive_number(1e6))
      ->option_text("M");
}

void add_usd_options(CLI::App& subcommand, bool& skel) {
  subcommand.add_flag(
      "--usd-skel", skel,
      "usda: add the skinned character as UsdSkel, with the purpose guide, beside the baked points");
}

void log_report(const formats::SinkReport& report, Log& log) {
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
  subcommand.add_option("--fps", overrides.fps, "Frames per second");
  subcommand.add_option("--start", overrides.start, "Time of frame 0, s");
  subcommand.add_option("--end", overrides.end, "Time of the last frame, s");
  subcommand.add_option("--clip", overrides.clip,
                        "The character's clip, by name, by the last part of its name, or by number");
  subcommand
      .add_option("--softness", overrides.softness,
                  "Softness of all flesh: 2 halves its stiffness, 0.5 doubles it")
      ->option_text("X");
  subcommand
      .add_option("--exaggerate", overrides.exaggerate,
                  "How far flesh trails and jiggles: 2 is twice as far; at 0 only gravity and forces move it")
      ->option_text("X");
  subcommand
      .add_option("--only", overrides.only,
                  "Simulate only the flesh of this joint and of those below it; repeatable")
      ->allow_extra_args(false)
      ->take_all()
      ->option_text("JOINT");
  subcommand.add_flag("--no-cache", arguments.no_cache,
                      "Do not read or write the cache of meshed bodies, models, states before the first "
                      "frame and compiled shaders ($FASCICLE_CACHE_DIR, else ~/.cache/fascicle)");
  subcommand
      .add_option("--rest", overrides.rest,
                  "Whether gravity already shaped the rest shape (sculpted) or not (weightless)")
      ->option_text("sculpted|weightless");
  subcommand
      .add_option("--interpolation", overrides.interpolation,
                  "How to read dense linear keys: as samples of a smooth motion (smooth), or as straight "
                  "lines between keys (as-authored)")
      ->option_text("smooth|as-authored");
  subcommand
      .add_option(
          "--preroll", overrides.preroll,
          "Frames, or seconds as in 0.5s, to blend from the bind pose to the first pose before frame 0")
      ->option_text("N|Ns");
  subcommand.add_option("--settle", overrides.settle,
                        "Seconds, at most, to let the flesh settle in the first pose before frame 0");
  subcommand.add_option("--loop", overrides.loop, "How many times to play the clip")->option_text("N");
  subcommand.add_flag("--seamless", overrides.seamless,
                      "Repeat the clip before frame 0 until a cycle ends as it began, then write one cycle");
  subcommand.add_option("--hold", overrides.hold, "Seconds to hold the clip's last pose");
  subcommand
      .add_option("--handles", overrides.handles,
                  "Extra frames to simulate and write before the start and after the end; they are numbered "
                  "below --first-frame and beyond the last frame")
      ->option_text("N");
  subcommand
      .add_option("--cage", overrides.cage,
                  "Surfaces and characters: fill the skin itself (off), a cage around it (wrap), or a cage "
                  "where the skin needs one (auto)")
      ->option_text("MODE");
  subcommand
      .add_option("--cage-detail", overrides.cage_detail,
                  "A cage closes gaps up to twice as wide as the body's diagonal divided by N (100)")
      ->option_text("N");
  subcommand
      .add_option("--rigid", overrides.rigid,
                  "Characters: skin that only follows its joints, by the name of a joint, object or "
                  "material; repeatable")
      ->allow_extra_args(false)
      ->take_all()
      ->option_text("NAME");
  subcommand
      .add_option("--quality", overrides.quality,
                  "Implicit integrator: accuracy of the time step (draft, normal, final); sets substeps and "
                  "iterations")
      ->option_text("NAME");
  subcommand
      .add_option("--resolution", overrides.resolution,
                  "Resolution of the tetrahedra: a number of vertices (20000), or an edge length with its "
                  "unit (20mm)")
      ->option_text("SIZE");
}

scene::Scene load(const SceneArguments& arguments) {
  try {
    return scene::load_scene(arguments.name, arguments.overrides);
  } catch (const scene::SceneError& error) {
    if (!scene::has_overrides(arguments.overrides)) throw;
    // If the scene loads without overrides, the command line is at fault.
    const std::string message = error.what();
    scene::load_scene(arguments.name);
    throw UsageError(message);
  }
}

Built build(const scene::Scene& scene, Log& log, bool no_cache) {
  return build_scene(scene, build_options(no_cache), say_on(log));
}

build::BuildOptions build_options(bool no_cache) {
  build::BuildOptions options;
  if (!no_cache) options.cache = build::default_cache_folder();
  options.is_cancelled = [stop = &interrupts()] { return stop->load(); };
  return options;
}

void log_warnings(const build::Report& report, Log& log) {
  say_warnings(report, say_on(log));
}

}  // namespace fascicle::cli
