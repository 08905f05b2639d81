#include "host/cli/bench_results.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include <nlohmann/json.hpp>

#include "host/bake/bake.h"
#include "host/base/display_width.h"
#include "host/base/file.h"
#include "host/base/json_number.h"
#include "host/base/json_text.h"
#include "host/cli/exit_codes.h"
#include "host/cli/text.h"

namespace fascicle::cli {
namespace {

using Json = nlohmann::ordered_json;

double least_of(const std::vector<double>& samples) {
  return samples.empty() ? 0.0 : *std::min_element(samples.begin(), samples.end());
}

Json json_of(const std::optional<double>& value) {
  return value ? Json(*value) : Json();
}

Json json_of(const BenchRow& row) {
  return {{"solver", row.solver},
          {"device", row.device},
          {"mesh", row.mesh},
          {"vertices", row.vertices},
          {"threads", row.threads},
          {"integrator", row.integrator},
          {"passes", row.passes},
          {"ns_per_vertex_substep", row.median()},
          {"ns_least", row.least()},
          {"samples", row.samples},
          {"bytes_per_vertex_substep", json_of(row.bytes)},
          {"triad_fraction", json_of(row.triad)},
          {"peak_bytes_per_vertex", json_of(row.peak_bytes)},
          {"ns_by_stage", row.stages}};
}

// Writes all or nothing. Replaces a symbolic link rather than following it.
void write_text_file(const std::filesystem::path& path, const std::string& text) try {
  base::write_whole_beside_others(std::filesystem::absolute(path), text);
} catch (const std::system_error& error) {
  throw bake::BakeError(path.string() + ": cannot be written (" + error.code().message() +
                        "); choose another file");
}

std::string or_nothing(const std::optional<double>& value, int digits) {
  return value ? number_text(*value, digits) : "";
}

std::string padded(std::string text, std::size_t width) {
  text.append(width - std::min(width, base::display_width(text)), ' ');
  return text;
}

}  // namespace

double BenchRow::median() const {
  if (samples.empty()) return 0.0;
  std::vector<double> sorted = samples;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t half = sorted.size() / 2;
  return sorted.size() % 2 == 1 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
}

double BenchRow::least() const {
  return least_of(samples);
}

std::string key_of(const BenchRow& row) {
  return row.device + ", " + row.integrator + ", " + (row.mesh == BenchRow{}.mesh ? "" : row.mesh + ", ") +
         count_text(row.vertices) + " vertices, " + std::to_string(row.threads) +
         (row.threads == 1 ? " thread" : " threads");
}

void write_bench_json(const std::filesystem::path& file, const BenchResults& results) {
  Json object{{"machine",
               {{"processor", results.machine.processor},
                {"cores", results.machine.cores},
                {"levels", results.machine.levels},
                {"gpus", results.machine.gpus},
                {"compiler", results.machine.compiler},
                {"fascicle", results.machine.version}}},
              {"triad_gb_s", Json::object()},
              {"copy_gb_s", results.copy},
              {"results", Json::array()}};
  for (const auto& [threads, rate] : results.triad) object["triad_gb_s"][std::to_string(threads)] = rate;
  for (const BenchRow& row : results.rows) object["results"].push_back(json_of(row));
  write_text_file(file, object.dump(2) + "\n");
}

void write_bench_csv(const std::filesystem::path& file, const BenchResults& results) {
  std::string text =
      "solver,device,mesh,vertices,threads,integrator,passes,ns_per_vertex_substep,ns_least,"
      "bytes_per_vertex_substep,triad_fraction,peak_bytes_per_vertex\n";
  for (const BenchRow& row : results.rows)
    text += row.solver + "," + row.device + "," + row.mesh + "," + std::to_string(row.vertices) + "," +
            std::to_string(row.threads) + "," + row.integrator + "," + std::to_string(row.passes) + "," +
            number_text(row.median(), 6) + "," + number_text(row.least(), 6) + "," +
            or_nothing(row.bytes, 6) + "," + or_nothing(row.triad, 6) + "," + or_nothing(row.peak_bytes, 6) +
            "\n";
  write_text_file(file, text);
}

std::string bench_table(const BenchResults& results) {
  std::string text = "triad, the memory's rate:";
  for (const auto& [threads, rate] : results.triad)
    text += "  " + std::to_string(threads) + (threads == 1 ? " thread " : " threads ") +
            number_text(rate, 3) + " GB/s";
  for (const auto& [device, rate] : results.copy)
    text += "\n" + device + ", " + results.machine.gpus.at(device) + ", copies " + number_text(rate, 4) +
            " GB/s: at least " + number_text(floor_bytes / rate, 3) + " ns for " +
            number_text(floor_bytes, 3) + " bytes per vertex";
  const std::vector<std::size_t> widths{18, 11, 8, 11, 9, 9, 9, 7, 9, 10};
  const auto line = [&](const std::vector<std::string>& cells) {
    text += "\n ";
    for (std::size_t k = 0; k < cells.size(); ++k) text += " " + padded(cells[k], widths[k]);
    text.erase(text.find_last_not_of(' ') + 1);
  };
  text += "\nns per vertex and substep, or per vertex and iteration of an implicit one:";
  line({"device", "integrator", "mesh", "vertices", "threads", "median", "least", "bytes", "of triad",
        "peak bytes"});
  for (const BenchRow& row : results.rows)
    line({row.device, row.integrator, row.mesh, count_text(row.vertices), std::to_string(row.threads),
          number_text(row.median() / row.passes, 3), number_text(row.least() / row.passes, 3),
          row.bytes ? number_text(*row.bytes / row.passes, 3) : "", or_nothing(row.triad, 2),
          or_nothing(row.peak_bytes, 4)});
  for (const BenchRow& row : results.rows) {
    if (row.stages.empty()) continue;
    text += "\n  stages of " + key_of(row) + ":";
    for (const auto& [stage, time] : row.stages) text += " " + stage + " " + number_text(time, 3);
  }
  return text + "\n";
}

BenchBefore read_bench_json(const std::filesystem::path& file) {
  const std::string text = base::read_input(file, base::most_json_bytes);
  const auto refuse = [&](const std::string& why) {
    throw bake::BakeError(file.string() + ": is not a result of fascicle bench (" + why +
                          "); name a file that --json wrote");
  };
  const auto count_of = [&](const Json& entry, const char* name) {
    const auto count = base::whole_number<std::uint32_t>(entry.at(name));
    if (!count) refuse(std::string(name) + " must be a whole number below 2^32");
    return *count;
  };
  BenchBefore before;
  try {
    const Json object = Json::parse(base::shallow_json(text));
    before.processor = object.at("machine").at("processor").get<std::string>();
    for (const Json& entry : object.at("results")) {
      BenchRow row;
      row.device = entry.at("device").get<std::string>();
      row.integrator = entry.at("integrator").get<std::string>();
      row.mesh = entry.value("mesh", row.mesh);
      row.vertices = count_of(entry, "vertices");
      row.threads = count_of(entry, "threads");
      before.rows[key_of(row)] = {entry.at("ns_per_vertex_substep").get<double>(),
                                  entry.at("ns_least").get<double>()};
    }
  } catch (const Json::exception& error) {
    refuse(error.what());
  }
  return before;
}

BenchComparison compare_bench(const BenchResults& now, const BenchBefore& before) {
  BenchComparison comparison;
  for (const BenchRow& row : now.rows) {
    const auto found = before.rows.find(key_of(row));
    if (found == before.rows.end() || found->second.median <= 0.0 || found->second.least <= 0.0) continue;
    const double median = row.median() / found->second.median, least = row.least() / found->second.least;
    const char* verdict = "same";
    if (median > 1 + notable_change && least > 1 + notable_change) {
      verdict = "SLOWER";
      ++comparison.slower;
    }
    if (median < 1 - notable_change && least < 1 - notable_change) verdict = "faster";
    comparison.text += "  " + padded(verdict, 7) + key_of(row) + ": median x " + number_text(median, 3) +
                       ", least x " + number_text(least, 3) + "\n";
  }
  return comparison;
}

}  // namespace fascicle::cli
