#include "host/cli/validate_page.h"

#include "host/base/version.h"
#include "host/cli/text.h"
#include "host/page/page.h"
#include "host/page/plot.h"

namespace fascicle::cli {
namespace {

using page::Tone;
using page::Writer;
using Table = std::vector<std::vector<std::string>>;

std::string footer() {
  return std::string("Written by fascicle ") + base::fascicle_version + ", solver version " +
         std::to_string(base::solver_version) + ". This page is self-contained and loads nothing.";
}

std::string apart_text(double metres) {
  return number_text(metres * 1e3) + " mm";
}

void write_devices(Writer& page, const std::vector<ChosenDevice>& devices) {
  page::open_section(page, "devices", "Devices");
  Table table{{"Device", "Name", "Driver", "Exact"}};
  for (const ChosenDevice& device : devices)
    table.push_back({device.label(), device.description().name, device.description().driver,
                     device.description().exact ? "yes" : "no: " + device.why_not_exact()});
  page::table(page, table, 4);
  page.close();
}

// Describes where the first difference is.
std::string place_of(const model::Difference& difference) {
  return "frame " + std::to_string(difference.where.frame) + ", substep " +
         std::to_string(difference.where.substep) + ", stage " + model::name_of(difference.where.stage) +
         ", item " + std::to_string(difference.item) + ", component " + std::to_string(difference.component) +
         ": " + float_text(difference.a) + " (" + bits_text(difference.a) + ") and " +
         float_text(difference.b) + " (" + bits_text(difference.b) + "), " + std::to_string(difference.ulp) +
         " ULP apart";
}

std::string finding_of(const Comparison& comparison) {
  if (!comparison.exact)
    return "at most " + apart_text(comparison.distance.largest) + " apart, " +
           number_text(comparison.relative, 2) + " of the body's extent";
  if (comparison.holds()) return "every bit is the same";
  if (comparison.difference) return "first difference: " + place_of(*comparison.difference);
  if (comparison.hashes.first_different_frame)
    return "without probes positions differ from frame " +
           std::to_string(*comparison.hashes.first_different_frame);
  return "the states before frame 1 differ";
}

void write_comparisons(Writer& page, const Validation& validation) {
  if (validation.comparisons.empty()) return;
  page::open_section(page, "comparisons", "Device against device");
  Table table{{"First", "Second", "Compared by", "Result", "Finding", "Values compared"}};
  for (const Comparison& comparison : validation.comparisons)
    table.push_back({comparison.a, comparison.b, comparison.exact ? "bits" : "tolerance",
                     comparison.holds() ? "holds" : "DIFFERENT", finding_of(comparison),
                     comparison.exact ? count_text(comparison.values) : "-"});
  page::table(page, table, 5);
  page.close();
}

void write_oracle(Writer& page, const Validation& validation) {
  if (validation.oracle.empty()) return;
  page::open_section(page, "oracle", "Against the solver in double precision");
  Table table{{"Device", "Result", "Largest distance", "RMS", "Frame", "Of the body's extent", "Bound"}};
  std::vector<page::Bar> bars;
  for (const OracleComparison& comparison : validation.oracle) {
    table.push_back({comparison.device, comparison.holds() ? "holds" : "BEYOND THE BOUND",
                     apart_text(comparison.distance.largest), apart_text(comparison.distance.rms),
                     std::to_string(comparison.distance.frame), number_text(comparison.relative, 2),
                     number_text(oracle_bound, 2)});
    bars.push_back({comparison.device, number_text(comparison.relative, 2), comparison.relative});
  }
  page::bars(page, "Largest distance, of the body's extent; the line is the bound", bars, oracle_bound);
  page::table(page, table, 2, "Over " + count_text(validation.oracle_frames) + " frames");
  page.close();
}

}  // namespace

std::string validation_page(const scene::Scene& scene, const Built& built,
                            const std::vector<ChosenDevice>& devices, const Validation& validation) {
  const bool holds = validation.holds();
  Writer page = page::begin(scene.name, "Validation: devices against each other and against double precision",
                            holds ? "holds" : "differs", holds ? Tone::good : Tone::bad);
  page::facts(page, {{"Frames", count_text(validation.frames), Tone::neutral,
                      std::to_string(built.steps.substeps) + " substeps each"},
                     {"Devices", std::to_string(devices.size()), Tone::neutral, ""},
                     {"Vertices", count_text(built.model.vertex_count), Tone::neutral, ""},
                     {"Result", holds ? "holds" : "differs", holds ? Tone::good : Tone::bad, ""}});
  write_devices(page, devices);
  write_comparisons(page, validation);
  write_oracle(page, validation);
  return page::finish(std::move(page), footer());
}

std::string convergence_page(const scene::Scene& scene, const Convergence& convergence) {
  Writer page = page::begin(scene.name, "Validation: qualities against many more substeps");
  page::facts(page, {{"Frames", count_text(convergence.frames), Tone::neutral, ""},
                     {"Device", convergence.device, Tone::neutral, ""},
                     {"Reference", std::to_string(convergence.reference.substeps) + " substeps",
                      Tone::neutral, std::to_string(convergence.reference.iterations) + " iterations each"}});
  page::open_section(page, "qualities", "Qualities");
  Table table{{"Quality", "Substeps", "Iterations", "RMS", "Largest", "Frame", "Solver"}};
  std::vector<page::Bar> bars;
  for (const SteppedSkin& skin : convergence.skins) {
    table.push_back({skin.quality + (skin.is_scenes ? " (the scene's)" : ""),
                     std::to_string(skin.steps.substeps), std::to_string(skin.steps.iterations),
                     apart_text(skin.rms), apart_text(skin.largest), std::to_string(skin.frame),
                     duration_text(skin.seconds)});
    bars.push_back({skin.quality, apart_text(skin.rms), skin.rms});
  }
  page::bars(page, "Distance of the skin from the reference, RMS", bars);
  page::table(page, table, 1);
  page.close();
  return page::finish(std::move(page), footer());
}

}  // namespace fascicle::cli
