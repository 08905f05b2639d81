// fascicle render: pictures of a bake, or of a scene's rest pose.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/bake/bake.h"
#include "host/bake/folder.h"
#include "host/base/file.h"
#include "host/base/part_file.h"
#include "host/cli/artist.h"
#include "host/cli/command.h"
#include "host/cli/drawn_frames.h"
#include "host/cli/interrupt.h"
#include "host/cli/progress.h"
#include "host/cli/render_arguments.h"
#include "host/cli/text.h"
#include "host/cli/worst_frames.h"
#include "host/pipeline/bake_scene.h"
#include "host/render/annotate.h"
#include "host/render/body_shapes.h"
#include "host/render/colour.h"
#include "host/render/png.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;

void refuse_existing(const fs::path& path, bool overwrite) {
  if (fs::is_directory(path)) throw UsageError(path.string() + ": is a folder; choose another -o");
  if (!overwrite && fs::exists(path))
    throw UsageError(path.string() + ": already exists; --overwrite replaces it, or choose another -o");
}

std::string frame_name(std::uint64_t frame) {
  const std::string digits = std::to_string(frame);
  return std::string(digits.size() < 4 ? 4 - digits.size() : 0, '0') + digits + ".png";
}

// The frames to draw, and the form of the output.
struct Plan {
  std::vector<std::uint64_t> frames;
  enum class Form { still, sheet, folder } form = Form::folder;
  Size sheet;  // columns and rows

  bool is_file() const { return form != Form::folder; }
};

constexpr std::uint64_t default_worst = 6;

// Number of worst frames requested; nullopt if other frames are.
std::optional<std::uint64_t> worst_of(const RenderArguments& arguments) {
  if (arguments.worst) return arguments.worst;
  const bool says_which = arguments.frame || !arguments.sheet.empty();
  return arguments.compare && !says_which ? std::optional(default_worst) : std::nullopt;
}

// Names of pictures and films in other formats.
bool is_other_medium(const std::string& extension) {
  for (const char* other :
       {".apng", ".avi", ".avif", ".bmp", ".dds", ".dpx", ".exr",  ".gif",  ".hdr",  ".heic", ".jpe", ".jpeg",
        ".jpg",  ".jxl", ".m4v",  ".mkv", ".mov", ".mp4", ".mpeg", ".mpg",  ".ogv",  ".pdf",  ".pgm", ".pnm",
        ".ppm",  ".psd", ".qoi",  ".svg", ".tga", ".tif", ".tiff", ".webm", ".webp", ".wmv"})
    if (extension == other) return true;
  return false;
}

Plan plan_of(const RenderArguments& arguments) {
  Plan plan;
  const std::string extension = base::lower_extension(arguments.output);
  const bool is_file = extension == ".png";
  // A name that ends in / has no extension.
  if (is_other_medium(extension) && !fs::is_directory(arguments.output))
    throw UsageError("-o " + arguments.output +
                     ": pictures are PNG; give a name that ends in .png, or a folder with / at its end");
  if (!is_file && arguments.frame)
    throw UsageError("--frame is for one picture; give -o a name that ends in .png");
  if (!is_file && (!arguments.sheet.empty() || arguments.worst))
    throw UsageError(std::string(arguments.worst ? "--worst" : "--sheet") +
                     " is one picture; give -o a name that ends in .png");
  if (arguments.worst && arguments.frame)
    throw UsageError("--worst chooses frames itself; leave out --frame");
  if (!arguments.sheet.empty() && arguments.frame)
    throw UsageError("--sheet chooses frames itself; leave out --frame");
  if (arguments.worst && !arguments.sheet.empty())
    throw UsageError("--worst chooses frames itself; leave out --sheet");
  const bool is_sheet = !arguments.sheet.empty() || worst_of(arguments);
  if (is_file) plan.form = is_sheet ? Plan::Form::sheet : Plan::Form::still;
  if (!arguments.sheet.empty()) plan.sheet = size_of(arguments.sheet, "--sheet", 100);
  if (is_file) refuse_existing(arguments.output, arguments.overwrite);
  return plan;
}

void choose_worst(const FrameScores& scores, std::uint64_t wanted, std::uint64_t count, Plan& plan,
                  Log& log) {
  if (!scores.has_look)
    log.info(
        "metrics.csv has no column look: ranking frames by inverted tetrahedra beyond skinning's, "
        "then by lag");
  plan.frames = worst_frames(scores, count, wanted, frames_apart(count, wanted));
  if (plan.frames.empty()) throw bake::BakeError("metrics.csv: has no frames; give --frame or --sheet");
}

void choose_frames(const RenderArguments& arguments, const std::optional<FrameScores>& scores,
                   std::uint64_t count, Plan& plan, Log& log) {
  switch (plan.form) {
    case Plan::Form::still:
      plan.frames.push_back(arguments.frame.value_or(count - 1));
      if (plan.frames[0] >= count)
        throw UsageError("--frame " + std::to_string(plan.frames[0]) + ": there are frames 0 to " +
                         std::to_string(count - 1) + "; they are counted from 0, whatever --first-frame is");
      break;
    case Plan::Form::sheet: {
      if (const auto wanted = worst_of(arguments)) {
        choose_worst(scores.value(), *wanted, count, plan, log);
        break;
      }
      // Evenly spaced from the first to the last.
      const std::uint64_t cells = std::min<std::uint64_t>(count, plan.sheet.width * plan.sheet.height);
      for (std::uint64_t k = 0; k < cells; ++k)
        plan.frames.push_back(cells == 1 ? count - 1 : k * (count - 1) / (cells - 1));
      break;
    }
    case Plan::Form::folder:
      for (std::uint64_t k = 0; k < count; ++k) plan.frames.push_back(k);
      bake::make_folder(arguments.output);
      for (const std::uint64_t k : plan.frames)
        refuse_existing(fs::path(arguments.output) / frame_name(k), arguments.overwrite);
      break;
  }
}

// For the worst frames without a given number of columns: about as wide as high. No column stays empty.
unsigned columns_of(const Plan& plan, const render::Image& cell) {
  const double cells = static_cast<double>(plan.frames.size());
  const auto columns = static_cast<unsigned>(std::lround(std::sqrt(1.4 * cells * cell.height / cell.width)));
  return std::clamp(plan.sheet.width > 0 ? plan.sheet.width : columns, 1u,
                    static_cast<unsigned>(plan.frames.size()));
}

void write_png(const fs::path& path, const render::Image& image) {
  base::write_whole_beside_others(fs::absolute(path), render::encode_png(image));
}

// How many pictures in the folder follow the last of this run without a gap. They may be of an earlier run
// with more frames, or the user's own.
std::uint64_t later_pictures(const fs::path& folder, std::uint64_t count) {
  std::uint64_t later = 0;
  while (fs::exists(folder / frame_name(count + later))) ++later;
  return later;
}

// "bone #ede4cf"
void print_legend(const render::Legend& legend) {
  const auto hex = [](const Eigen::Vector3f& colour) {
    std::array<char, 8> text{};
    std::snprintf(text.data(), text.size(), "#%02x%02x%02x", render::byte_of_linear(colour[0]),
                  render::byte_of_linear(colour[1]), render::byte_of_linear(colour[2]));
    return std::string(text.data());
  };
  std::vector<std::pair<std::string, std::string>> rows;
  for (const render::Legend::Entry& entry : legend.entries)
    if (!entry.name.empty()) rows.emplace_back(entry.name, hex(entry.colour));
  if (!rows.empty()) std::cout << "colours\n" << columns_text(rows);
}

// "frame 43  1.433 s"
std::string frame_words(std::uint64_t k, double time) {
  return "frame " + std::to_string(k) + "  " + cli::number_text(time) + " s";
}

// {frame: "  look 0.72 stretch  thigh.L"}
std::map<std::uint64_t, std::string> look_words(const std::optional<FrameScores>& scores) {
  std::map<std::uint64_t, std::string> words;
  if (!scores) return words;
  for (const FrameScore& row : scores->frames) {
    if (!row.look) continue;
    std::string& line = words[row.frame];
    line = "  look " + cli::number_text(*row.look, 3);
    if (!row.cause.empty()) line += " " + row.cause;
    if (!row.joint.empty()) line += "  " + row.joint;
  }
  return words;
}

// All pictures of a run.
class Gallery {
 public:
  Gallery(const RenderArguments& arguments, const DrawnFrames& frames, const Artist& artist,
          const std::optional<FrameScores>& scores, const Plan& plan)
      : arguments_(arguments), frames_(frames), artist_(artist), looks_(look_words(scores)), plan_(plan) {}

  void add(std::uint64_t k) {
    render::Image image = arguments_.compare ? pair(k) : artist_.picture(k);
    const fs::path output(arguments_.output);
    if (plan_.form != Plan::Form::sheet) {
      render::draw_legend(image, artist_.legend());
      write_png(plan_.is_file() ? output : output / frame_name(k), image);
      return;
    }
    if (!arguments_.compare) {
      const unsigned text = std::max(9u, image.height / 40);
      render::draw_text(image, text, text, text, std::to_string(k) + look_of(k), {0.05f, 0.05f, 0.06f});
    }
    cells_.push_back(std::move(image));
  }

  void finish() const {
    if (plan_.form != Plan::Form::sheet) return;
    render::Image sheet = render::sheet_of(cells_, columns_of(plan_, cells_.front()));
    render::draw_legend(sheet, artist_.legend());
    write_png(arguments_.output, sheet);
  }

 private:
  std::string look_of(std::uint64_t k) const {
    const auto found = looks_.find(k);
    return found == looks_.end() ? "" : found->second;
  }

  std::array<std::string, 2> captions_of(std::uint64_t k) const {
    return {"skinned  " + frame_words(k, frames_.time(k)), "flesh" + look_of(k)};
  }

  // One height for the whole run: letters that change their size from frame to frame flicker in a film.
  unsigned letters_above(const render::Image& image) const {
    unsigned letters = image.height;
    for (const std::uint64_t k : plan_.frames)
      letters = std::min(letters, render::caption_height(image.width, image.height, captions_of(k)));
    return letters;
  }

  render::Image pair(std::uint64_t k) {
    const std::array<render::Image, 2> images{artist_.skinned_picture(k), artist_.picture(k)};
    if (letters_ == 0) letters_ = letters_above(images[0]);
    return render::row_of(images, captions_of(k), letters_);
  }

  const RenderArguments& arguments_;
  const DrawnFrames& frames_;
  const Artist& artist_;
  const std::map<std::uint64_t, std::string> looks_;
  const Plan& plan_;
  std::vector<render::Image> cells_;
  unsigned letters_ = 0;  // pixels; of captions
};

// Scores from metrics.csv, if captions or the choice of frames need them.
std::optional<FrameScores> scores_of(const RenderArguments& arguments, const DrawnFrames& frames) {
  const bool needs = worst_of(arguments).has_value();
  if (!frames.is_bake()) {
    if (arguments.compare || needs)
      throw UsageError(std::string(arguments.compare ? "--compare" : "--worst") +
                       " needs a bake; give a bake's folder");
    return std::nullopt;
  }
  if (!needs && !(arguments.compare && has_metrics(arguments.input.name))) return std::nullopt;
  return read_frame_scores(arguments.input.name);
}

ExitCode render_frames(const RenderArguments& arguments, Log& log) {
  Plan plan = plan_of(arguments);
  if (plan.is_file()) refuse_unwritable("-o", arguments.output);
  DrawnFrames frames(arguments, log);
  const std::optional<FrameScores> scores = scores_of(arguments, frames);
  choose_frames(arguments, scores, frames.count(), plan, log);
  const bool holds_only_these = plan.form == Plan::Form::sheet && worst_of(arguments);
  const Artist artist(arguments, frames, holds_only_these ? plan.frames : std::vector<std::uint64_t>(),
                      plan.form == Plan::Form::sheet ? 384 : 960, log);
  if (artist.follows_by_itself())
    log.info(
        "the camera follows the body, which its path would make small; --no-follow shows the whole path");
  if (arguments.mode == render::Mode::fibres && !artist.drawing().shows_fibres())
    log.warning("no fibres to draw; try --clip, or a scene whose layers have fibres");

  const std::atomic<bool>& interrupted = interrupts();
  Gallery gallery(arguments, frames, artist, scores, plan);
  {
    Progress progress(log, "rendering", plan.frames.size());
    std::uint64_t done = 0;
    for (const std::uint64_t k : plan.frames) {
      if (interrupted) {
        log.clear_bar();
        log.warning("interrupted after " + std::to_string(done) + " of " +
                    std::to_string(plan.frames.size()) + " pictures");
        return ExitCode::interrupted;
      }
      gallery.add(k);
      if (++done < plan.frames.size() || plan.frames.size() > 1) progress.update(done);
    }
  }
  gallery.finish();
  if (plan.form == Plan::Form::folder && arguments.overwrite)
    if (const std::uint64_t later = later_pictures(arguments.output, plan.frames.size()); later > 0)
      log.warning(arguments.output + ": also holds " + frame_name(plan.frames.size()) + " to " +
                  frame_name(plan.frames.size() + later - 1) +
                  ", which this run did not write; remove them if they are of an earlier run");
  std::cout << "wrote " << fs::path(arguments.output).string();
  if (plan.frames.size() > 1 || !plan.is_file())
    std::cout << ": " << counted_text(plan.frames.size(), "frame", "frames");
  std::cout << "\n";
  if (holds_only_these) {
    std::string list;
    for (const std::uint64_t k : plan.frames) list += (list.empty() ? "" : ", ") + std::to_string(k);
    std::cout << "worst first: " << list << "\n";
  }
  print_legend(artist.legend());
  return ExitCode::done;
}

}  // namespace

void add_render(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand(
      "render", "Draw a bake, or a scene's rest pose, as PNG; needs no display and no GPU");
  const auto arguments = std::make_shared<RenderArguments>();
  // Not add_scene_options, because --clip is a plane here.
  subcommand
      ->add_option("BAKE", arguments->input.name,
                   "A bake's folder (running ones too), or a scene, mesh, character or built-in name")
      ->required()
      ->option_text(" ");
  subcommand
      ->add_option("-o,--output", arguments->output,
                   "NAME.png for one picture, otherwise a folder for one picture per frame")
      ->required()
      ->option_text("PATH");
  subcommand->add_option("--frame", arguments->frame, "Draw only this frame; default: the last")
      ->option_text("N");
  const std::map<std::string, render::Mode> modes{{"shaded", render::Mode::shaded},
                                                  {"layers", render::Mode::layers},
                                                  {"fibres", render::Mode::fibres},
                                                  {"lag", render::Mode::lag},
                                                  {"contact", render::Mode::contact}};
  subcommand
      ->add_option("--mode", arguments->mode,
                   "shaded; layers, each in its colour; fibres: lines, red along x, green y, blue z; lag: "
                   "distance to the skinned pose; contact: depth of overlapping flesh, seen through the body")
      ->transform(CLI::CheckedTransformer(modes).description(""))
      ->option_text("MODE");
  subcommand->add_flag("--tets", arguments->tetrahedra, "Draw the tetrahedra instead of the render mesh");
  subcommand
      ->add_option("--clip", arguments->clip,
                   "Remove the tetrahedra on the camera's side of a plane in the rest pose, as in x=0.1 "
                   "(metres) or x=50%; implies --tets")
      ->option_text("PLANE");
  subcommand
      ->add_option("--lag-scale", arguments->lag_scale,
                   "Lag, or depth with --mode contact, at the end of the colour scale, mm")
      ->check(number_from(1e-6, 1e9))
      ->option_text("MM");
  subcommand->add_option("--view", arguments->view, "three-quarter, front, side or back")
      ->check(CLI::IsMember({"three-quarter", "front", "side", "back"}).description(""))
      ->option_text("VIEW");
  subcommand->add_option("--turn", arguments->turn, "Angle of the camera around the body, degrees")
      ->check(number_from(-1e6, 1e6))
      ->option_text("DEGREES");
  subcommand->add_option("--tilt", arguments->tilt, "Elevation of the camera, degrees; -80 to 80")
      ->check(number_from(-80.0, 80.0))
      ->option_text("DEGREES");
  subcommand->add_option("--zoom", arguments->zoom, "2 shows the middle half of the picture")
      ->check(number_from(0.1, 100.0))
      ->option_text("FACTOR");
  // CLI11 would take an optional for a count of flags and set it to 0.
  subcommand->add_flag_function(
      "--follow,!--no-follow", [arguments](std::int64_t count) { arguments->follow = count > 0; },
      "The camera follows the body, or does not; default: it does if the whole path would show the body at "
      "less than a fifth of the size");
  subcommand->add_option("--size", arguments->size, "Size in pixels; default: fits the motion")
      ->option_text("WxH");
  subcommand
      ->add_option("--sheet", arguments->sheet,
                   "One picture of evenly spaced frames with their numbers; --size is the size of each frame")
      ->option_text("COLUMNSxROWS");
  subcommand->add_flag(
      "--compare", arguments->compare,
      "Skinning on the left, flesh on the right; without --frame or --sheet, the six worst frames");
  subcommand
      ->add_option("--worst", arguments->worst,
                   "One picture of the N worst frames by the look in metrics.csv, worst first")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{100}).description(""))
      ->option_text("N");
  subcommand->add_flag("--plain", arguments->plain,
                       "shaded: plain skin instead of the file's own colours and textures");
  subcommand
      ->add_option("--threads", arguments->threads,
                   "Threads; 0: one per core; the pixels do not depend on it")
      ->check(CLI::Range(0U, 1024U).description(""))
      ->option_text("N");
  subcommand->add_flag("--overwrite", arguments->overwrite, "Replace existing pictures");
  add_log_options(*subcommand, command.log);
  subcommand->callback([arguments, &command] {
    command.watches_interrupts = true;
    command.run = [arguments](Log& log) { return render_frames(*arguments, log); };
  });
}

}  // namespace fascicle::cli
