#include "host/cli/artist.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>

#include "host/base/errors.h"
#include "host/cli/text.h"
#include "host/render/solid_shapes.h"

namespace fascicle::cli {
namespace {

double number_of(const std::string& text, const std::string& option) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw UsageError(option + ": \"" + text + "\" is not a number");
  return value;
}

render::View view_of(const RenderArguments& arguments) {
  static const std::map<std::string, render::View> views{
      {"front", {0.0, 6.0}}, {"side", {90.0, 6.0}}, {"back", {180.0, 6.0}}, {"three-quarter", {35.0, 10.0}}};
  render::View view = views.at(arguments.view);
  view.azimuth += arguments.turn;
  if (arguments.tilt) view.elevation = *arguments.tilt;
  return view;
}

// "x=0.1" or "x=50%". Removes the half that faces the camera.
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
  const std::vector<char> is_beside = model::surroundings_of(model).vertices;
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (std::size_t i = 0; i < model.vertex_count; ++i) {
    if (is_beside[i] != 0) continue;
    low = std::min(low, model.rest[3 * i + axis]);
    high = std::max(high, model.rest[3 * i + axis]);
  }
  clip.place = share ? model.rest_origin[axis] +
                           model.unit * (double{low} + (double{high} - double{low}) * value / 100.0)
                     : value;
  clip.keeps_below = render::camera_axes(view)(2, clip.axis) >= 0.0;
  return clip;
}

// Frames that determine the camera and the scales: all, or evenly spaced ones of a long bake.
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

// The point that a following camera looks at: the middle of the body, at floor height. `is_beside`: per
// point, whether it is of the surroundings.
Eigen::Vector3d center_of(std::span<const float> positions, const std::vector<char>& is_beside) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (std::size_t i = 0; i < is_beside.size(); ++i) {
    if (is_beside[i] != 0) continue;
    sum += point(positions, i);
    ++count;
  }
  sum.y() = 0.0;
  return sum / count;
}

// Which of drawn_points are of the surroundings.
const std::vector<char>& beside_of(const model::Surroundings& surroundings,
                                   const render::BodyDrawing& drawing) {
  return drawing.draws_tetrahedra() ? surroundings.vertices : surroundings.surface;
}

// The flesh as it is drawn.
std::vector<float> drawn_points(DrawnFrames& frames, const render::BodyDrawing& drawing, std::uint64_t k) {
  return drawing.draws_tetrahedra() ? frames.positions(k) : frames.surface(k);
}

// The body in a frame; with --compare by skinning, because both sides share one camera, which must not depend
// on the flesh.
std::vector<float> framed_points(DrawnFrames& frames, const render::BodyDrawing& drawing,
                                 const RenderArguments& arguments, std::uint64_t k) {
  return arguments.compare ? frames.skinned_surface(k) : drawn_points(frames, drawing, k);
}

const std::vector<char>& beside_of_framed(const model::Surroundings& surroundings,
                                          const render::BodyDrawing& drawing,
                                          const RenderArguments& arguments) {
  return arguments.compare ? surroundings.surface : beside_of(surroundings, drawing);
}

// The points that must be in view.
class Survey {
 public:
  Survey(DrawnFrames& frames, const render::BodyDrawing& drawing, const model::Surroundings& surroundings,
         const RenderArguments& arguments, std::span<const std::uint64_t> shown)
      : frames_(frames), drawing_(drawing), surroundings_(surroundings), arguments_(arguments) {
    std::vector<std::uint64_t> numbers(shown.begin(), shown.end());
    if (numbers.empty()) numbers = survey_frames(frames.count());
    // The boxes are needed to clamp flesh and to choose the camera.
    const bool needs_boxes = arguments.compare || (!arguments.follow && numbers.size() > 1);
    for (const std::uint64_t k : numbers) {
      Shown one{.frame = k, .middle = Eigen::Vector3d::Zero(), .box = {}};
      if (needs_boxes || arguments.follow.value_or(false)) {
        const std::vector<float> points = framed_points(frames, drawing, arguments, k);
        const std::vector<char>& is_beside = beside_of_framed(surroundings, drawing, arguments);
        one.middle = center_of(points, is_beside);
        each(points, is_beside, Eigen::Vector3d::Zero(), [&](const Eigen::Vector3d& p, bool beside) {
          if (!beside) one.box.extend(p);
        });
      }
      shown_.push_back(one);
    }
  }

  // The camera follows the body or not. Call it before `visit`.
  void follow(bool follows) {
    follows_ = follows;
    if (!arguments_.compare) return;
    for (const Shown& one : shown_) {
      const Eigen::Vector3d from = way(one);
      box_.extend(Eigen::Vector3d(one.box.min() - from)).extend(Eigen::Vector3d(one.box.max() - from));
    }
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(0.25 * box_.diagonal().norm());
    box_ = Eigen::AlignedBox3d(Eigen::Vector3d(box_.min() - margin), Eigen::Vector3d(box_.max() + margin));
  }

  // How many times as large a camera that follows the body would show it, in the frame where it gains most.
  double gain_of_following(const render::View& view) const {
    if (shown_.size() < 2) return 1.0;
    const std::vector<double> still = sizes(view, false), followed = sizes(view, true);
    double gain = 1.0;
    for (std::size_t k = 0; k < shown_.size(); ++k) gain = std::max(gain, followed[k] / still[k]);
    return gain;
  }

  // Visits the flesh, with whether a point is of the surroundings. With --compare, also visits the skinned
  // surface, and clamps flesh to a quarter of the body beyond that, so that one stray vertex does not shrink
  // everything else to a dot.
  template <class Visit>
  void visit(Visit visit) const {
    for (const Shown& one : shown_) {
      const Eigen::Vector3d from = way(one);
      const std::vector<float> points = drawn_points(frames_, drawing_, one.frame);
      each(points, beside_of(surroundings_, drawing_), from, [&](const Eigen::Vector3d& p, bool is_beside) {
        visit(arguments_.compare ? Eigen::Vector3d(p.cwiseMax(box_.min()).cwiseMin(box_.max())) : p,
              is_beside);
      });
      if (!arguments_.compare) continue;
      const std::vector<float> skinned = frames_.skinned_surface(one.frame);
      each(skinned, surroundings_.surface, from, visit);
    }
  }

 private:
  struct Shown {
    std::uint64_t frame = 0;
    Eigen::Vector3d middle;   // as center_of
    Eigen::AlignedBox3d box;  // of framed_points
  };

  Eigen::Vector3d way(const Shown& one) const {
    return follows_ ? one.middle : Eigen::Vector3d(Eigen::Vector3d::Zero());
  }

  template <class Visit>
  static void each(std::span<const float> positions, const std::vector<char>& is_beside,
                   const Eigen::Vector3d& from, Visit visit) {
    for (std::size_t i = 0; i < is_beside.size(); ++i)
      visit(Eigen::Vector3d(point(positions, i) - from), is_beside[i] != 0);
  }

  // Visits the corners of the frame's box as the camera sees them.
  template <class Visit>
  static void each_corner(const Shown& one, bool follows, Visit visit) {
    for (int c = 0; c < 8; ++c) {
      const Eigen::Vector3d p = one.box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(c));
      visit(follows ? Eigen::Vector3d(p - one.middle) : p);
    }
  }

  // Of each frame's box: the longer side in a picture that fits all, as a share of the picture's height.
  std::vector<double> sizes(const render::View& view, bool follows) const;

  DrawnFrames& frames_;
  const render::BodyDrawing& drawing_;
  const model::Surroundings& surroundings_;
  const RenderArguments& arguments_;
  std::vector<Shown> shown_;
  bool follows_ = false;
  Eigen::AlignedBox3d box_;
};

struct Extent {
  double lowest = 0.0;  // y, m
  Eigen::AlignedBox3d world;
  double aspect = 1.0;  // width over height in the camera's axes
};

// `shows_surroundings`: they are drawn, and may be lower than the body.
Extent extent_of(const Survey& survey, const render::View& view, bool shows_surroundings) {
  const Eigen::Matrix3d axes = render::camera_axes(view);
  Eigen::AlignedBox3d box, world;
  double lowest = std::numeric_limits<double>::infinity();
  survey.visit([&](const Eigen::Vector3d& p, bool is_beside) {
    if (!is_beside || shows_surroundings) lowest = std::min(lowest, p.y());
    if (is_beside) return;
    box.extend(Eigen::Vector3d(axes * p));
    world.extend(p);
  });
  const Eigen::Vector3d sizes = box.sizes();
  return {lowest, world, sizes.y() > 0.0 ? sizes.x() / sizes.y() : 1.0};
}

// As wide as its content, with an aspect ratio from 0.6 to 1.78. Whole macroblocks, for video encoders.
Size natural_size(double aspect, unsigned height) {
  const double width = std::clamp(aspect, 0.6, 1.78) * height;
  return {static_cast<unsigned>(std::lround(width / 16.0)) * 16, height};
}

std::vector<double> Survey::sizes(const render::View& view, bool follows) const {
  constexpr unsigned height = 1000;
  const Eigen::Matrix3d axes = render::camera_axes(view);
  Eigen::AlignedBox3d all;
  for (const Shown& one : shown_)
    each_corner(one, follows, [&](const Eigen::Vector3d& p) { all.extend(Eigen::Vector3d(axes * p)); });
  Size size;
  if (arguments_.size.empty())
    size = natural_size(all.sizes().y() > 0.0 ? all.sizes().x() / all.sizes().y() : 1.0, height);
  else
    size = size_of(arguments_.size, "--size", 8192);
  render::CameraFit fit(view, size.width, size.height);
  for (const Shown& one : shown_)
    each_corner(one, follows, [&](const Eigen::Vector3d& p) { fit.include(p); });
  const render::Camera camera = fit.camera();
  std::vector<double> shares;
  for (const Shown& one : shown_) {
    Eigen::AlignedBox2d seen;
    each_corner(one, follows,
                [&](const Eigen::Vector3d& p) { seen.extend(Eigen::Vector2d(camera.project(p).head<2>())); });
    shares.push_back(seen.sizes().maxCoeff() / size.height);
  }
  return shares;
}

// A level plane is drawn as the ground.
bool is_floor(const scene::Solid& solid) {
  return solid.is_plane && solid.axes(1, 1) > 0.9999;
}
double height_of(const scene::Solid& floor) {
  return floor.center.y() + floor.radius;
}

// Rounds up to 1, 2 or 5 times a power of ten.
double round_up(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0})
    if (step * power >= value) return step * power;
  return 10.0 * power;
}

// Metres mapped to the last colour: the maximum of `values_of` over the frames.
template <class ValuesOf>
double natural_scale(DrawnFrames& frames, const ValuesOf& values_of) {
  float most = 0.0f;
  for (const std::uint64_t k : survey_frames(frames.count()))
    for (const float value : values_of(k)) most = std::max(most, value);
  return most > 0.0f ? round_up(double{most}) : 1e-3;
}

// Why the scene's solids cannot be drawn; empty if they can. A bake's folder does not hold the inputs of its
// scene.
std::string why_solids_are_unknown(DrawnFrames& frames) {
  try {
    (void)frames.solids(0);
  } catch (const base::SceneError& error) {
    return error.what();
  } catch (const pipeline::DifferentBakes&) {
    throw;  // the scene can be read, and is not this bake's
  } catch (const base::BakeError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

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

Artist::Artist(const RenderArguments& arguments, DrawnFrames& frames, std::span<const std::uint64_t> shown,
               unsigned height, Log& log)
    : arguments_(arguments), frames_(frames) {
  const render::View view = view_of(arguments);
  render::DrawingOptions options;
  options.mode = arguments.mode;
  options.tetrahedra = arguments.tetrahedra;
  if (!arguments.clip.empty()) options.clip = clip_of(arguments.clip, frames.model(), view);
  if (arguments.mode == render::Mode::contact) {
    if (!frames.model().has_contact())
      throw UsageError(
          "--mode contact: this bake has no self-contact; set contact.self = true, or contact.unless_torn = "
          "false if the bake left it out");
    overlap_.emplace(frames.model());
  }
  if (arguments.lag_scale) {
    options.lag_scale = *arguments.lag_scale * 1e-3;
  } else if (arguments.mode == render::Mode::lag) {
    options.lag_scale = natural_scale(frames, [&](std::uint64_t k) { return frames.lag(k); });
  } else if (overlap_) {
    // With --compare, the scale is that of skinning, which overlaps more deeply.
    options.lag_scale = natural_scale(frames, [&](std::uint64_t k) {
      return contact_depths(arguments.compare ? frames.skinned_vertices(k) : frames.positions(k));
    });
  }
  if (arguments.mode == render::Mode::shaded && !arguments.plain) looks_ = frames.looks(log);
  if (looks_) options.looks = &*looks_;
  try {
    drawing_.emplace(frames.model(), options);
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  legend_ = drawing_->legend();
  surroundings_ = model::surroundings_of(frames.model());
  Survey survey(frames, *drawing_, surroundings_, arguments, shown);
  // Pictures of a body at less than a fifth of what they could show are of the ground, not of the flesh: a
  // fifth of a sheet's cell is 77 pixels.
  constexpr double least_gain = 5.0;
  follows_by_itself_ = !arguments.follow && survey.gain_of_following(view) > least_gain;
  follows_ = arguments.follow.value_or(follows_by_itself_);
  survey.follow(follows_);
  const Extent extent = extent_of(survey, view, !drawing_->draws_tetrahedra());
  const Size size =
      arguments.size.empty() ? natural_size(extent.aspect, height) : size_of(arguments.size, "--size", 8192);
  render::CameraFit fit(view, size.width, size.height);
  survey.visit([&](const Eigen::Vector3d& p, bool is_beside) {
    if (!is_beside) fit.include(p);
  });
  camera_ = fit.camera(arguments.zoom);
  backdrop_.ground = extent.lowest;
  why_no_solids_ = why_solids_are_unknown(frames);
  if (!why_no_solids_.empty()) {
    log.warning("the scene's solids are not shown: " + why_no_solids_);
  } else {
    for (const scene::Solid& solid : frames.solids(0))
      if (is_floor(solid)) backdrop_.ground = height_of(solid);
  }
  middle_ = extent.world.center();
  reach_ = 1.5 * extent.world.diagonal().norm();
}

// How far the camera has moved with the body.
Eigen::Vector3d Artist::way_at(std::uint64_t k) const {
  if (!follows_) return Eigen::Vector3d::Zero();
  return center_of(framed_points(frames_, *drawing_, arguments_, k),
                   beside_of_framed(surroundings_, *drawing_, arguments_));
}

std::vector<render::Shape> Artist::solids_at(std::uint64_t k, const Eigen::Vector3d& way,
                                             const Eigen::Vector3d& eye) const {
  if (!why_no_solids_.empty()) return {};
  std::vector<render::Shape> shapes;
  for (const scene::Solid& solid : frames_.solids(k)) {
    if (is_floor(solid) && backdrop_.ground == height_of(solid)) continue;
    // From inside it would hide the body.
    if (scene::distance_to(solid, eye) < 0.0) continue;
    shapes.push_back(render::solid_shape(
        {solid.axes, solid.center, solid.half_size, solid.radius, solid.is_plane}, middle_ + way, reach_));
    // Shadow maps as wide as a solid that is a floor or a wall would have no texels left for the body.
    if (solid.half_size.maxCoeff() + solid.radius > reach_) shapes.back().widens_shadows = false;
  }
  return shapes;
}

render::Image Artist::draw(std::uint64_t k, std::span<const float> positions, std::span<const float> lag,
                           std::span<const float> surface) const {
  const Eigen::Vector3d way = way_at(k);
  render::Camera camera = camera_;
  camera.eye += way;
  std::vector<render::Shape> shapes = drawing_->shapes(positions, lag, camera.eye.cast<float>(), surface);
  for (render::Shape& solid : solids_at(k, way, camera.eye)) shapes.push_back(std::move(solid));
  return render::render(shapes, camera, backdrop_, arguments_.threads);
}

// Marks both sides of each overlap: the point, and the corners of the tetrahedron it is in.
std::vector<float> Artist::contact_depths(std::span<const float> positions) const {
  const model::Model& model = frames_.model();
  std::vector<float> working(positions.begin(), positions.end());
  for (float& x : working) x = static_cast<float>(double{x} / model.unit);
  std::vector<float> depths(model.vertex_count, -1.0f);
  for (const model::PointOverlap& one : overlap_->points(working)) {
    const auto mark = [&](std::uint32_t i) {
      depths[i] = std::max(depths[i], static_cast<float>(one.depth));
    };
    mark(model.contact[one.point].vertex);
    for (std::size_t k = 0; k < 4; ++k) mark(model.contact_tetrahedron[4 * std::size_t{one.tetrahedron} + k]);
  }
  return depths;
}

render::Image Artist::picture(std::uint64_t k) const {
  const bool draws_tetrahedra = drawing_->draws_tetrahedra();
  const bool needs_lag = arguments_.mode == render::Mode::lag;
  const std::vector<float> positions =
      draws_tetrahedra || overlap_ ? frames_.positions(k) : std::vector<float>();
  const std::vector<float> surface = draws_tetrahedra ? std::vector<float>() : frames_.surface(k);
  return draw(k, positions,
              overlap_    ? contact_depths(positions)
              : needs_lag ? frames_.lag(k)
                          : std::vector<float>(),
              surface);
}

render::Image Artist::skinned_picture(std::uint64_t k) const {
  if (overlap_) {
    const std::vector<float> vertices = frames_.skinned_vertices(k), depths = contact_depths(vertices);
    return drawing_->draws_tetrahedra() ? draw(k, vertices, depths, {})
                                        : draw(k, vertices, depths, frames_.skinned_surface(k));
  }
  const std::vector<float> no_lag(frames_.model().vertex_count, 0.0f);
  if (drawing_->draws_tetrahedra()) return draw(k, frames_.skinned_vertices(k), no_lag, {});
  return draw(k, {}, no_lag, frames_.skinned_surface(k));
}

}  // namespace fascicle::cli
