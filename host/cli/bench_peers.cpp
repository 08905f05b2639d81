#include "host/cli/bench_peers.h"

#include <charconv>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "host/base/process.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* program_name = "fascicle-bench-bullet";

fs::path program() {
  std::error_code error;
  const fs::path own = fs::read_symlink("/proc/self/exe", error);
  return own.parent_path() / program_name;
}

}  // namespace

bool has_peer_program() {
  std::error_code error;
  return fs::is_regular_file(program(), error);
}

double run_peer(const std::string& kind, const std::array<std::uint32_t, 3>& grid, std::uint32_t substeps) {
  const base::ProcessResult result =
      base::run_process(program(),
                        {kind, std::to_string(grid[0]), std::to_string(grid[1]), std::to_string(grid[2]),
                         std::to_string(substeps)},
                        {.seconds = 600.0, .bytes = std::uint64_t{16} << 30});
  if (result.end != base::ProcessEnd::exited || result.code != 0)
    throw std::runtime_error(std::string(program_name) + " " + kind + " failed: " + result.last_words);
  const std::string& text = result.last_words;
  double seconds = 0.0;
  if (std::from_chars(text.data(), text.data() + text.size(), seconds).ec != std::errc())
    throw std::runtime_error(std::string(program_name) + " " + kind + " gave no time: " + text);
  return seconds;
}

}  // namespace fascicle::cli
