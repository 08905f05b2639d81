// What `fascicle bench` measures, and how it is written down, read back and compared.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace fascicle::cli {

struct BenchRow {
  std::string solver;            // cpu, vulkan, bullet-clusters, bullet-links
  std::string device;            // as --devices names it; of a peer its own name
  std::string integrator;        // explicit, implicit; of a peer its own
  std::string mesh = "regular";  // or filled
  std::uint32_t vertices = 0;
  unsigned threads = 1;
  std::uint32_t passes = 1;     // over the regions, a substep: the iterations of the implicit integrator
  std::vector<double> samples;  // ns a vertex and substep, one a round
  std::optional<double> bytes;  // a vertex and substep, counted
  std::optional<double> triad;  // bytes over time, over the triad of as many threads or the device's copies
  std::optional<double> peak_bytes;  // a vertex: the process at its largest, building and stepping, less what
                                     // it held before

  std::map<std::string, double> stages;  // of a Vulkan device: ns a vertex of each, by its own clock

  double median() const;
  double least() const;
};

struct BenchMachine {
  std::string processor, compiler, version;
  unsigned cores = 0;
  std::vector<std::string> levels;          // of vector instructions
  std::map<std::string, std::string> gpus;  // names and drivers of the Vulkan devices, by label
};

struct BenchResults {
  BenchMachine machine;
  std::map<unsigned, double> triad;    // GB/s by threads
  std::map<std::string, double> copy;  // GB/s by Vulkan device, read plus written
  std::vector<BenchRow> rows;
};

// One object: machine, triad_gb_s by threads, results. Throws bake::BakeError where the file cannot be
// written or read.
void write_bench_json(const std::filesystem::path& file, const BenchResults& results);
void write_bench_csv(const std::filesystem::path& file, const BenchResults& results);
std::string bench_table(const BenchResults& results);

// Bytes a vertex and substep, by which devices are compared whatever their layout (bench/README.md).
inline constexpr double floor_bytes = 460;

// A row of another run: its median and its least time.
struct BenchTimes {
  double median = 0.0, least = 0.0;
};
struct BenchBefore {
  std::string processor;
  std::map<std::string, BenchTimes> rows;  // by key_of()
};
BenchBefore read_bench_json(const std::filesystem::path& file);
std::string key_of(const BenchRow& row);

// A run is called slower, or faster, where its median and its least time both moved by more than a tenth: on
// a machine that others use either alone moves by that much.
inline constexpr double notable_change = 0.10;
// A line for each row that both have, and how many became slower.
struct BenchComparison {
  std::string text;
  unsigned slower = 0;
};
BenchComparison compare_bench(const BenchResults& now, const BenchBefore& before);

}  // namespace fascicle::cli
