// The command line as a whole: parsing, and the handling of each kind of error.
#include <cerrno>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "gpu/device.h"
#include "host/bake/bake.h"
#include "host/base/nearest_name.h"
#include "host/base/version.h"
#include "host/cli/command.h"
#include "host/cli/interrupt.h"
#include "host/cli/shown_output.h"
#include "host/scene/scene_table.h"

namespace fascicle::cli {
namespace {

// Parsing errors occur before the options are filled in, so look up the log format by hand.
LogOptions log_options_of_bad_usage(int argc, const char* const* argv) {
  LogOptions options;
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    std::string format;
    if (word.starts_with("--log-format=")) format = word.substr(word.find('=') + 1);
    if (word == "--log-format" && k + 1 < argc) format = argv[k + 1];
    if (format == "json") options.format = LogFormat::json;
    if (format == "openjd") options.format = LogFormat::openjd;
  }
  return options;
}

// For an unknown subcommand, CLI11 only reports that a subcommand is required.
std::string usage_text(const CLI::ParseError& error, const CLI::App& app, int argc, const char* const* argv) {
  const std::vector<CLI::App*> named = app.get_subcommands();
  if (!named.empty())
    return std::string(error.what()) + "; see fascicle " + named.front()->get_name() + " --help";
  if (argc < 2 || argv[1][0] == '-') return std::string(error.what()) + "; see fascicle --help";
  std::vector<std::string> names;
  for (const CLI::App* subcommand : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(subcommand->get_name());
  const std::string hint = base::nearest_name_hint(argv[1], names);
  return "unknown command \"" + std::string(argv[1]) + "\"" + hint + (hint.empty() ? "; see" : " See") +
         " fascicle --help";
}

ExitCode report(Log& log, const std::string& message, ExitCode code) {
  log.error(message);
  return code;
}

// Whether the disk is at fault, and not the name of the folder.
bool is_of_the_disk(const std::error_code& code) {
  return code == std::errc::no_space_on_device || code == std::errc::io_error ||
         code == std::errc::file_too_large || code.value() == EDQUOT;
}

ExitCode run_command(const Command& command, Log& log) {
  try {
    const ExitCode code = command.run(log);
    // Fail if the results could not be written.
    std::cout.flush();
    if (!std::cout) return report(log, "standard output could not be written", ExitCode::unforeseen);
    return code;
  } catch (const build::Cancelled&) {
    log.clear_bar();
    log.warning("interrupted while building the model; run the same command to start again");
    return ExitCode::interrupted;
  } catch (const UsageError& error) {
    return report(log, error.what(), ExitCode::bad_usage);
  } catch (const bake::FolderInUse& error) {
    return report(log, error.what(), ExitCode::bad_usage);
  } catch (const bake::ContradictingOptions& error) {
    return report(log, error.what(), ExitCode::bad_usage);
  } catch (const scene::SceneError& error) {
    return report(log, error.what(), ExitCode::bad_input);
  } catch (const bake::BakeError& error) {
    return report(log, error.what(), ExitCode::bad_input);
  } catch (const NoSuchDevice& error) {
    return report(log, error.what(), ExitCode::no_such_device);
  } catch (const DeviceFailed& error) {
    return report(log, error.what(), ExitCode::device_failed);
  } catch (const gpu::DeviceError& error) {
    return report(log, error.what(), ExitCode::device_failed);
  } catch (const bake::NotFinite& error) {
    return report(log, error.what(), ExitCode::not_finite);
  } catch (const std::filesystem::filesystem_error& error) {
    if (is_of_the_disk(error.code()))
      return report(log, error.path1().string() + ": " + error.code().message(), ExitCode::unforeseen);
    return report(log, error.path1().string() + ": " + error.code().message() + "; choose another folder",
                  ExitCode::bad_input);
  } catch (const std::bad_alloc&) {
    return report(log, "out of memory; try a coarser mesh, or inspect the scene to see its size",
                  ExitCode::unforeseen);
  } catch (const std::exception& error) {
    return report(log, error.what(), ExitCode::unforeseen);
  }
}

}  // namespace

int run(int argc, const char* const* argv) {
  const ShownOutput shown(std::cout);
  Command command;
  CLI::App app{
      "Bakes how muscle and fat move on rigged, animated characters, with the same bits on CPU and GPU."};
  app.name("fascicle");
  app.set_version_flag("--version", std::string("fascicle ") + base::fascicle_version,
                       "Print the version and exit");
  app.require_subcommand(1);
  app.footer(
      "Exit status: 0 done, 2 bad usage, 3 bad input, 4 no such device, 5 positions are no longer finite "
      "numbers,\n"
      "6 validation found a difference, 7 a device failed and 75 interrupted (continue with --resume), 1 "
      "anything "
      "else.");
  add_bake(app, command);
  add_batch(app, command);
  add_studio(app, command);
  add_render(app, command);
  add_view(app, command);
  add_report(app, command);
  add_export(app, command);
  add_paint(app, command);
  add_verify(app, command);
  add_validate(app, command);
  add_inspect(app, command);
  add_bench(app, command);
  add_devices(app, command);
  add_scenes(app, command);
  add_schema(app, command);
  add_manual(app, command);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help and --version, to stdout
    Log log(log_options_of_bad_usage(argc, argv));
    log.error(usage_text(error, app, argc, argv));
    return static_cast<int>(ExitCode::bad_usage);
  }
  Log log(command.log);
  if (!command.watches_interrupts) {
    let_interrupts_end_the_process();
  } else if (interrupts()) {
    log.warning("interrupted before anything was started");
    return static_cast<int>(ExitCode::interrupted);
  } else {
    end_at_once_until_asked();
  }
  return static_cast<int>(run_command(command, log));
}

}  // namespace fascicle::cli
