// Results of `fascicle bench`: written, read back and compared.
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
  std::string device;            // as in --devices; for other programs, their own name
  std::string integrator;        // explicit, implicit; for other programs, their own
  std::string mesh = "regular";  // or filled
  std::uint32_t vertices = 0;
  unsigned threads = 1;
  std::uint32_t passes = 1;     // over the regions, per substep: the implicit integrator's iterations
  std::vector<double> samples;  // ns per vertex and substep, one per round
  std::optional<double> bytes;  // per vertex and substep, counted
  std::optional<double> triad;  // bytes over time, relative to the triad of as many threads or the copy rate
  std::optional<double> peak_bytes;  // per vertex: peak of building and stepping, less the size before

  std::map<std::string, double> stages;  // on a Vulkan device: ns per vertex for each, by its own clock

  double median() const;
  double least() const;
};

struct BenchMachine {
  std::string processor, compiler, version;
  unsigned cores = 0;
  std::vector<std::string> levels;          // SIMD levels
  std::map<std::string, std::string> gpus;  // names and drivers of the Vulkan devices, by label
};

struct BenchResults {
  BenchMachine machine;
  std::map<unsigned, double> triad;    // GB/s by threads
  std::map<std::string, double> copy;  // GB/s by Vulkan device, read plus written
  std::vector<BenchRow> rows;
};

// One object: machine, triad_gb_s by threads, results. Throws bake::BakeError if the file cannot be written
// or read.
void write_bench_json(const std::filesystem::path& file, const BenchResults& results);
void write_bench_csv(const std::filesystem::path& file, const BenchResults& results);
std::string bench_table(const BenchResults& results);

// Bytes per vertex and substep; the layout-independent basis for comparing devices (bench/README.md).
inline constexpr double floor_bytes = 460;

// A row of another run: its median and minimum time.
struct BenchTimes {
  double median = 0.0, least = 0.0;
};
struct BenchBefore {
  std::string processor;
  std::map<std::string, BenchTimes> rows;  // by key_of()
};
BenchBefore read_bench_json(const std::filesystem::path& file);
std::string key_of(const BenchRow& row);

// A row counts as slower or faster only if both its median and its minimum moved by more than a tenth. On a
// shared machine, either one alone moves that much.
inline constexpr double notable_change = 0.10;
// A line for each row that both runs have, and the number of slower ones.
struct BenchComparison {
  std::string text;
  unsigned slower = 0;
};
BenchComparison compare_bench(const BenchResults& now, const BenchBefore& before);

}  // namespace fascicle::cli
