#include "host/cli/openjd_template.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "host/base/file.h"
#include "host/cli/exit_codes.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;
using TemplateJson = nlohmann::ordered_json;

// Limits of the specification: https://github.com/OpenJobDescription/openjd-specifications, "Template Schemas
// [Version: 2023-09]".
constexpr std::size_t most_values = 1024;        // per task parameter
constexpr std::size_t longest_job_name = 128;    // characters
constexpr std::size_t longest_parameter = 1024;  // characters of a parameter's value
constexpr const char* written_by = "written by `fascicle batch --emit openjd`";
// A bake ends after its current frame; the specification allows 600.
constexpr int seconds_to_end = 120;

TemplateJson path_parameter(const char* name, const char* object, const char* flow, const char* description,
                            const fs::path& path) {
  if (path.string().size() > longest_parameter)
    throw UsageError("--emit openjd: " + path.string() +
                     ": is longer than the 1,024 characters of a parameter");
  return {{"name", name},     {"type", "PATH"},           {"objectType", object},
          {"dataFlow", flow}, {"default", path.string()}, {"description", description}};
}

TemplateJson amount(const char* name, std::uint64_t least) {
  return {{"name", name}, {"min", least}};
}

TemplateJson action(std::vector<std::string> arguments) {
  return {{"actions",
           {{"onRun",
             {{"command", "{{Param.Fascicle}}"},
              {"args", std::move(arguments)},
              {"cancelation",
               {{"mode", "NOTIFY_THEN_TERMINATE"}, {"notifyPeriodInSeconds", seconds_to_end}}}}}}}};
}

TemplateJson bake_step(const FarmBatch& batch, const std::string& name, std::size_t first, std::size_t last) {
  TemplateJson amounts = TemplateJson::array({amount("amount.worker.vcpu", std::max(1U, batch.threads)),
                                              amount("amount.worker.memory", batch.memory >> 20)});
  if (batch.is_gpu) amounts.push_back(amount("amount.worker.gpu", 1));
  TemplateJson range = TemplateJson::array();
  for (std::size_t k = first; k < last; ++k) {
    std::string jobs;
    for (const std::string& job : batch.tasks[k]) jobs += (jobs.empty() ? "" : ",") + job;
    if (jobs.size() > longest_parameter)
      throw UsageError(
          "--group: the names of a task's jobs are longer than the 1,024 characters of a parameter; "
          "use a smaller --group");
    range.push_back(jobs);
  }
  const TemplateJson linux_host{{"name", "attr.worker.os.family"}, {"anyOf", TemplateJson::array({"linux"})}};
  const TemplateJson job{{"name", "Job"}, {"type", "STRING"}, {"range", range}};
  return {{"name", name},
          {"hostRequirements", {{"amounts", amounts}, {"attributes", TemplateJson::array({linux_host})}}},
          {"parameterSpace", {{"taskParameterDefinitions", TemplateJson::array({job})}}},
          {"script", action({"batch", "{{Param.Jobs}}", "--job", "{{Task.Param.Job}}", "--output",
                             "{{Param.Output}}", "--device", "{{Param.Device}}", "--threads",
                             "{{Param.Threads}}", "--at-once", "1", "--resume", "--log-format", "openjd"})}};
}

}  // namespace

void refuse_others_template(const fs::path& file) {
  if (!fs::exists(fs::symlink_status(file))) return;
  if (fs::is_regular_file(file) &&
      base::read_input(file, base::most_json_bytes).find(written_by) != std::string::npos)
    return;
  throw UsageError(file.string() +
                   ": --emit would replace this file, which it did not write; choose another -o");
}

void write_openjd_template(const fs::path& file, const FarmBatch& batch) {
  const std::string extension = base::lower_extension(file);
  const bool is_yaml = extension == ".yaml" || extension == ".yml";
  if (!is_yaml && extension != ".json")
    throw UsageError("-o: " + file.string() + ": a template ends in .json or .yaml");
  std::string name = "fascicle " + batch.list.stem().string();
  name.resize(std::min(name.size(), longest_job_name));
  // The name is a format string too.
  for (std::size_t at; (at = name.find("{{")) != std::string::npos;) name.erase(at, 1);

  TemplateJson steps = TemplateJson::array(), bakes = TemplateJson::array();
  for (std::size_t first = 0; first < batch.tasks.size(); first += most_values) {
    const std::string step = first == 0 ? "bake" : "bake-" + std::to_string(first / most_values + 1);
    steps.push_back(bake_step(batch, step, first, std::min(first + most_values, batch.tasks.size())));
    bakes.push_back({{"dependsOn", step}});
  }
  steps.push_back({{"name", "merge"},
                   {"dependencies", bakes},
                   {"script", action({"batch", "status", "{{Param.Jobs}}", "--output", "{{Param.Output}}",
                                      "--merge", "--log-format", "openjd"})}});

  const TemplateJson whole{
      {"specificationVersion", "jobtemplate-2023-09"},
      {"name", name},
      {"description", "Bakes of fascicle, " + std::string(written_by) +
                          ". A task that was canceled or failed continues when it is run again."},
      {"parameterDefinitions",
       TemplateJson::array(
           {path_parameter("Fascicle", "FILE", "NONE", "The program, on the workers", batch.program),
            path_parameter("Jobs", "FILE", "IN", "The list of jobs", batch.list),
            path_parameter("Output", "DIRECTORY", "OUT", "The folder of the bakes", batch.jobs.output),
            {{"name", "Device"},
             {"type", "STRING"},
             {"default", batch.device},
             {"description", "As for fascicle's --device; all give the same bits"}},
            {{"name", "Threads"},
             {"type", "INT"},
             {"default", batch.threads},
             {"minValue", 1},
             {"maxValue", 1024},
             {"description", "For a bake on a CPU"}}})},
      {"steps", steps}};
  const std::string head = is_yaml
                               ? "# An Open Job Description template of bakes, " + std::string(written_by) +
                                     ". It is\n# JSON, which is also valid YAML 1.2.\n"
                               : "";
  base::write_whole_beside_others(
      file, head + whole.dump(2, ' ', false, TemplateJson::error_handler_t::replace) + "\n");
}

}  // namespace fascicle::cli
