#include "host/page/bake_page.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "host/bake/bake.h"
#include "host/bake/finished_bake.h"
#include "host/base/errors.h"
#include "host/base/text.h"
#include "host/base/version.h"
#include "host/formats/skinned_surface.h"
#include "host/formats/surface.h"
#include "host/model/reach.h"
#include "host/model/surroundings.h"
#include "host/page/base64.h"
#include "host/page/bundle.h"
#include "host/page/curves.h"
#include "host/page/drawn_surface.h"
#include "host/page/motion.h"
#include "host/page/page_looks.h"
#include "host/page/range_encoder.h"
#include "host/render/colour.h"
#include "host/render/model_surface.h"

namespace fascicle::page {

namespace {

using nlohmann::ordered_json;

constexpr double default_share = 1.0 / 20000.0;  // of the body's extent
// In all frames together; a browser keeps each twice, in 24 bytes.
constexpr std::uint64_t most_points = 50'000'000;
constexpr double uv_step = 1.0 / 16384.0;

// Placeholders in the bundle for the title and the bake.
constexpr std::string_view title_place = "@TITLE@", bake_place = "@BAKE@";

// Per frame, the positions of the drawn points (m, 3 numbers per point).
using Places = std::vector<std::vector<float>>;

std::string html_text(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '&')
      escaped += "&amp;";
    else
      escaped += c;
  }
  return escaped;
}

// Escaped for use within <script>.
std::string script_json(const ordered_json& json) {
  std::string text;
  for (const char c : json.dump(-1, ' ', true, ordered_json::error_handler_t::replace)) {
    if (c == '<')
      text += "\\u003c";
    else
      text += c;
  }
  return text;
}

std::string hex_colour(const render::Vector3f& colour) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", render::byte_of_linear(colour[0]),
                render::byte_of_linear(colour[1]), render::byte_of_linear(colour[2]));
  return text.data();
}

// Five digits are more than a curve can show.
double shortened(double value) {
  std::array<char, 32> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 5);
  std::from_chars(text.data(), end.ptr, value);
  return value;
}

// In a single pass, so that a mark in the title is not replaced.
std::string filled_bundle(const std::string& title, const std::string& bake) {
  std::string page;
  std::string_view rest = view_bundle();
  for (std::size_t at = rest.find('@'); at != std::string_view::npos; at = rest.find('@', at)) {
    const bool is_title = rest.substr(at).starts_with(title_place);
    if (!is_title && !rest.substr(at).starts_with(bake_place)) {
      ++at;
      continue;
    }
    page += rest.substr(0, at);
    page += is_title ? title : bake;
    rest.remove_prefix(at + (is_title ? title_place : bake_place).size());
    at = 0;
  }
  return page += rest;
}

// The drawn points, without duplicates: their vertices in the bake, and the reverse.
struct Used {
  std::vector<std::uint32_t> source;
  std::vector<std::uint32_t> of_vertex;  // per drawn vertex
};

Used used_points(const DrawnSurface& surface) {
  Used used{surface.source, {}};
  std::sort(used.source.begin(), used.source.end());
  used.source.erase(std::unique(used.source.begin(), used.source.end()), used.source.end());
  for (const std::uint32_t source : surface.source)
    used.of_vertex.push_back(static_cast<std::uint32_t>(
        std::lower_bound(used.source.begin(), used.source.end(), source) - used.source.begin()));
  return used;
}

std::vector<float> picked(const std::vector<float>& places, const std::vector<std::uint32_t>& points) {
  std::vector<float> result;
  result.reserve(3 * points.size());
  for (const std::uint32_t point : points)
    result.insert(result.end(), places.begin() + std::ptrdiff_t{3} * point,
                  places.begin() + std::ptrdiff_t{3} * point + 3);
  return result;
}

// Throws BakeError for positions that no grid could hold.
std::array<double, 6> box_of(const std::vector<const Places*>& all, const std::filesystem::path& bake) {
  constexpr double far = std::numeric_limits<double>::infinity();
  std::array<double, 6> box{far, far, far, -far, -far, -far};
  for (const Places* places : all)
    for (const std::vector<float>& frame : *places) {
      constexpr double metres = 1.0;
      if (!model::is_in_reach(frame, metres))
        throw base::BakeError(
            bake.string() + ": frame " + base::number_text(&frame - places->data()) +
            " cannot be shown: it is absurdly large, or not finite; bake again with --overwrite");
      for (std::size_t k = 0; k < frame.size(); ++k) {
        box[k % 3] = std::min(box[k % 3], double{frame[k]});
        box[3 + k % 3] = std::max(box[3 + k % 3], double{frame[k]});
      }
    }
  return box;
}

std::vector<std::vector<Cell>> cells_of(const Grid& grid, const Places& places) {
  std::vector<std::vector<Cell>> cells(places.size());
  for (std::size_t k = 0; k < places.size(); ++k)
    for (std::size_t i = 0; i < places[k].size(); i += 3) cells[k].push_back(cell_of(grid, &places[k][i]));
  return cells;
}

// Points with the same cells in every frame, such as those along a seam, are coded once. Returns, per point,
// the first point equal to it.
std::vector<std::uint32_t> first_alike(const std::vector<std::vector<Cell>>& flesh,
                                       const std::vector<std::vector<Cell>>& ghost) {
  std::vector<std::uint32_t> order(flesh[0].size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto compare = [&](std::uint32_t a, std::uint32_t b) {
    for (const auto* frames : {&flesh, &ghost})
      for (const std::vector<Cell>& cells : *frames)
        if (cells[a] != cells[b]) return cells[a] < cells[b] ? -1 : 1;
    return 0;
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const int sign = compare(a, b);
    return sign != 0 ? sign < 0 : a < b;
  });
  std::vector<std::uint32_t> first(order.size());
  for (std::size_t k = 0; k < order.size(); ++k)
    first[order[k]] = k > 0 && compare(order[k - 1], order[k]) == 0 ? first[order[k - 1]] : order[k];
  return first;
}

class BakePage {
 public:
  explicit BakePage(const PageOptions& options) : options_(options), bake_(options.bake) {}

  PageResult go();

 private:
  bool read_frames();
  void quantise();
  std::optional<std::string> code();  // nothing if interrupted
  bool goes_on();
  ordered_json description() const;

  const PageOptions& options_;
  const bake::FinishedBake bake_;
  DrawnSurface surface_;
  PageLooks looks_;
  std::vector<TriangleGroup> groups_;
  Used used_;
  Places flesh_, ghost_;  // ghost_: a single frame if it does not move
  Grid grid_;
  std::vector<std::vector<Cell>> flesh_cells_, ghost_cells_;
  std::uint32_t places_ = 0;
  std::vector<std::uint32_t> surroundings_;  // places, ascending
  std::uint64_t steps_ = 0, steps_done_ = 0;
  PageResult result_;
};

// After a step. False if interrupted.
bool BakePage::goes_on() {
  ++steps_done_;
  if (options_.on_step) options_.on_step(steps_done_, steps_);
  return options_.interrupted == nullptr || !options_.interrupted->load();
}

bool BakePage::read_frames() {
  const model::Model& model = bake_.model();
  const auto world = [&](const std::vector<float>& positions, const std::array<double, 3>& origin) {
    return picked(formats::world_positions(positions, model.unit, origin), used_.source);
  };
  const bool is_skinned = !bake_.character().empty() && !surface_.is_tetrahedra;
  steps_ = (is_skinned ? 3 : 2) * bake_.frame_count();
  if (is_skinned) {
    const formats::SkinnedSurface skinned(bake_.character(), model, bake_.header().fps);
    for (std::uint64_t k = 0; k < bake_.frame_count(); ++k) {
      ghost_.push_back(picked(skinned.positions(k), used_.source));
      if (!goes_on()) return false;
    }
  } else {
    ghost_.push_back(
        world(surface_.is_tetrahedra ? model.rest : formats::embed(model, model.rest), model.rest_origin));
  }
  for (std::uint64_t k = 0; k < bake_.frame_count(); ++k) {
    const model::Frame frame = bake_.frame(k);
    flesh_.push_back(world(surface_.is_tetrahedra ? frame.positions : frame.surface, frame.origin));
    if (!goes_on()) return false;
  }
  return true;
}

void BakePage::quantise() {
  const model::Model& model = bake_.model();
  const std::array<double, 6> box = box_of({&flesh_, &ghost_}, options_.bake);
  grid_ = grid_for(box, options_.error.value_or(default_share * model::extent(model)));
  if (options_.error && grid_.error() > *options_.error * (1.0 + 1e-9))
    throw bake::ContradictingOptions("an error of " + base::number_text(*options_.error) +
                                     " m is less than a page can reach for this motion, which is " +
                                     base::number_text(grid_.error()) + " m; give that or more");
  flesh_cells_ = cells_of(grid_, flesh_);
  ghost_cells_ = cells_of(grid_, ghost_);
  result_.error = grid_.error();
}

std::optional<std::string> BakePage::code() {
  // Number the places: equal points share one, and neighbours get nearby numbers.
  const std::vector<std::uint32_t> first = first_alike(flesh_cells_, ghost_cells_);
  constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> number(first.size(), none), point;
  for (std::uint32_t i = 0; i < first.size(); ++i)
    if (first[i] == i) {
      number[i] = static_cast<std::uint32_t>(point.size());
      point.push_back(i);
    }
  places_ = static_cast<std::uint32_t>(point.size());
  std::vector<std::uint32_t> place;  // per drawn vertex
  for (const std::uint32_t used : used_.of_vertex) place.push_back(number[first[used]]);
  const auto triangles_of_places = [&] {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (const auto& t : surface_.triangles) triangles.push_back({place[t[0]], place[t[1]], place[t[2]]});
    return triangles;
  };
  {
    const std::vector<std::uint32_t> order = walk(places_, triangles_of_places());
    std::vector<std::uint32_t> at(places_), in_order;
    for (std::uint32_t k = 0; k < places_; ++k) {
      at[order[k]] = k;
      in_order.push_back(point[order[k]]);
    }
    point = std::move(in_order);
    for (std::uint32_t& p : place) p = at[p];
  }
  if (!surface_.is_tetrahedra) {
    const model::Surroundings surroundings = model::surroundings_of(bake_.model());
    for (std::uint32_t p = 0; p < places_; ++p)
      if (surroundings.surface[used_.source[point[p]]] != 0) surroundings_.push_back(p);
  }

  RangeEncoder to;
  std::size_t context = 0;
  NumberEncoder numbers(16);
  // Codes each list as differences from the entry `width` before, with a separate context.
  const auto put_list = [&](const auto& list, std::size_t width) {
    for (std::size_t k = 0; k < list.size(); ++k)
      numbers.put(to,
                  static_cast<std::int32_t>(static_cast<std::int64_t>(list[k]) -
                                            (k < width ? 0 : static_cast<std::int64_t>(list[k - width]))),
                  context);
    ++context;
  };
  std::vector<std::uint32_t> corners;
  for (const auto& triangle : surface_.triangles)
    corners.insert(corners.end(), triangle.begin(), triangle.end());
  put_list(corners, 1);
  put_list(place, 1);
  put_list(surface_.normal, 1);
  put_list(surface_.layer, 1);
  put_list(surface_.source, 1);
  if (!looks_.uvs.empty() && !surface_.is_tetrahedra) {
    std::vector<std::int32_t> uvs;
    for (const std::uint32_t s : surface_.source)
      for (const float uv : looks_.uvs[s])
        uvs.push_back(static_cast<std::int32_t>(
            std::lround((std::isfinite(uv) ? std::clamp(uv, -8192.0f, 8192.0f) : 0.0f) / uv_step)));
    put_list(uvs, 2);
  }
  if (!looks_.colours.empty() && !surface_.is_tetrahedra) {
    std::vector<std::int32_t> colours;
    for (const std::uint32_t s : surface_.source)
      colours.insert(colours.end(), looks_.colours[s].begin(), looks_.colours[s].end());
    put_list(colours, 3);
  }

  const Neighbours neighbours = lower_neighbours(places_, triangles_of_places());
  MotionEncoder ghost(neighbours), flesh(neighbours);
  const auto at_places = [&](const std::vector<Cell>& cells) {
    std::vector<Cell> result;
    for (const std::uint32_t p : point) result.push_back(cells[p]);
    return result;
  };
  std::vector<Cell> ghost_now;
  for (std::size_t k = 0; k < flesh_cells_.size(); ++k) {
    if (k < ghost_cells_.size()) {
      ghost_now = at_places(ghost_cells_[k]);
      ghost.put(to, ghost_now);
    }
    flesh.put(to, at_places(flesh_cells_[k]), ghost_now);
    if (!goes_on()) return std::nullopt;
  }
  return to.finish();
}

ordered_json BakePage::description() const {
  const model::Model& model = bake_.model();
  const bake::ManifestSummary& manifest = bake_.manifest();
  ordered_json json;
  json["version"] = 1;
  json["program"] = std::string("fascicle ") + base::fascicle_version;
  json["scene"] = manifest.scene_name;
  json["device"] = manifest.device;
  json["fps"] = bake_.header().fps;
  json["start"] = bake_.header().start;
  json["frames"] = bake_.frame_count();
  json["first_number"] = manifest.first_number;
  json["surface"] = surface_.is_tetrahedra ? "tetrahedra" : "render mesh";
  json["bake_vertices"] = result_.vertices;
  json["tetrahedra"] = model.tetrahedron_count();
  json["error"] = result_.error;
  json["origin"] = grid_.origin;
  json["step"] = grid_.step;
  json["places"] = places_;
  json["surroundings"] = surroundings_;
  json["vertices"] = surface_.source.size();
  json["triangles"] = surface_.triangles.size();
  json["ghost"] = ghost_.size() > 1 || !bake_.character().empty() ? "skinning" : "rest shape";
  json["ghost_frames"] = ghost_.size();
  json["has_uvs"] = !looks_.uvs.empty() && !surface_.is_tetrahedra;
  json["has_colours"] = !looks_.colours.empty() && !surface_.is_tetrahedra;
  json["painted"] = looks_.is_painted && !surface_.is_tetrahedra;
  json["groups"] = ordered_json::array();
  for (const TriangleGroup& group : groups_)
    json["groups"].push_back({{"material", group.number}, {"triangles", group.count}});
  json["materials"] = ordered_json::array();
  for (const PageMaterial& material : looks_.materials)
    json["materials"].push_back({{"name", material.name},
                                 {"colour", material.colour},
                                 {"cutoff", material.cutoff},
                                 {"texture", material.texture}});
  json["textures"] = ordered_json::array();
  for (const PageTexture& texture : looks_.textures)
    json["textures"].push_back({{"type", texture.type},
                                {"across", texture.across},
                                {"down", texture.down},
                                {"base64", base64(texture.bytes)}});
  json["layers"] = ordered_json::array();
  for (std::size_t l = 0; l < model.layers.size(); ++l)
    json["layers"].push_back({{"name", model.layers[l].name},
                              {"colour", hex_colour(render::layer_colour(model.layers[l].name, l))}});
  json["curves"] = ordered_json::array();
  for (const Curve& curve : read_curves(options_.bake, bake_.frame_count())) {
    ordered_json values = ordered_json::array();
    for (const std::optional<double>& value : curve.values)
      values.push_back(value ? ordered_json(shortened(*value)) : ordered_json());
    json["curves"].push_back({{"name", curve.name},
                              {"unit", curve.unit},
                              {"limit", curve.limit ? ordered_json(*curve.limit) : ordered_json()},
                              {"values", values}});
  }
  json["warnings"] = manifest.warnings;
  return json;
}

PageResult BakePage::go() {
  const model::Model& model = bake_.model();
  surface_ = drawn_surface(model);
  looks_ = page_looks(surface_.is_tetrahedra ? std::filesystem::path() : bake_.character(), model);
  result_.warnings = looks_.warnings;
  std::vector<std::uint32_t> material(surface_.triangles.size(), 0);
  for (std::size_t t = 0; t < material.size() && !surface_.is_tetrahedra; ++t)
    material[t] = looks_.material[surface_.source[surface_.triangles[t][0]]];
  groups_ = group_triangles(surface_, material);
  used_ = used_points(surface_);
  if (used_.source.size() * bake_.frame_count() > most_points)
    throw base::BakeError(options_.bake.string() + ": " + base::number_text(bake_.frame_count()) +
                          " frames of " + base::number_text(used_.source.size()) +
                          " vertices are too many for a page; bake a shorter range (--start, --end)");
  result_.frames = bake_.frame_count();
  result_.vertices = surface_.is_tetrahedra ? model.vertex_count : model.surface_count();
  result_.triangles = surface_.triangles.size();
  if (!read_frames()) {
    result_.interrupted = true;
    return std::move(result_);
  }
  quantise();
  const std::optional<std::string> bytes = code();
  if (!bytes) {
    result_.interrupted = true;
    return std::move(result_);
  }
  ordered_json json = description();
  json["motion"] = base64(*bytes);
  result_.html = filled_bundle(html_text(base::shown_text(bake_.manifest().scene_name)), script_json(json));
  return std::move(result_);
}

}  // namespace

PageResult page_of_bake(const PageOptions& options) {
  PageResult result;
  bake::read_kept(options.bake, [&] { result = BakePage(options).go(); });
  return result;
}

}  // namespace fascicle::page
