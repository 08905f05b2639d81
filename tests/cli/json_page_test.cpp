// docs/json.md names every field of the JSON that the program writes for other programs, and docs/formats.md
// every column of metrics.csv.
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/cli/batch_summary.h"
#include "host/cli/bench_results.h"
#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

using FieldJson = nlohmann::json;
using FieldNames = std::set<std::string>;

// Small, and with all that adds fields to the manifest or columns to metrics.csv.
constexpr const char* scene_with_every_field = R"([scene]
end = 0.017

[character.a]
made = "arm"
resolution = 0.06

[character.b]
made = "arm"
resolution = 0.06
rigid = true
at = [0.0, 0.3, 0.0]

[layers.fat]
material = "fat"
damping = 12.0

[layers.bone]
kinematic = true
where = { depth = { maximum = 0.3, per_bone = { "a/forearm" = 0.4 } } }

[layers.skin]
material = "skin"
sliding = true
where = { depth = { minimum = 0.9999, maximum = 1.0 } }

[contact]
self = true

[muscle.biceps]
joint = "a/forearm"

[fibres.middle]
points = [[0, 0, 0], [0.1, 0, 0]]

[probe.tip]
where = { joints = { names = ["a/hand"] } }

[force.breeze]
kind = "wind"
vector = [0, 0, 1]

[collider.floor]
shape = "plane"
center = [0, -2, 0]

[solver]
substeps = "auto"
)";

std::string page_text(const std::string& name) {
  return read_text(std::filesystem::path(FASCICLE_SOURCE_DIR) / "docs" / name);
}

// From the heading to the next one of its level; empty without it.
std::string page_section(const std::string& page, const std::string& heading) {
  const std::size_t begin = page.find("\n## " + heading + "\n");
  if (begin == std::string::npos) return {};
  return page.substr(begin, page.find("\n## ", begin + 1) - begin);
}

FieldNames words_in_code(const std::string& text) {
  static const std::regex code("`([^`\n]+)`");
  FieldNames words;
  for (std::sregex_iterator found(text.begin(), text.end(), code), end; found != end; ++found)
    words.insert(found->str(1));
  return words;
}

// The names of all fields, at any depth. Some objects are maps: their keys are names of the scene, devices or
// numbers.
void add_field_names(const FieldJson& found, FieldNames& names) {
  static const FieldNames maps{"copy_gb_s", "gpus", "ns_by_stage", "per_bone", "probes", "triad_gb_s"};
  if (found.is_array())
    for (const FieldJson& entry : found) add_field_names(entry, names);
  if (!found.is_object()) return;
  for (const auto& [name, value] : found.items()) {
    names.insert(name);
    if (!value.is_object() || !maps.contains(name)) add_field_names(value, names);
  }
}

// The fields that neither the section nor `elsewhere` names.
FieldNames missing_fields(const FieldJson& found, const std::string& section,
                          const FieldNames& elsewhere = {}) {
  FieldNames written, named = words_in_code(section), missing;
  named.insert(elsewhere.begin(), elsewhere.end());
  add_field_names(found, written);
  std::ranges::set_difference(written, named, std::inserter(missing, missing.end()));
  return missing;
}

FieldJson printed_json(const std::vector<std::string>& command) {
  const Outcome outcome = fascicle(command);
  EXPECT_EQ(outcome.status, 0) << command.front() << ": " << outcome.err;
  return FieldJson::parse(outcome.out, nullptr, false);
}

// A page's tables may name several columns in the first cell of a row.
FieldNames columns_in_tables(const std::string& section) {
  FieldNames columns;
  std::istringstream lines(section);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("| `")) columns.merge(words_in_code(line.substr(0, line.find(" | "))));
  return columns;
}

const FieldNames none_missing;

TEST(JsonPage, NamesTheFieldsAndColumnsOfABake) {
  const TemporaryFolder folder;
  const std::string scene = folder / "scene.toml", out = folder / "out", page = page_text("json.md");
  write_text(scene, scene_with_every_field);
  const Outcome baked =
      fascicle({"bake", scene, "-o", out, "--device", "cpu", "--verbose", "--log-format", "json"});
  ASSERT_EQ(baked.status, 0) << baked.err;

  FieldJson manifest = FieldJson::parse(read_text(out + "/manifest.json"));
  const std::string of_manifest = page_section(page, "manifest.json");
  // The keys of scene files have a page of their own.
  EXPECT_EQ(missing_fields(manifest.at("scene"), of_manifest, words_in_code(page_text("scene.md"))),
            none_missing);
  manifest.erase("scene");
  EXPECT_EQ(missing_fields(manifest, of_manifest), none_missing);
  EXPECT_TRUE(manifest.at("look").is_object() && manifest.at("expected_look").is_object());

  FieldJson lines = FieldJson::array();
  std::istringstream log(baked.err);
  for (std::string line; std::getline(log, line);) lines.push_back(FieldJson::parse(line));
  EXPECT_EQ(missing_fields(lines, page_section(page, "Log lines")), none_missing);
  EXPECT_TRUE(std::ranges::any_of(lines, [](const FieldJson& line) { return line.contains("eta"); }));

  EXPECT_EQ(missing_fields(printed_json({"verify", out, "--json"}), page_section(page, "verify")),
            none_missing);
  EXPECT_EQ(missing_fields(printed_json({"view", out, "-o", folder / "page.html", "--json"}),
                           page_section(page, "view")),
            none_missing);

  static const std::regex of_layer("^(lag|volume|volume_ratio)_(fat|bone|skin)$"), of_probe("^tip_([xyz])$");
  FieldNames columns;
  std::istringstream header(read_text(out + "/metrics.csv").substr(0, 2000));
  std::string names;
  std::getline(header, names);
  std::istringstream cells(names);
  for (std::string cell; std::getline(cells, cell, ',');)
    columns.insert(std::regex_replace(std::regex_replace(cell, of_layer, "$1_NAME"), of_probe, "NAME_$1"));
  EXPECT_GT(columns.size(), 25u);
  EXPECT_EQ(columns, columns_in_tables(page_section(page_text("formats.md"), "metrics.csv")));
}

TEST(JsonPage, NamesTheFieldsOfEachCommand) {
  const TemporaryFolder folder;
  const std::string scene = folder / "scene.toml", page = page_text("json.md");
  write_text(scene, scene_with_every_field);
  const std::string of_inspect = page_section(page, "inspect"), of_validate = page_section(page, "validate");
  EXPECT_EQ(missing_fields(printed_json({"inspect", scene, "--json"}), of_inspect), none_missing);
  const FieldJson rod = printed_json({"inspect", "rod-hang", "--json", "--model", folder / "rod.vtu"});
  EXPECT_EQ(missing_fields(rod, of_inspect), none_missing);
  EXPECT_TRUE(rod.at("step_error").is_object());

  EXPECT_EQ(missing_fields(printed_json({"devices", "--json"}), page_section(page, "devices")), none_missing);

  EXPECT_EQ(missing_fields(printed_json({"validate", "bar-hang-along", "--devices", "cpu,cpu", "--frames",
                                         "1", "--json"}),
                           of_validate),
            none_missing);
  EXPECT_EQ(missing_fields(printed_json({"validate", "rod-hang", "--converged", "--devices", "cpu",
                                         "--frames", "1", "--json"}),
                           of_validate),
            none_missing);
}

TEST(JsonPage, NamesTheFieldsOfBatchesAndTimings) {
  const TemporaryFolder folder;
  const std::string page = page_text("json.md");
  cli::SummaryRow row;
  row.job = "arm";
  row.baked = "other settings";
  cli::write_batch_summary(folder.path(), {row});
  EXPECT_EQ(
      missing_fields(FieldJson::parse(read_text(folder / "batch.json")), page_section(page, "batch.json")),
      none_missing);

  cli::BenchResults timings;
  timings.machine.gpus["vulkan:0"] = "a GPU";
  timings.triad[1] = 20.0;
  timings.copy["vulkan:0"] = 2000.0;
  timings.rows.emplace_back();
  timings.rows.back().stages["region"] = 1.0;
  cli::write_bench_json(folder / "bench.json", timings);
  EXPECT_EQ(missing_fields(FieldJson::parse(read_text(folder / "bench.json")), page_section(page, "bench")),
            none_missing);
}

// The controls: a field that the section does not name is missed, at any depth; names of the scene are not
// fields, and another section does not count.
TEST(JsonPage, AFieldWithoutItsNameIsMissed) {
  const std::string page =
      "# Page\n\n## verify\n\n| `good` | `files`: `file` |\n\n## view\n\n`error`, `probes`\n";
  const std::string of_verify = page_section(page, "verify"), of_view = page_section(page, "view");
  const auto missing = [](const std::string& text, const std::string& section) {
    return missing_fields(FieldJson::parse(text), section);
  };
  EXPECT_EQ(missing(R"({"good": true, "files": [{"file": "a"}]})", of_verify), none_missing);
  EXPECT_EQ(missing(R"({"good": true, "files": [{"made_up": "a"}]})", of_verify), FieldNames{"made_up"});
  EXPECT_EQ(missing(R"({"error": 0.1, "good": true})", of_view), FieldNames{"good"});
  EXPECT_EQ(missing(R"({"good": true})", page_section(page, "devices")), FieldNames{"good"});
  EXPECT_EQ(missing(R"({"probes": {"tip": 3}})", of_view), none_missing);
  EXPECT_EQ(missing(R"({"probes": [{"tip": 3}]})", of_view), FieldNames{"tip"});
  EXPECT_EQ(columns_in_tables("| `look_NAME`, `x` | `y` |\n`z`\n"), (FieldNames{"look_NAME", "x"}));

  const std::string whole = page_text("json.md");
  for (const char* heading : {"manifest.json", "batch.json", "inspect", "devices", "validate", "verify",
                              "view", "bench", "Log lines"})
    EXPECT_EQ(missing(R"({"made_up": 1})", page_section(whole, heading)), FieldNames{"made_up"}) << heading;
}

}  // namespace
}  // namespace fascicle::tests
