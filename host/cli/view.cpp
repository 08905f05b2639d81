// fascicle view: a finished bake as a single page for a browser.
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "host/base/file.h"
#include "host/cli/command.h"
#include "host/cli/interrupt.h"
#include "host/cli/progress.h"
#include "host/cli/text.h"
#include "host/page/bake_page.h"
#include "host/pipeline/bake_scene.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;

struct ViewArguments {
  std::string bake, output;
  std::optional<double> error;  // mm
  bool overwrite = false, json = false;
};

void refuse_output(const ViewArguments& arguments) {
  const fs::path path(arguments.output);
  const std::string extension = base::lower_extension(path);
  if (extension != ".html" && extension != ".htm")
    throw UsageError("-o " + arguments.output + ": a page is HTML; give a name that ends in .html");
  if (fs::is_directory(path)) throw UsageError(arguments.output + ": is a folder; choose another -o");
  if (!arguments.overwrite && fs::exists(path))
    throw UsageError(arguments.output + ": already exists; --overwrite replaces it, or choose another -o");
  refuse_unwritable("-o", arguments.output);
}

// mm, rounded up so that the stated bound holds.
std::string error_text(double error) {
  return number_text(1e3 * error * 1.005, 3) + " mm";
}

ExitCode view(const ViewArguments& arguments, Log& log) {
  refuse_output(arguments);
  page::PageOptions options;
  options.bake = arguments.bake;
  if (arguments.error) options.error = 1e-3 * *arguments.error;
  options.interrupted = &interrupts();
  std::unique_ptr<Progress> progress;
  options.on_step = [&](std::uint64_t done, std::uint64_t steps) {
    if (!progress) progress = std::make_unique<Progress>(log, "page", steps);
    progress->update(done);
  };
  const page::PageResult result = page::page_of_bake(options);
  log.clear_bar();
  if (result.interrupted || interrupts()) {
    log.warning("interrupted; no page was written");
    return ExitCode::interrupted;
  }
  for (const std::string& warning : result.warnings) log.warning(warning);
  base::write_whole_beside_others(fs::absolute(arguments.output), result.html);
  if (arguments.json) {
    std::cout << nlohmann::ordered_json{{"file", arguments.output},      {"bytes", result.html.size()},
                                        {"frames", result.frames},       {"vertices", result.vertices},
                                        {"triangles", result.triangles}, {"error", result.error}}
                     .dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
              << "\n";
    return ExitCode::done;
  }
  std::cout << "wrote " << arguments.output << ": " << counted_text(result.frames, "frame", "frames")
            << " of " << counted_text(result.vertices, "vertex", "vertices") << " in "
            << bytes_text(result.html.size()) << "; no vertex is further than " << error_text(result.error)
            << " from the bake\n";
  return ExitCode::done;
}

}  // namespace

void add_view(CLI::App& app, Command& command) {
  auto* subcommand =
      app.add_subcommand("view", "Write a finished bake as one HTML page that any browser opens from disk");
  const auto arguments = std::make_shared<ViewArguments>();
  subcommand->add_option("DIR", arguments->bake, "Folder of a finished bake")->required()->option_text(" ");
  subcommand->add_option("-o,--output", arguments->output, "The page to write, NAME.html")
      ->required()
      ->option_text("FILE");
  subcommand
      ->add_option("--error", arguments->error,
                   "Quantise so that no vertex moves by more than MM millimetres; default: a 20,000th of the "
                   "body's longest side")
      ->check(positive_number(1e6))
      ->option_text("MM");
  subcommand->add_flag("--overwrite", arguments->overwrite, "Replace an existing page");
  subcommand->add_flag("--json", arguments->json, "Print one JSON object");
  add_log_options(*subcommand, command.log);
  subcommand->callback([arguments, &command] {
    command.watches_interrupts = true;
    command.run = [arguments](Log& log) { return view(*arguments, log); };
  });
}

}  // namespace fascicle::cli
