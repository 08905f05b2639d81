#include <fstream>
#include <iterator>

#include "host/base/helper_program.h"
#include "host/cli/batch_plan.h"
#include "host/cli/batch_summary.h"
#include "host/cli/bench_results.h"
#include "host/cli/job_record.h"
#include "host/scene/jobs.h"
#include "tests/fuzz/seeds.h"

namespace fascicle::fuzz {
namespace {

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

}  // namespace

void add_cli_seeds(std::vector<Seed>& seeds) {
  seeds.push_back(
      {"metrics", "two", "frame,time,volume,tip_x\n0,0,0.0625,1e-3\n1,0.016666666666666666,0.06,nan\n"});
  seeds.push_back({"metrics", "look",
                   "frame,kinetic_energy,lag_fat,inverted,look,worst_joint,look_stretch\n"
                   "0,1e-3,0.01,2,0.2,\"upper, left\",0.2\n1,2e-3,0.02,3,1.5,hand,1.5\n"});
  seeds.push_back({"metrics", "quoted", "frame,\"a \"\"name\"\", of two\"\n0,1\n"});
  const base::TemporaryFolder folder;
  cli::write_job_record(folder.path(), "job",
                        {.host = "node7",
                         .process = 42,
                         .device = "cpu",
                         .exit_status = 3,
                         .error = "bad",
                         .warnings = {"a", "b"}});
  seeds.push_back({"record", "ended", content_of(cli::job_record_file(folder.path(), "job"))});
  cli::SummaryRow row;
  row.job = "walk";
  row.folder = folder.path() / "walk";
  row.set = {"layers.fat.alpha=0.5"};
  row.formats = {"pc2"};
  row.exit_status = 0;
  cli::SummaryRow other = row;
  other.exit_status = std::nullopt;
  cli::write_batch_summary(folder.path(), {row, other});
  seeds.push_back({"batch", "two", content_of(folder.path() / scene::batch_summary)});
  scene::Job walk{}, arm{};
  walk.name = walk.clip = "walk";
  walk.scene = "man.glb";
  arm.name = arm.scene = "arm";
  arm.set = row.set;
  arm.formats = row.formats;
  scene::Jobs jobs;
  jobs.output = "out";
  jobs.jobs = {walk, arm};
  cli::write_plan(folder.path(), "jobs.toml", jobs);
  seeds.push_back({"plan", "two", content_of(folder.path() / cli::plan_file)});
  cli::BenchRow on_cpu;
  on_cpu.solver = on_cpu.device = "cpu";
  on_cpu.integrator = "explicit";
  on_cpu.vertices = 19456;
  on_cpu.samples = {31.5, 30.25};
  cli::BenchRow on_vulkan = on_cpu;
  on_vulkan.solver = on_vulkan.device = "vulkan";
  on_vulkan.mesh = "filled";
  on_vulkan.stages = {{"region", 12.5}};
  cli::BenchResults results;
  results.machine.processor = "a processor";
  results.triad = {{1, 9.5}};
  results.rows = {on_cpu, on_vulkan};
  cli::write_bench_json(folder.path() / "bench.json", results);
  seeds.push_back({"results", "two", content_of(folder.path() / "bench.json")});
}

}  // namespace fascicle::fuzz
