// What subcommands share: adding one to the command line, and getting from a scene's name to a model.
#pragma once

#include <functional>
#include <string>

#include <CLI/CLI.hpp>

#include "host/build/build.h"
#include "host/cli/exit_codes.h"
#include "host/cli/log.h"
#include "host/formats/sink.h"
#include "host/pipeline/build_scene.h"
#include "host/scene/scene.h"

namespace fascicle::cli {

// The requested command, filled in by its subcommand.
struct Command {
  LogOptions log;
  std::function<ExitCode(Log&)> run;
  bool watches_interrupts = false;  // stops with ExitCode::interrupted; others die of the signal
};

// Each adds one subcommand; see bake.cpp, validate.cpp, ...
void add_bake(CLI::App& app, Command& command);
void add_export(CLI::App& app, Command& command);
void add_paint(CLI::App& app, Command& command);
void add_validate(CLI::App& app, Command& command);
void add_verify(CLI::App& app, Command& command);
void add_view(CLI::App& app, Command& command);
void add_inspect(CLI::App& app, Command& command);
void add_batch(CLI::App& app, Command& command);
void add_bench(CLI::App& app, Command& command);
void add_devices(CLI::App& app, Command& command);
void add_scenes(CLI::App& app, Command& command);
void add_schema(CLI::App& app, Command& command);
void add_render(CLI::App& app, Command& command);
void add_studio(CLI::App& app, Command& command);
void add_report(CLI::App& app, Command& command);
void add_manual(CLI::App& app, Command& command);

// Refuse an option's text that is not a number, not finite, or not from `least` to `most`; or not above 0.
// CLI11's own ranges let NaN pass.
CLI::Validator number_from(double least, double most);
CLI::Validator positive_number(double most);

// -q, -v, --log-format
void add_log_options(CLI::App& subcommand, LogOptions& log);

// --glb-stride, --glb-error, --glb-tolerance, --glb-compress
void add_glb_options(CLI::App& subcommand, formats::GlbOptions& glb);
// --usd-skel
void add_usd_options(CLI::App& subcommand, bool& skel);
// Logs the report on finished files.
void log_report(const formats::SinkReport& report, Log& log);

// A scene's name and the command line's overrides.
struct SceneArguments {
  std::string name;
  scene::SceneOverrides overrides;
  bool no_cache = false;
};

// SCENE, --set, --fps, --start, --end, --clip, --no-cache
void add_scene_options(CLI::App& subcommand, SceneArguments& arguments, const std::string& what,
                       bool required);

// Throws scene::SceneError; UsageError if the scene is valid but an override is not.
scene::Scene load(const SceneArguments& arguments);

Built build(const scene::Scene& scene, Log& log, bool no_cache = false);
build::BuildOptions build_options(bool no_cache);

// Logs the build's warnings, for commands that do not store them in their result.
void log_warnings(const build::Report& report, Log& log);

// "; did you mean NAME?", or empty if no built-in scene has a similar name.
std::string nearest_scene_hint(const std::string& name);

// Runs the whole command line; returns the exit status.
int run(int argc, const char* const* argv);

}  // namespace fascicle::cli
