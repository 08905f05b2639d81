// fascicle export: converts a finished bake to further formats.
#include "host/bake/export.h"

#include <iostream>
#include <memory>
#include <optional>

#include "host/bake/bake.h"
#include "host/bake/outputs.h"
#include "host/bake/read_frame_cache.h"
#include "host/cli/command.h"
#include "host/cli/interrupt.h"
#include "host/cli/progress.h"
#include "host/cli/text.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;

struct ExportArguments {
  std::string bake, folder;
  std::vector<std::string> formats;
  formats::GlbOptions glb;
  std::optional<std::uint64_t> first_number;
  bool usd_skel = false, overwrite = false;
};

// Size of a file, or of all files in a folder.
std::uint64_t bytes_at(const fs::path& path) {
  if (!fs::is_directory(path)) return fs::file_size(path);
  std::uint64_t bytes = 0;
  for (const auto& item : fs::directory_iterator(path))
    if (item.is_regular_file()) bytes += item.file_size();
  return bytes;
}

ExitCode export_bake(const ExportArguments& arguments, Log& log) {
  std::unique_ptr<Progress> progress;
  bake::ExportOptions options;
  options.bake = arguments.bake;
  options.folder = arguments.folder;
  options.formats = arguments.formats;
  options.glb = arguments.glb;
  options.first_number = arguments.first_number;
  options.usd_skel = arguments.usd_skel;
  options.overwrite = arguments.overwrite;
  options.interrupted = &interrupts();
  options.on_frame = [&](std::uint64_t frame, std::uint64_t frames) {
    if (!progress) progress = std::make_unique<Progress>(log, "exporting", frames);
    progress->update(frame);
  };
  const bake::ExportResult result = bake::export_bake(options);
  log.clear_bar();
  if (result.interrupted) {
    log.warning("interrupted; the files that were there before are unchanged");
    return ExitCode::interrupted;
  }
  log_report(result.report, log);
  std::cout << "exported frames 0 to " << count_text(result.frames) << " of " << arguments.bake << " in "
            << duration_text(result.seconds) << "\n";
  std::vector<std::pair<std::string, std::string>> rows;
  for (const fs::path& file : result.files) rows.emplace_back(file.string(), bytes_text(bytes_at(file)));
  std::cout << columns_text(rows);
  return ExitCode::done;
}

}  // namespace

void add_export(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand("export", "Write a finished bake in other formats");
  const auto arguments = std::make_shared<ExportArguments>();
  subcommand->add_option("DIR", arguments->bake, "Folder of a finished bake")->required()->option_text(" ");
  std::string formats;
  for (const std::string& name : bake::export_format_names()) formats += (formats.empty() ? "" : ",") + name;
  subcommand->add_option("--to", arguments->formats, "Formats to write: any of " + formats)
      ->required()
      ->delimiter(',')
      ->allow_extra_args(false)
      ->take_all()
      ->check(CLI::IsMember(bake::format_names()).description(""))
      ->option_text("LIST");
  subcommand->add_option("-o,--output", arguments->folder, "Folder to write; default: the bake's own")
      ->option_text("DIR");
  subcommand->add_flag("--overwrite", arguments->overwrite, "Replace existing files");
  subcommand
      ->add_option(
          "--first-frame", arguments->first_number,
          "Number of the first frame after the handles in the exported files; default: the bake's own")
      ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1000000}).description(""))
      ->option_text("N");
  add_glb_options(*subcommand, arguments->glb);
  add_usd_options(*subcommand, arguments->usd_skel);
  add_log_options(*subcommand, command.log);
  subcommand->callback([arguments, &command] {
    command.watches_interrupts = true;
    command.run = [arguments](Log& log) { return export_bake(*arguments, log); };
  });
}

}  // namespace fascicle::cli
