// bench/plot.py draws every committed result: a curve per device, a point per single-threaded row.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

std::string content_of_plot(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

int draw_plot(const fs::path& results, const fs::path& plot, const std::string& options) {
  const fs::path program = fs::path(FASCICLE_SOURCE_DIR) / "bench/plot.py";
  return std::system(("python3 -B '" + program.string() + "' '" + results.string() + "' '" + plot.string() +
                      "' " + options + " 2> /dev/null")
                         .c_str());
}

TEST(BenchPlot, HasACurveForEachDevice) {
  const fs::path plot = fs::temp_directory_path() / ("fascicle-plot-" + std::to_string(getpid()) + ".svg");
  std::size_t drawn = 0;
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(FASCICLE_SOURCE_DIR) / "bench/results")) {
    if (entry.path().extension() != ".json") continue;
    ASSERT_EQ(draw_plot(entry.path(), plot, ""), 0) << entry.path();
    const std::string svg = content_of_plot(plot);
    std::set<std::string> devices;
    std::size_t rows = 0;
    std::ifstream in(entry.path());
    const nlohmann::json results = nlohmann::json::parse(in);
    for (const nlohmann::json& row : results["results"]) {
      const bool is_peer = row["solver"].get<std::string>().rfind("bullet", 0) == 0;
      if (row.value("mesh", "regular") != "regular") continue;
      if (row["threads"] != 1 || (row["integrator"] != "explicit" && !is_peer)) continue;
      devices.insert(row["device"].get<std::string>());
      ++rows;
    }
    EXPECT_EQ(count_of(svg, "<polyline"), devices.size()) << entry.path();
    EXPECT_EQ(count_of(svg, "<circle"), rows) << entry.path();
    for (const std::string& device : devices) EXPECT_EQ(count_of(svg, ">" + device + " "), 1u) << device;
    ++drawn;
    // Without results it writes no file.
    fs::remove(plot);
    EXPECT_NE(draw_plot(entry.path(), plot, "--threads 77"), 0);
    EXPECT_FALSE(fs::exists(plot));
  }
  EXPECT_GT(drawn, 0u);
  fs::remove(plot);
}

}  // namespace
}  // namespace fascicle::tests
