// fascicle report: a self-contained page about a bake.
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/file.h"
#include "host/base/json_text.h"
#include "host/cli/artist.h"
#include "host/cli/command.h"
#include "host/cli/drawn_frames.h"
#include "host/cli/interrupt.h"
#include "host/cli/progress.h"
#include "host/cli/report_page.h"
#include "host/cli/text.h"
#include "host/cli/worst_frames.h"
#include "host/pipeline/bake_scene.h"
#include "host/render/colour.h"
#include "host/render/png.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Maximum numbers of evenly spaced pictures, of the worst frames, and of warnings; heights in pixels.
constexpr std::uint64_t still_count = 6, worst_count = 3;
constexpr std::size_t most_of_warnings = 6;
constexpr unsigned picture_height = 340, rest_height = 420;

struct ReportArguments {
  std::string bake, output;
  bool overwrite = false;
  unsigned threads = 0;
};

EncodedPicture encoded(const render::Image& image) {
  return {render::encode_png(image), image.width, image.height};
}

// "#ede4cf"
std::string colour_text(const Eigen::Vector3f& colour) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", render::byte_of_linear(colour[0]),
                render::byte_of_linear(colour[1]), render::byte_of_linear(colour[2]));
  return text.data();
}

// The raw manifest. manifest_of has already read it, and reports errors in it.
Json whole_manifest(const fs::path& folder) {
  const std::string text = base::read_input(folder / bake::manifest_name, base::most_json_bytes);
  return Json::parse(base::shallow_json(text), nullptr, false);
}

// The frame that a warning names, as in "frame 40: ...".
std::optional<std::uint64_t> frame_in(const std::string& warning, std::uint64_t count) {
  constexpr std::string_view word = "frame ";
  const auto is_of_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  for (std::size_t at = warning.find(word); at != std::string::npos; at = warning.find(word, at + 1)) {
    if (at > 0 && is_of_word(warning[at - 1])) continue;
    const char *digits = warning.data() + at + word.size(), *last = warning.data() + warning.size();
    std::uint64_t frame = 0;
    const auto [end, error] = std::from_chars(digits, last, frame);
    if (error != std::errc() || (end != last && is_of_word(*end))) continue;
    return frame < count ? std::optional(frame) : std::nullopt;
  }
  return std::nullopt;
}

void choose_frames(Report& report) {
  const std::uint64_t count = report.frame_count;
  const std::uint64_t stills = std::min(count, still_count);
  for (std::uint64_t k = 0; k < stills; ++k)
    report.stills.push_back(stills == 1 ? count - 1 : k * (count - 1) / (stills - 1));
  std::size_t with_picture = 0;
  for (const std::string& text : report.manifest.warnings) {
    std::optional<std::uint64_t> frame = frame_in(text, count);
    if (frame && ++with_picture > most_of_warnings) frame.reset();
    report.warnings.push_back({text, frame});
  }
  if (report.scores.has_look)
    report.worst = worst_frames(report.scores, count, worst_count, frames_apart(count, worst_count));
}

// All frames shown anywhere, without duplicates.
std::vector<std::uint64_t> shown_frames(const Report& report) {
  std::vector<std::uint64_t> frames = report.stills;
  frames.insert(frames.end(), report.worst.begin(), report.worst.end());
  for (const ReportWarning& warning : report.warnings)
    if (warning.frame) frames.push_back(*warning.frame);
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  return frames;
}

// Why skinning alone cannot be drawn, for example because the character's file is gone; empty if it can.
std::string why_no_skinning(DrawnFrames& frames) {
  try {
    (void)frames.skinned_surface(0);
  } catch (const base::SceneError& error) {
    return error.what();
  } catch (const base::BakeError& error) {
    return error.what();
  }
  return "";
}

// False if interrupted.
bool draw(const ReportArguments& arguments, Report& report, Log& log) {
  RenderArguments drawing;
  drawing.input.name = arguments.bake;
  drawing.threads = arguments.threads;
  DrawnFrames frames(drawing, log);
  report.frame_count = frames.count();
  if (const std::uint64_t counted = report.manifest.position_hashes.size(); report.frame_count < counted)
    throw bake::BakeError((fs::path(arguments.bake) / bake::cache_name).string() + ": " +
                          count_text(report.frame_count) + " frames are intact, but the manifest counts " +
                          count_text(counted) +
                          "; fascicle verify lists the damaged ones; bake again with --overwrite");
  report.has_skeleton = frames.model().has_skeleton();
  choose_frames(report);
  if (const std::string why = why_no_skinning(frames); why.empty())
    drawing.compare = true;
  else
    report.lacks = "Skinning alone is not shown: " + why;
  const std::vector<std::uint64_t> shown = shown_frames(report);
  const Artist artist(drawing, frames, shown, picture_height, log);
  if (!artist.why_no_solids().empty())
    report.lacks += (report.lacks.empty() ? "The" : ". The") +
                    (" scene's solids are not shown: " + artist.why_no_solids());
  Progress progress(log, "drawing", shown.size() + 1);
  for (const std::uint64_t k : shown) {
    if (interrupts()) return false;
    FramePictures pictures{
        .frame = k, .time = frames.time(k), .flesh = encoded(artist.picture(k)), .skinned = {}};
    if (drawing.compare) pictures.skinned = encoded(artist.skinned_picture(k));
    report.pictures.push_back(std::move(pictures));
    progress.update(report.pictures.size());
  }
  if (frames.model().surface_count() > 0 && !interrupts()) {
    const std::optional<render::Looks> looks = frames.looks(log);
    RestPictures rest;
    try {
      rest = draw_rest(frames.model(), looks ? &*looks : nullptr, rest_height, arguments.threads);
    } catch (const std::invalid_argument& error) {
      throw bake::BakeError(arguments.bake + ": its model cannot be drawn: " + error.what() +
                            "; bake again with --overwrite");
    }
    report.rest =
        RestReport{rest.skin, rest.body, encoded(rest.before), encoded(rest.after), encoded(rest.cut), {}};
    for (const render::Legend::Entry& entry : rest.layers.entries)
      report.rest->layers.emplace_back(entry.name, colour_text(entry.colour));
  }
  progress.update(shown.size() + 1);
  return !interrupts();
}

ExitCode write_report(const ReportArguments& arguments, Log& log) {
  if (fs::is_directory(arguments.output))
    throw UsageError("-o " + arguments.output + ": is a folder; give the page a name, as in report.html");
  if (!arguments.overwrite && fs::exists(arguments.output))
    throw UsageError(arguments.output + ": already exists; --overwrite replaces it, or choose another -o");
  refuse_unwritable("-o", arguments.output);
  Report report;
  report.folder = arguments.bake;
  report.manifest = bake::manifest_of(arguments.bake);
  report.metrics = read_metrics_table(arguments.bake);
  if (!report.metrics.columns.empty()) report.scores = read_frame_scores(arguments.bake);
  const Json manifest = whole_manifest(arguments.bake);
  report.fps = report.manifest.fps.value_or(0.0);
  if (report.manifest.frames_kept) {
    if (!draw(arguments, report, log)) {
      log.clear_bar();
      log.warning("interrupted; nothing was written");
      return ExitCode::interrupted;
    }
  } else {
    report.lacks = "There are no pictures: the frames of this bake were not kept (--keep-frames false).";
    report.frame_count = report.metrics.rows();
    choose_frames(report);
    report.stills.clear();
    report.worst.clear();
  }
  log.clear_bar();
  const std::string page = report_page(report, manifest);
  base::write_whole_beside_others(fs::absolute(arguments.output), page);
  std::cout << "wrote " << arguments.output << ": " << bytes_text(page.size()) << ", "
            << counted_text(report.pictures.size(), "frame", "frames") << "\n";
  return ExitCode::done;
}

}  // namespace

void add_report(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand(
      "report", "Write a report on a bake as one page: pictures, curves, warnings, parameters, provenance");
  const auto arguments = std::make_shared<ReportArguments>();
  subcommand->add_option("DIR", arguments->bake, "Folder of a bake")->required()->option_text(" ");
  subcommand
      ->add_option("-o,--output", arguments->output,
                   "The page to write, such as report.html; it needs no other file")
      ->required()
      ->option_text("FILE");
  subcommand->add_flag("--overwrite", arguments->overwrite, "Replace an existing page");
  subcommand
      ->add_option("--threads", arguments->threads,
                   "Threads; 0: one per core; the page does not depend on it")
      ->check(CLI::Range(0U, 1024U).description(""))
      ->option_text("N");
  add_log_options(*subcommand, command.log);
  subcommand->callback([arguments, &command] {
    command.watches_interrupts = true;
    command.run = [arguments](Log& log) { return write_report(*arguments, log); };
  });
}

}  // namespace fascicle::cli
