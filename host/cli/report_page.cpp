#include "host/cli/report_page.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include <nlohmann/json.hpp>

#include "host/bake/outputs.h"
#include "host/base/version.h"
#include "host/cli/text.h"
#include "host/page/page.h"
#include "host/page/plot.h"

namespace fascicle::cli {
namespace {

using Json = nlohmann::ordered_json;
using page::Tone;
using page::Writer;
using Rows = std::vector<std::pair<std::string, std::string>>;

// Longer values are cut off, and tables have no more rows than this.
constexpr std::size_t most_characters = 160, most_rows = 400;
// Deeper nesting does not come from the program, and recursing into it would exhaust the stack.
constexpr unsigned most_levels = 16;

// The value at a path, or null.
const Json& at(const Json& json, std::initializer_list<const char*> path) {
  static const Json none;
  const Json* found = &json;
  for (const char* key : path) {
    if (!found->is_object()) return none;
    const auto entry = found->find(key);
    if (entry == found->end()) return none;
    found = &*entry;
  }
  return *found;
}

std::string shortened(std::string text) {
  if (text.size() <= most_characters) return text;
  std::size_t end = most_characters;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end) + "...";
}

bool is_nested_within(const Json& value, unsigned levels) {
  if (!value.is_structured()) return true;
  return levels > 0 && std::all_of(value.begin(), value.end(), [levels](const Json& below) {
           return is_nested_within(below, levels - 1);
         });
}

std::string words_of(const Json& value) {
  if (value.is_null()) return "-";
  if (!is_nested_within(value, most_levels)) return "...";
  if (value.is_string()) return shortened(value.get<std::string>());
  return shortened(value.dump(-1, ' ', false, Json::error_handler_t::replace));
}

std::string text_at(const Json& json, std::initializer_list<const char*> path) {
  return words_of(at(json, path));
}

std::optional<double> number_at(const Json& json, std::initializer_list<const char*> path) {
  const Json& value = at(json, path);
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

std::string count_at(const Json& json, std::initializer_list<const char*> path) {
  const Json& value = at(json, path);
  return value.is_number_unsigned() ? count_text(value.get<std::uint64_t>()) : words_of(value);
}

// Adds the leaves of an object with their paths. A list is one value.
void add_leaves(const Json& json, const std::string& path, unsigned levels, Rows& rows) {
  if (rows.size() >= most_rows) return;
  if (!json.is_object() || levels == 0) {
    rows.emplace_back(path, words_of(json));
    return;
  }
  for (const auto& [key, value] : json.items())
    add_leaves(value, path.empty() ? key : path + "." + key, levels - 1, rows);
}

std::string length_text(double metres) {
  return number_text(metres * 1e3) + " mm";
}

// The maximum of a column and its frame; nullopt without finite values.
struct Peak {
  double value = 0.0;
  std::uint64_t frame = 0;
};
std::optional<Peak> peak_of(const MetricsTable& metrics, const std::string& column) {
  const std::vector<double>*values = metrics.find(column), *frames = metrics.find("frame");
  std::optional<Peak> peak;
  if (values == nullptr || frames == nullptr) return peak;
  for (std::size_t k = 0; k < values->size(); ++k)
    if (std::isfinite((*values)[k]) && (*frames)[k] >= 0.0 && (*frames)[k] < 1e15 &&
        (!peak || (*values)[k] > peak->value))
      peak = Peak{(*values)[k], static_cast<std::uint64_t>((*frames)[k])};
  return peak;
}

// For columns with this prefix, the rest of their names.
std::vector<std::string> named_after(const MetricsTable& metrics, const std::string& beginning) {
  std::vector<std::string> names;
  for (const std::string& column : metrics.columns)
    if (column.starts_with(beginning)) names.push_back(column.substr(beginning.size()));
  return names;
}

Tone tone_of_status(const std::string& status) {
  if (status == bake::name_of(bake::Status::complete)) return Tone::good;
  return status == bake::name_of(bake::Status::running) || status == bake::name_of(bake::Status::interrupted)
             ? Tone::warning
             : Tone::bad;
}

double clip_seconds(const Report& report) {
  return report.fps > 0.0 && report.frame_count > 0 ? static_cast<double>(report.frame_count - 1) / report.fps
                                                    : 0.0;
}

void write_facts(Writer& page, const Report& report, const Json& manifest) {
  std::vector<page::Fact> facts;
  facts.push_back({"Frames", count_text(report.frame_count), Tone::neutral,
                   number_text(report.fps) + " a second, " + number_text(clip_seconds(report)) + " s"});
  if (const auto look = peak_of(report.metrics, bake::look_column))
    facts.push_back({"Look, worst", number_text(look->value, 3),
                     look->value > 1.0 ? Tone::warning : Tone::good,
                     (look->value > 1.0 ? "over the limit of 1, frame " : "limit 1, frame ") +
                         std::to_string(look->frame)});
  std::string layer;
  std::optional<Peak> lag;
  for (const std::string& name : named_after(report.metrics, bake::lag_column))
    if (const auto peak = peak_of(report.metrics, bake::lag_column + name);
        peak && (!lag || peak->value > lag->value)) {
      lag = peak;
      layer = name;
    }
  if (lag)
    facts.push_back({"Lag, largest", length_text(lag->value), Tone::neutral,
                     layer + ", frame " + std::to_string(lag->frame)});
  const double solver = report.manifest.timings.solver;
  if (solver > 0.0 && clip_seconds(report) > 0.0)
    facts.push_back({"Speed, real time", number_text(clip_seconds(report) / solver, 3) + " x", Tone::neutral,
                     "solver " + duration_text(solver)});
  facts.push_back({"Vertices", count_at(manifest, {"model", "vertices"}), Tone::neutral,
                   count_at(manifest, {"model", "tetrahedra"}) + " tetrahedra"});
  facts.push_back({"Warnings", std::to_string(report.warnings.size()),
                   report.warnings.empty() ? Tone::good : Tone::warning, ""});
  page::facts(page, facts);
}

const FramePictures* pictures_of(const Report& report, std::uint64_t frame) {
  const auto found = std::find_if(report.pictures.begin(), report.pictures.end(),
                                  [frame](const FramePictures& one) { return one.frame == frame; });
  return found == report.pictures.end() ? nullptr : &*found;
}

std::string look_of(const Report& report, std::uint64_t frame) {
  const auto row = std::find_if(report.scores.frames.begin(), report.scores.frames.end(),
                                [frame](const FrameScore& score) { return score.frame == frame; });
  // Below this it looks like skinning.
  constexpr double least_look = 0.01;
  if (row == report.scores.frames.end() || !row->look || *row->look < least_look) return "";
  std::string words = "; look " + number_text(*row->look, 3);
  if (!row->cause.empty()) words += ", " + row->cause;
  if (!row->joint.empty()) words += " at " + row->joint;
  return words;
}

void write_frame(Writer& page, const Report& report, const FramePictures& pictures) {
  const std::string frame = "frame " + std::to_string(pictures.frame);
  const std::string beside = report.has_skeleton ? "skinning alone" : "the rest shape";
  page.start("figure", {{"class", "still"}});
  page.start("div", {{"class", pictures.skinned ? "pair" : "single"}});
  if (pictures.skinned)
    page::picture(page, pictures.skinned->png, frame + ", " + beside, pictures.skinned->width,
                  pictures.skinned->height);
  page::picture(page, pictures.flesh.png, frame + ", flesh", pictures.flesh.width, pictures.flesh.height);
  page.close().element("figcaption", "Frame " + std::to_string(pictures.frame) + ", " +
                                         number_text(pictures.time) + " s" + look_of(report, pictures.frame));
  page.close();
}

void write_frames(Writer& page, const Report& report, const std::vector<std::uint64_t>& frames) {
  page.start("div", {{"class", "grid"}});
  for (const std::uint64_t frame : frames)
    if (const FramePictures* pictures = pictures_of(report, frame)) write_frame(page, report, *pictures);
  page.close();
}

void write_stills(Writer& page, const Report& report) {
  page::open_section(page, "stills", "Stills");
  if (!report.lacks.empty()) page.element("p", report.lacks, {{"class", "warning"}});
  if (!report.stills.empty()) {
    page.element("p", std::string(report.has_skeleton ? "Left: skinning alone. " : "Left: the rest shape. ") +
                          "Right: with flesh.");
    write_frames(page, report, report.stills);
  }
  page.close();
}

void write_warnings(Writer& page, const Report& report) {
  page::open_section(page, "warnings", "Warnings and worst frames");
  if (report.warnings.empty()) page.element("p", "The bake gave no warnings.");
  page.start("ul", {{"class", "notes"}});
  for (const ReportWarning& warning : report.warnings) {
    page.start("li").element("p", warning.text);
    if (warning.frame)
      if (const FramePictures* pictures = pictures_of(report, *warning.frame)) {
        page.start("div", {{"class", "grid"}});
        write_frame(page, report, *pictures);
        page.close();
      }
    page.close();
  }
  page.close();
  if (!report.worst.empty()) {
    page.element("h3", "The frames that look worst");
    page.element("p", "Look compares a frame with skinning alone. Above 1, a viewer would object.",
                 {{"class", "soft"}});
    write_frames(page, report, report.worst);
  }
  page.close();
}

// Series of all columns with this prefix, times a factor.
std::vector<page::Series> series_of(const MetricsTable& metrics, const std::string& beginning,
                                    double factor) {
  std::vector<page::Series> series;
  for (const std::string& name : named_after(metrics, beginning)) {
    page::Series one{name, *metrics.find(beginning + name)};
    for (double& value : one.values) value *= factor;
    series.push_back(std::move(one));
  }
  return series;
}

// Series of those of these columns that exist, times a factor.
std::vector<page::Series> series_named(const MetricsTable& metrics,
                                       std::initializer_list<std::pair<const char*, const char*>> columns,
                                       double factor) {
  std::vector<page::Series> series;
  for (const auto& [column, name] : columns)
    if (const std::vector<double>* values = metrics.find(column)) {
      series.push_back({name, *values});
      for (double& value : series.back().values) value *= factor;
    }
  return series;
}

void write_curves(Writer& page, const Report& report) {
  page::open_section(page, "curves", "Curves");
  const MetricsTable& metrics = report.metrics;
  const std::vector<double>* time = metrics.find("time");
  if (time == nullptr || time->empty()) {
    page.element("p", "metrics.csv is missing or has no rows.").close();
    return;
  }
  page.start("div", {{"class", "plots"}});
  const auto draw = [&](const char* title, const char* y, std::vector<page::Series> series,
                        std::optional<double> limit = std::nullopt, bool from_zero = true) {
    page::plot(page, {.title = title,
                      .x_name = "time, s",
                      .y_name = y,
                      .x = *time,
                      .series = std::move(series),
                      .limit = limit,
                      .from_zero = from_zero});
  };
  draw("Lag behind skinning, by layer", "lag, mm", series_of(metrics, bake::lag_column, 1e3));
  draw("Look", "look", series_named(metrics, {{bake::look_column, "look"}}, 1.0), 1.0);
  draw("Kinetic energy", "energy, J", series_named(metrics, {{"kinetic_energy", "energy"}}, 1.0));
  std::vector<page::Series> volumes = series_named(metrics, {{"volume_ratio", "whole body"}}, 100.0);
  for (page::Series& layer : series_of(metrics, bake::volume_ratio_column, 100.0))
    volumes.push_back(std::move(layer));
  draw("Volume relative to rest", "volume, %", std::move(volumes), std::nullopt, false);
  draw("Inverted tetrahedra", "tetrahedra",
       series_named(metrics, {{"inverted", "flesh"}, {"inverted_skinned", "skinning alone"}}, 1.0));
  draw("Overlapping flesh", "volume, cm3",
       series_named(metrics, {{"contact_volume", "flesh"}, {"contact_volume_skinned", "skinning alone"}},
                    1e6));
  page.close();

  std::vector<std::vector<std::string>> peaks{{"Column of metrics.csv", "Largest", "Frame"}};
  for (const std::string& column : metrics.columns) {
    if (column == "frame" || column == "time" || peaks.size() > most_rows) continue;
    if (const auto peak = peak_of(metrics, column))
      peaks.push_back({column, number_text(peak->value, 6), std::to_string(peak->frame)});
  }
  page.start("details").element("summary", "Largest values of all columns");
  page::table(page, peaks, 1);
  page.close().close();
}

void write_body(Writer& page, const Report& report, const Json& manifest) {
  page::open_section(page, "body", "From skin to body");
  if (report.rest) {
    const RestReport& rest = *report.rest;
    const auto count = [](std::uint64_t value) { return count_text(value); };
    page.start("div", {{"class", "grid"}});
    const auto show = [&](const EncodedPicture& picture, const std::string& words) {
      page.start("figure");
      page::picture(page, picture.png, words, picture.width, picture.height);
      page.element("figcaption", words).close();
    };
    show(rest.before, rest.skin.open_edges > 0 ? "Before: the skin of the file; its open edges are red"
                                               : "Before: the skin of the file, without open edges");
    show(rest.after, "After: the simulated body of tetrahedra");
    show(rest.cut, "The body cut open, coloured by layer");
    page.close();
    page::swatches(page, rest.layers);
    page::table(page,
                {{"Count", "Skin, before", "Body, after"},
                 {"Surface vertices", count(rest.skin.vertices), count(rest.body.vertices)},
                 {"Triangles", count(rest.skin.triangles), count(rest.body.triangles)},
                 {"Open edges", count(rest.skin.open_edges), count(rest.body.open_edges)},
                 {"Separate parts", count(rest.skin.parts), count(rest.body.parts)}},
                1);
  }
  if (const Json& ends = at(manifest, {"open_ends"}); ends.is_array() && !ends.empty()) {
    std::vector<std::vector<std::string>> table{{"Open end at joint", "Treatment", "Width", "Edges"}};
    for (const Json& end : ends) {
      if (table.size() > most_rows) break;
      const auto width = number_at(end, {"width_m"});
      table.push_back({text_at(end, {"joint"}), text_at(end, {"became"}), width ? length_text(*width) : "-",
                       count_at(end, {"edges"})});
    }
    page::table(page, table, 2, "Open ends of the skin");
  }
  page.close();
}

void write_timing(Writer& page, const Report& report) {
  const bake::Timings& timings = report.manifest.timings;
  const double clip = clip_seconds(report);
  page::open_section(page, "timing", "Timing");
  if (timings.solver > 0.0 && clip > 0.0)
    page.element("p", "The solver took " + duration_text(timings.solver) + " for " + number_text(clip) +
                          " s of motion: " + number_text(clip / timings.solver, 3) + " times real time, " +
                          number_text(static_cast<double>(report.frame_count) / timings.solver, 3) +
                          " frames a second" +
                          (timings.runs > 1 ? ", in " + std::to_string(timings.runs) + " runs." : "."));
  page::bars(page, "Seconds; the line is real time",
             {{"the motion itself", number_text(clip) + " s", clip},
              {"solver", duration_text(timings.solver), timings.solver},
              {"writing, in parallel", duration_text(timings.writing), timings.writing},
              {"whole bake", duration_text(timings.total), timings.total}},
             clip);
  page.close();
}

void write_layers(Writer& page, const Json& manifest) {
  const Json& layers = at(manifest, {"model", "layers"});
  if (!layers.is_array() || layers.empty()) return;
  std::vector<std::vector<std::string>> table{{"Layer", "Vertices", "Mass, kg", "Damping, 1/s", "Stiffness"}};
  const Json& scene_layers = at(manifest, {"scene", "layers"});
  for (std::size_t k = 0; k < layers.size() && k < most_rows; ++k) {
    const Json& layer = layers[k];
    const auto number = [&](const char* key) {
      const auto value = number_at(layer, {key});
      return value ? number_text(*value) : "-";
    };
    std::string stiffness = "-";
    if (scene_layers.is_array() && k < scene_layers.size()) {
      const Json& of_scene = scene_layers[k];
      if (const Json& still = at(of_scene, {"kinematic"}); still.is_boolean() && still.get<bool>())
        stiffness = "follows the skeleton";
      else if (const auto modulus = number_at(of_scene, {"youngs_modulus"}))
        stiffness = number_text(*modulus / 1e3) + " kPa";
      else if (const auto frequency = number_at(of_scene, {"frequency"}))
        stiffness = number_text(*frequency) + " Hz";
      else if (const Json& material = at(of_scene, {"material"});
               material.is_string() && !material.get<std::string>().empty())
        stiffness = words_of(material);
      else if (const auto alpha = number_at(of_scene, {"alpha"}))
        stiffness = "alpha " + number_text(*alpha);
    }
    table.push_back({text_at(layer, {"name"}), count_at(layer, {"vertices"}), number("mass"),
                     number("damping"), stiffness});
  }
  page::table(page, table, 1, "Layers");
}

void write_parameters(Writer& page, const Json& manifest) {
  page::open_section(page, "parameters", "Parameters");
  write_layers(page, manifest);
  Rows rows;
  if (const Json& scene = at(manifest, {"scene"}); scene.is_object())
    for (const auto& [key, value] : scene.items())
      if (key != "text") add_leaves(value, key, most_levels, rows);
  page.start("details", {{"class", "code"}}).element("summary", "Every scene key, as used");
  page::rows(page, rows);
  page.close();
  if (const Json& text = at(manifest, {"scene", "text"}); text.is_string()) {
    page.start("details").element("summary", "The scene file");
    page.start("pre").start("code");
    // Line by line, because text within a line is shown escaped.
    const std::string whole = text.get<std::string>();
    for (std::size_t begin = 0; begin < whole.size();) {
      const std::size_t end = std::min(whole.find('\n', begin), whole.size());
      page.text(whole.substr(begin, end - begin)).line_end();
      begin = end + 1;
    }
    page.close().close().close();
  }
  page.close();
}

void write_provenance(Writer& page, const Report& report, const Json& manifest) {
  page::open_section(page, "provenance", "Provenance");
  Rows rows{{"Folder", report.folder},
            {"Status", report.manifest.status +
                           (report.manifest.message.empty() ? "" : ": " + report.manifest.message)},
            {"Scene", report.manifest.scene_name + ", from " + report.manifest.scene_source},
            {"Clip", text_at(manifest, {"scene", "clip_name"})},
            {"fascicle", text_at(manifest, {"fascicle", "version"})},
            {"Solver version", text_at(manifest, {"fascicle", "solver_version"})},
            {"Device", report.manifest.device},
            {"Driver", text_at(manifest, {"device", "driver"})},
            {"Exact", at(manifest, {"device", "exact"}) == Json(true)
                          ? "yes: the same bits as on every exact device"
                          : "no"},
            {"Threads", text_at(manifest, {"device", "threads"})},
            {"Hash of the model", text_at(manifest, {"model", "hash"})},
            {"Position hash of the last frame", report.manifest.last_position_hash}};
  page::rows(page, rows);
  if (!report.manifest.input_hashes.empty()) {
    std::vector<std::vector<std::string>> inputs{{"Input", "xxh3_64"}};
    for (const auto& [file, hash] : report.manifest.input_hashes)
      if (inputs.size() <= most_rows) inputs.push_back({file, hash});
    page::table(page, inputs, 2, "Inputs");
  }
  page.close();
}

}  // namespace

std::string report_page(const Report& report, const Json& manifest) {
  const std::string& name = report.manifest.scene_name;
  Writer page = page::begin(name.empty() ? "A bake" : name, "Report on the bake in " + report.folder,
                            report.manifest.status, tone_of_status(report.manifest.status));
  page::contents(page, {{"stills", "Stills"},
                        {"warnings", "Warnings"},
                        {"curves", "Curves"},
                        {"body", "Body"},
                        {"timing", "Timing"},
                        {"parameters", "Parameters"},
                        {"provenance", "Provenance"}});
  write_facts(page, report, manifest);
  write_stills(page, report);
  write_warnings(page, report);
  write_curves(page, report);
  write_body(page, report, manifest);
  write_timing(page, report);
  write_parameters(page, manifest);
  write_provenance(page, report, manifest);
  return page::finish(std::move(page), std::string("Written by fascicle ") + base::fascicle_version +
                                           ". This page is self-contained and loads nothing.");
}

}  // namespace fascicle::cli
