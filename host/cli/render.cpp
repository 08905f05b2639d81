// fascicle render: pictures of a bake, or of a scene's rest pose.
#include "host/render/render.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>
#include <map>
#include <memory>

#include <Eigen/Geometry>

#include "host/bake/bake.h"
#include "host/bake/file.h"
#include "host/bake/surface.h"
#include "host/cli/command.h"
#include "host/cli/interrupt.h"
#include "host/cli/open_bake.h"
#include "host/cli/progress.h"
#include "host/cli/text.h"
#include "host/render/annotate.h"
#include "host/render/body_shapes.h"
#include "host/render/colour.h"
#include "host/render/png.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;

struct RenderArguments {
  SceneArguments input;
  std::string output;
  std::optional<std::uint64_t> frame;
  render::Mode mode = render::Mode::shaded;
  bool tetrahedra = false;
  std::string clip, size, sheet, view = "three-quarter";
  double turn = 0.0, zoom = 1.0;
  std::optional<double> tilt, lag_scale;
  bool follow = false, overwrite = false;
  unsigned threads = 0;
};

// The frames there are to draw: those of a bake, or one, the rest pose.
class Frames {
 public:
  Frames(const RenderArguments& arguments, Log& log) {
    if (fs::is_directory(arguments.input.name)) {
      bake_.emplace(arguments.input.name);
    } else {
      scene::Scene scene = load_named(arguments.input);
      Built built = build(scene, log);
      log_warnings(built.report, log);
      built_ = std::move(built.model);
    }
  }

  const model::Model& model() const { return bake_ ? bake_->model() : built_; }
  bool is_bake() const { return bake_.has_value(); }
  std::uint64_t count() const { return bake_ ? bake_->frame_count() : 1; }
  // Metres, 3 a vertex.
  std::vector<float> positions(std::uint64_t k) const {
    if (!bake_) return bake::world_positions(built_.rest, built_.unit, built_.rest_origin);
    const model::Frame frame = bake_->frame(k);
    return bake::world_positions(frame.positions, bake_->model().unit, frame.origin);
  }
  std::vector<float> lag(std::uint64_t k) {
    if (!bake_) return std::vector<float>(built_.vertex_count, 0.0f);
    return bake_->lag(bake_->frame(k));
  }

 private:
  static scene::Scene load_named(const SceneArguments& input) {
    const auto& builtin = scene::builtin_scenes();
    const bool is_builtin =
        std::any_of(builtin.begin(), builtin.end(), [&](const auto& s) { return s.name == input.name; });
    if (!is_builtin && !fs::exists(input.name))
      throw scene::SceneError(
          input.name +
          ": there is no such bake, scene, mesh or character; give a bake's folder, a file, "
          "or a built-in scene" +
          nearest_scene_hint(input.name));
    return load(input);
  }

  std::optional<OpenBake> bake_;
  model::Model built_;
};

double number_of(const std::string& text, const std::string& option) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw UsageError(option + ": \"" + text + "\" is not a number");
  return value;
}

struct Size {
  unsigned width = 0, height = 0;
};

// "1280x720"
Size size_of(const std::string& text, const std::string& option, unsigned most) {
  const std::size_t cross = text.find('x');
  const auto whole = [&](const std::string& part) {
    unsigned value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc() || end != part.data() + part.size() || value < 1 || value > most)
      throw UsageError(option + ": \"" + text + "\" is not WIDTHxHEIGHT with numbers from 1 to " +
                       std::to_string(most));
    return value;
  };
  if (cross == std::string::npos) whole("");
  return {whole(text.substr(0, cross)), whole(text.substr(cross + 1))};
}

render::View view_of(const RenderArguments& arguments) {
  static const std::map<std::string, render::View> views{
      {"front", {0.0, 6.0}}, {"side", {90.0, 6.0}}, {"back", {180.0, 6.0}}, {"three-quarter", {35.0, 10.0}}};
  render::View view = views.at(arguments.view);
  view.azimuth += arguments.turn;
  if (arguments.tilt) view.elevation = *arguments.tilt;
  return view;
}

// "x=0.1" or "x=50%". The half that faces the camera goes.
render::Clip clip_of(const std::string& text, const model::Model& model, const render::View& view) {
  const std::string axes = "xyz";
  if (text.size() < 3 || axes.find(text[0]) == std::string::npos || text[1] != '=')
    throw UsageError("--clip: \"" + text +
                     "\" is not an axis and a place, as in x=0.1 (metres) or y=50% (of the body)");
  render::Clip clip;
  clip.axis = static_cast<int>(axes.find(text[0]));
  const bool share = text.back() == '%';
  const double value = number_of(text.substr(2, text.size() - 2 - (share ? 1 : 0)), "--clip");
  const auto axis = static_cast<std::size_t>(clip.axis);
  float low = model.rest[axis], high = low;
  for (std::size_t k = axis; k < model.rest.size(); k += 3) {
    low = std::min(low, model.rest[k]);
    high = std::max(high, model.rest[k]);
  }
  clip.place = share ? model.rest_origin[axis] +
                           model.unit * (double{low} + (double{high} - double{low}) * value / 100.0)
                     : value;
  clip.keeps_below = render::camera_axes(view)(2, clip.axis) >= 0.0;
  return clip;
}

struct Extent {
  double lowest = 0.0;  // y
  double aspect = 1.0;  // width over height in the camera's axes
};

// Frames looked at for the camera and the scales: all, or of long bakes evenly spaced ones.
std::vector<std::uint64_t> survey_frames(std::uint64_t count) {
  constexpr std::uint64_t most = 400;
  const std::uint64_t step = (count + most - 1) / most;
  std::vector<std::uint64_t> frames;
  for (std::uint64_t k = 0; k < count; k += step) frames.push_back(k);
  if (frames.back() + 1 != count) frames.push_back(count - 1);
  return frames;
}

Eigen::Vector3d point(std::span<const float> positions, std::size_t i) {
  return {double{positions[3 * i]}, double{positions[3 * i + 1]}, double{positions[3 * i + 2]}};
}

// Where a following camera looks at: the middle of the body, on the floor.
Eigen::Vector3d center_of(std::span<const float> positions) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const std::size_t count = positions.size() / 3;
  for (std::size_t i = 0; i < count; ++i) sum += point(positions, i);
  sum.y() = 0.0;
  return sum / static_cast<double>(count);
}

// All of the motion, once, before the first picture.
template <class Visit>
void survey(const Frames& frames, bool follow, Visit visit) {
  for (const std::uint64_t k : survey_frames(frames.count())) {
    const std::vector<float> positions = frames.positions(k);
    const Eigen::Vector3d center = follow ? center_of(positions) : Eigen::Vector3d(Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i < positions.size() / 3; ++i)
      visit(Eigen::Vector3d(point(positions, i) - center));
  }
}

Extent extent_of(const Frames& frames, bool follow, const render::View& view) {
  const Eigen::Matrix3d axes = render::camera_axes(view);
  Eigen::AlignedBox3d box;
  double lowest = std::numeric_limits<double>::infinity();
  survey(frames, follow, [&](const Eigen::Vector3d& p) {
    box.extend(Eigen::Vector3d(axes * p));
    lowest = std::min(lowest, p.y());
  });
  const Eigen::Vector3d sizes = box.sizes();
  return {lowest, sizes.y() > 0.0 ? sizes.x() / sizes.y() : 1.0};
}

// As wide as what it shows, between a door and a film; whole macroblocks, for the sake of video.
Size natural_size(double aspect, unsigned height) {
  const double width = std::clamp(aspect, 0.6, 1.78) * height;
  return {static_cast<unsigned>(std::lround(width / 16.0)) * 16, height};
}

// 1, 2 or 5 times a power of ten, the next from `value` up.
double round_up(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0})
    if (step * power >= value) return step * power;
  return 10.0 * power;
}

double natural_lag_scale(Frames& frames) {
  float most = 0.0f;
  for (const std::uint64_t k : survey_frames(frames.count()))
    for (const float lag : frames.lag(k)) most = std::max(most, lag);
  return most > 0.0f ? round_up(double{most}) : 1e-3;
}

void refuse_existing(const fs::path& path, bool overwrite) {
  if (fs::is_directory(path)) throw UsageError(path.string() + ": is a folder; choose another -o");
  if (!overwrite && fs::exists(path))
    throw UsageError(path.string() + ": is there already; --overwrite replaces it, or choose another -o");
}

std::string frame_name(std::uint64_t frame) {
  const std::string digits = std::to_string(frame);
  return std::string(digits.size() < 4 ? 4 - digits.size() : 0, '0') + digits + ".png";
}

// What is to be drawn and where it goes.
struct Plan {
  std::vector<std::uint64_t> frames;
  enum class Form { still, sheet, folder } form = Form::folder;
  Size sheet;  // columns and rows

  bool is_file() const { return form != Form::folder; }
};

Plan plan_of(const RenderArguments& arguments) {
  Plan plan;
  const bool is_file = fs::path(arguments.output).extension() == ".png";
  const std::string extension = fs::path(arguments.output).extension().string();
  for (const char* other : {".jpg", ".jpeg", ".gif", ".bmp", ".tif", ".tiff", ".exr", ".webp", ".mp4"})
    if (extension == other)
      throw UsageError("-o " + arguments.output +
                       ": pictures are PNG; give a name that ends in .png, or a folder");
  if (!is_file && arguments.frame)
    throw UsageError("--frame is for one picture; give -o a name that ends in .png");
  if (!is_file && !arguments.sheet.empty())
    throw UsageError("--sheet is one picture; give -o a name that ends in .png");
  if (is_file) plan.form = arguments.sheet.empty() ? Plan::Form::still : Plan::Form::sheet;
  if (plan.form == Plan::Form::sheet) plan.sheet = size_of(arguments.sheet, "--sheet", 100);
  if (is_file) refuse_existing(arguments.output, arguments.overwrite);
  return plan;
}

void choose_frames(const RenderArguments& arguments, std::uint64_t count, Plan& plan) {
  switch (plan.form) {
    case Plan::Form::still:
      plan.frames.push_back(arguments.frame.value_or(count - 1));
      if (plan.frames[0] >= count)
        throw UsageError("--frame " + std::to_string(plan.frames[0]) + ": there are frames 0 to " +
                         std::to_string(count - 1));
      break;
    case Plan::Form::sheet: {
      // From the first to the last, evenly.
      const std::uint64_t cells = std::min<std::uint64_t>(count, plan.sheet.width * plan.sheet.height);
      for (std::uint64_t k = 0; k < cells; ++k)
        plan.frames.push_back(cells == 1 ? count - 1 : k * (count - 1) / (cells - 1));
      break;
    }
    case Plan::Form::folder:
      for (std::uint64_t k = 0; k < count; ++k) plan.frames.push_back(k);
      fs::create_directories(arguments.output);
      for (const std::uint64_t k : plan.frames)
        refuse_existing(fs::path(arguments.output) / frame_name(k), arguments.overwrite);
      break;
  }
}

// One camera and one drawing for all frames.
class Artist {
 public:
  Artist(const RenderArguments& arguments, Frames& frames, const Plan& plan)
      : arguments_(arguments), frames_(frames) {
    const render::View view = view_of(arguments);
    render::DrawingOptions options;
    options.mode = arguments.mode;
    options.tetrahedra = arguments.tetrahedra;
    if (!arguments.clip.empty()) options.clip = clip_of(arguments.clip, frames.model(), view);
    if (arguments.mode == render::Mode::lag)
      options.lag_scale = arguments.lag_scale ? *arguments.lag_scale * 1e-3 : natural_lag_scale(frames);
    try {
      drawing_.emplace(frames.model(), options);
    } catch (const std::invalid_argument& error) {
      throw UsageError(error.what());
    }
    legend_ = drawing_->legend();
    const Extent extent = extent_of(frames, arguments.follow, view);
    const unsigned height = plan.form == Plan::Form::sheet ? 384 : 960;
    const Size size = arguments.size.empty() ? natural_size(extent.aspect, height)
                                             : size_of(arguments.size, "--size", 8192);
    render::CameraFit fit(view, size.width, size.height);
    survey(frames, arguments.follow, [&](const Eigen::Vector3d& p) { fit.include(p); });
    camera_ = fit.camera(arguments.zoom);
    backdrop_.ground = extent.lowest;
  }

  const render::BodyDrawing& drawing() const { return *drawing_; }
  const render::Legend& legend() const { return legend_; }

  render::Image picture(std::uint64_t k) const {
    const std::vector<float> positions = frames_.positions(k);
    render::Camera camera = camera_;
    if (arguments_.follow) camera.eye += center_of(positions);
    const std::vector<float> lag =
        arguments_.mode == render::Mode::lag ? frames_.lag(k) : std::vector<float>();
    const std::vector<render::Shape> shapes = drawing_->shapes(positions, lag, camera.eye.cast<float>());
    return render::render(shapes, camera, backdrop_, arguments_.threads);
  }

 private:
  const RenderArguments& arguments_;
  Frames& frames_;
  std::optional<render::BodyDrawing> drawing_;
  render::Legend legend_;
  render::Camera camera_;
  render::Backdrop backdrop_;
};

void write_png(const fs::path& path, const render::Image& image) {
  bake::write_whole(fs::absolute(path), render::encode_png(image));
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

ExitCode render_frames(const RenderArguments& arguments, Log& log) {
  Plan plan = plan_of(arguments);
  if (plan.is_file()) refuse_unwritable("-o", arguments.output);
  Frames frames(arguments, log);
  choose_frames(arguments, frames.count(), plan);
  const Artist artist(arguments, frames, plan);
  if (arguments.mode == render::Mode::fibres && !artist.drawing().shows_fibres())
    log.warning("no fibre runs through what is drawn; try --clip, or a scene whose layers have fibres");

  const fs::path output(arguments.output);
  const std::atomic<bool>& interrupted = catch_interrupts();
  std::vector<render::Image> cells;
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
      render::Image image = artist.picture(k);
      if (plan.form == Plan::Form::sheet) {
        const unsigned text = std::max(9u, image.height / 40);
        render::draw_text(image, text, text, text, std::to_string(k), {0.05f, 0.05f, 0.06f});
        cells.push_back(std::move(image));
      } else {
        render::draw_legend(image, artist.legend());
        write_png(plan.is_file() ? output : output / frame_name(k), image);
      }
      if (++done < plan.frames.size() || plan.frames.size() > 1) progress.update(done);
    }
  }
  if (plan.form == Plan::Form::sheet) {
    render::Image sheet = render::sheet_of(cells, plan.sheet.width);
    render::draw_legend(sheet, artist.legend());
    write_png(output, sheet);
  }
  std::cout << "wrote " << output.string();
  if (plan.frames.size() > 1 || !plan.is_file())
    std::cout << ": " << count_text(plan.frames.size()) << " frames";
  std::cout << "\n";
  print_legend(artist.legend());
  return ExitCode::done;
}

}  // namespace

void add_render(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand(
      "render", "Draw a bake, or a scene's rest pose, as PNG; on the CPU, without display or GPU");
  const auto arguments = std::make_shared<RenderArguments>();
  // Not add_scene_options: --clip is a plane here.
  subcommand
      ->add_option("BAKE", arguments->input.name,
                   "A bake's folder (running ones too), or a scene, mesh, character or built-in name")
      ->required()
      ->option_text(" ");
  subcommand
      ->add_option("-o,--output", arguments->output,
                   "NAME.png for one picture, else a folder for one a frame")
      ->required()
      ->option_text("PATH");
  subcommand->add_option("--frame", arguments->frame, "The frame of one picture; without it the last")
      ->option_text("N");
  const std::map<std::string, render::Mode> modes{{"shaded", render::Mode::shaded},
                                                  {"layers", render::Mode::layers},
                                                  {"fibres", render::Mode::fibres},
                                                  {"lag", render::Mode::lag}};
  subcommand
      ->add_option(
          "--mode", arguments->mode,
          "shaded; layers: a colour each; fibres: lines, red along x, green y, blue z; lag: distance to "
          "the skinned pose")
      ->transform(CLI::CheckedTransformer(modes).description(""))
      ->option_text("MODE");
  subcommand->add_flag("--tets", arguments->tetrahedra, "Draw the tetrahedra instead of the render mesh");
  subcommand
      ->add_option("--clip", arguments->clip,
                   "Take away the tetrahedra on the camera's side of a plane of the rest pose, as in x=0.1 "
                   "(metres) or x=50%; implies --tets")
      ->option_text("PLANE");
  subcommand->add_option("--lag-scale", arguments->lag_scale, "Lag that takes the last colour, mm")
      ->check(CLI::PositiveNumber.description(""))
      ->option_text("MM");
  subcommand->add_option("--view", arguments->view, "three-quarter, front, side or back")
      ->check(CLI::IsMember({"three-quarter", "front", "side", "back"}).description(""))
      ->option_text("VIEW");
  subcommand->add_option("--turn", arguments->turn, "Turn the camera around the body, degrees")
      ->option_text("DEGREES");
  subcommand->add_option("--tilt", arguments->tilt, "Height of the camera, degrees; -80 to 80")
      ->check(CLI::Range(-80.0, 80.0).description(""))
      ->option_text("DEGREES");
  subcommand->add_option("--zoom", arguments->zoom, "2 shows the middle half of the picture")
      ->check(CLI::Range(0.1, 100.0).description(""))
      ->option_text("FACTOR");
  subcommand->add_flag("--follow", arguments->follow, "The camera goes along with the body");
  subcommand->add_option("--size", arguments->size, "Pixels; without it as the motion needs")
      ->option_text("WxH");
  subcommand
      ->add_option("--sheet", arguments->sheet,
                   "One picture of evenly spaced frames with their numbers; --size is that of each")
      ->option_text("COLUMNSxROWS");
  subcommand->add_option("--threads", arguments->threads, "0 takes one for each core; no pixel depends on it")
      ->check(CLI::Range(0U, 1024U).description(""))
      ->option_text("N");
  subcommand->add_flag("--overwrite", arguments->overwrite, "Replace pictures that are there");
  add_log_options(*subcommand, command.log);
  subcommand->callback([arguments, &command] {
    command.run = [arguments](Log& log) { return render_frames(*arguments, log); };
  });
}

}  // namespace fascicle::cli
