// A batch as a job template of Open Job Description, checked against the rules of the specification, and the
// lines that a farm reads while a task runs.
//
// The rules are those of "Template Schemas [Version: 2023-09]" and "How Jobs Are Run",
// https://github.com/OpenJobDescription/openjd-specifications/wiki, to the extent that our template uses
// them: keys, lengths, characters, and which names may be referenced where.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

using OpenJson = nlohmann::json;
namespace fs = std::filesystem;

// Finds the violations of a template; every rule names its section.
class OpenJdRules {
 public:
  static std::vector<std::string> faults_of(const OpenJson& whole) {
    OpenJdRules rules;
    try {
      rules.hold_template(whole);
    } catch (const OpenJson::exception& error) {
      rules.faults_.push_back(error.what());
    }
    return rules.faults_;
  }

 private:
  void hold(bool holds, const std::string& rule) {
    if (!holds) faults_.push_back(rule);
  }
  void hold_keys(const OpenJson& object, const std::set<std::string>& required,
                 const std::set<std::string>& optional, const std::string& where) {
    hold(object.is_object(), where + ": is no object");
    for (const std::string& key : required) hold(object.contains(key), where + ": lacks " + key);
    for (const auto& [key, value] : object.items())
      hold(required.contains(key) || optional.contains(key), where + ": has no key " + key);
  }
  // Text of limited length without control characters. It counts bytes, which is stricter than characters.
  void hold_text(const OpenJson& text, std::size_t least, std::size_t most, const std::string& where) {
    hold(text.is_string(), where + ": is no text");
    const std::string value = text.get<std::string>();
    hold(value.size() >= least && value.size() <= most, where + ": is too short or too long");
    for (const char c : value) hold(static_cast<unsigned char>(c) >= 0x20 && c != 0x7f, where + ": Cc");
  }
  void hold_identifier(const OpenJson& text, const std::string& where) {  // 7.1
    static const std::regex identifier("[A-Za-z_][A-Za-z0-9_]{0,63}");
    hold(text.is_string() && std::regex_match(text.get<std::string>(), identifier), where + ": 7.1");
  }
  // 7.3: names in double braces are dotted names from `scope`.
  void hold_format_string(const std::string& text, const std::set<std::string>& scope,
                          const std::string& where) {
    std::size_t at = 0;
    while ((at = text.find("{{", at)) != std::string::npos) {
      const std::size_t end = text.find("}}", at);
      hold(end != std::string::npos, where + ": braces that do not end");
      if (end == std::string::npos) return;
      std::string name = text.substr(at + 2, end - at - 2);
      name.erase(0, name.find_first_not_of(' '));
      name.erase(name.find_last_not_of(' ') + 1);
      hold(scope.contains(name), where + ": nothing is called " + name);
      at = end;
    }
  }

  void hold_template(const OpenJson& whole) {  // 1.1
    hold_keys(whole, {"specificationVersion", "name", "steps"},
              {"$schema", "extensions", "description", "parameterDefinitions", "jobEnvironments"},
              "template");
    hold(whole.at("specificationVersion") == "jobtemplate-2023-09", "1.1: specificationVersion");
    hold_text(whole.at("name"), 1, 128, "1.1.1");
    hold_format_string(whole.at("name"), {}, "1.1.1");
    if (whole.contains("description")) hold_text(whole.at("description"), 1, 2048, "7.2");
    if (whole.contains("parameterDefinitions")) {
      const OpenJson& parameters = whole.at("parameterDefinitions");
      hold(parameters.size() >= 1 && parameters.size() <= 50, "1.1: parameterDefinitions");
      for (const OpenJson& parameter : parameters) hold_parameter(parameter);
    }
    hold(!whole.at("steps").empty(), "1.1: steps");
    std::set<std::string> before;
    for (const OpenJson& step : whole.at("steps")) {
      hold_step(step, before);
      hold(before.insert(step.at("name")).second, "3: two steps of one name");
    }
  }

  void hold_parameter(const OpenJson& parameter) {  // 2.1, 2.2, 2.3
    const std::string type = parameter.at("type");
    std::set<std::string> more{"description", "default", "allowedValues", "userInterface"};
    if (type == "STRING" || type == "PATH") more.insert({"minLength", "maxLength"});
    if (type == "PATH") more.insert({"objectType", "dataFlow"});
    if (type == "INT") more.insert({"minValue", "maxValue"});
    hold(type == "STRING" || type == "PATH" || type == "INT", "2: type " + type);
    hold_keys(parameter, {"name", "type"}, more, "2");
    hold_identifier(parameter.at("name"), "2");
    if (parameter.contains("description")) hold_text(parameter.at("description"), 1, 2048, "7.2");
    if (type == "INT")
      hold(parameter.at("default").is_number_integer() && parameter.at("default") >= parameter.at("minValue"),
           "2.3: default");
    else
      hold_text(parameter.at("default"), 0, 1024, "2.5");
    static const std::set<std::string> objects{"FILE", "DIRECTORY"}, flows{"NONE", "IN", "OUT", "INOUT"};
    if (parameter.contains("objectType"))
      hold(objects.contains(parameter.at("objectType")), "2.2: objectType");
    if (parameter.contains("dataFlow")) hold(flows.contains(parameter.at("dataFlow")), "2.2: dataFlow");
    const std::string name = parameter.at("name");
    for (const char* scope : {"Param.", "RawParam."}) in_a_script_.insert(scope + name);
  }

  void hold_step(const OpenJson& step, const std::set<std::string>& before) {  // 3
    hold_keys(step, {"name", "script"},
              {"description", "dependencies", "stepEnvironments", "hostRequirements", "parameterSpace"}, "3");
    hold_text(step.at("name"), 1, 64, "3.1");
    if (step.contains("dependencies")) {
      hold(!step.at("dependencies").empty(), "3: dependencies");
      for (const OpenJson& one : step.at("dependencies")) {
        hold_keys(one, {"dependsOn"}, {}, "3.2");
        hold(before.contains(one.at("dependsOn")), "3.2: dependsOn");
      }
    }
    if (step.contains("hostRequirements")) hold_requirements(step.at("hostRequirements"));
    std::set<std::string> scope = in_a_script_;
    if (step.contains("parameterSpace")) {
      const OpenJson& space = step.at("parameterSpace");
      hold_keys(space, {"taskParameterDefinitions"}, {"combination"}, "3.4");
      const OpenJson& definitions = space.at("taskParameterDefinitions");
      hold(definitions.size() >= 1 && definitions.size() <= 16, "3.4: taskParameterDefinitions");
      for (const OpenJson& one : definitions) {
        hold_keys(one, {"name", "type", "range"}, {}, "3.4.1.3");
        hold_identifier(one.at("name"), "3.4.1.3");
        hold(one.at("type") == "STRING", "3.4.1.3: type");
        hold(one.at("range").size() >= 1 && one.at("range").size() <= 1024, "3.4.1.3: range");
        for (const OpenJson& value : one.at("range")) {
          hold_text(value, 1, 1024, "3.4.2");
          hold_format_string(value, {}, "3.4.2");
        }
        scope.insert("Task.Param." + one.at("name").get<std::string>());
      }
    }
    hold_keys(step.at("script"), {"actions"}, {"embeddedFiles"}, "3.5");
    hold_keys(step.at("script").at("actions"), {"onRun"}, {}, "3.5.1");
    const OpenJson& action = step.at("script").at("actions").at("onRun");
    hold_keys(action, {"command"}, {"args", "timeout", "cancelation"}, "5");
    hold_text(action.at("command"), 1, std::string::npos, "5.1");
    hold_format_string(action.at("command"), scope, "5.1");
    for (const OpenJson& argument : action.at("args")) {
      hold_text(argument, 0, std::string::npos, "5.2");
      hold_format_string(argument, scope, "5.2");
    }
    const OpenJson& end = action.at("cancelation");
    hold_keys(end, {"mode"}, {"notifyPeriodInSeconds"}, "5.3.2");
    hold(end.at("mode") == "NOTIFY_THEN_TERMINATE", "5.3.2: mode");
    hold(end.at("notifyPeriodInSeconds") >= 1 && end.at("notifyPeriodInSeconds") <= 600, "5.3.2: seconds");
  }

  void hold_requirements(const OpenJson& requirements) {  // 3.3
    static const std::regex amount_name("amount(\\.[A-Za-z_][A-Za-z0-9_]*)+");
    static const std::regex attribute_name("attr(\\.[A-Za-z_][A-Za-z0-9_]*)+");
    static const std::regex attribute_value("[A-Za-z_][A-Za-z0-9_-]{0,99}");
    hold_keys(requirements, {}, {"amounts", "attributes"}, "3.3");
    hold(!requirements.empty(), "3.3: is empty");
    std::set<std::string> names;
    for (const OpenJson& amount : requirements.at("amounts")) {
      hold_keys(amount, {"name", "min"}, {"max"}, "3.3.1");
      hold(std::regex_match(amount.at("name").get<std::string>(), amount_name), "3.3.1.1");
      hold(amount.at("min").is_number() && amount.at("min") >= 0, "3.3.1: min");
      hold(names.insert(amount.at("name")).second, "3.3: two of one name");
    }
    for (const OpenJson& attribute : requirements.at("attributes")) {
      hold_keys(attribute, {"name"}, {"anyOf", "allOf"}, "3.3.2");
      hold(std::regex_match(attribute.at("name").get<std::string>(), attribute_name), "3.3.2.1");
      for (const OpenJson& value : attribute.at("anyOf"))
        hold(std::regex_match(value.get<std::string>(), attribute_value), "3.3.2.2");
    }
  }

  std::vector<std::string> faults_;
  std::set<std::string> in_a_script_;
};

std::string list_of_bars(const fs::path& home) {
  fs::create_directories(home);
  write_text(home / "jobs.toml", "output = \"" + (home / "out").string() +
                                     "\"\n[job.bar]\nscene = \"bar-hang-none\"\nset = [\"scene.end=0.2\"]\n"
                                     "[job.bar.vary]\n\"layers.body.alpha\" = [0.4, 0.6]\n");
  return (home / "jobs.toml").string();
}

OpenJson template_of(const TemporaryFolder& folder, const std::string& name,
                     const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"batch",  list_of_bars(folder.path() / "a farm's {{Param.Jobs}}"),
                                     "--emit", "openjd",
                                     "-o",     folder / name};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const Outcome outcome = fascicle(arguments);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  std::string text = read_text(folder / name);
  while (text.starts_with("#")) text.erase(0, text.find('\n') + 1);
  return OpenJson::parse(text);
}

TEST(OpenJd, TheTemplateKeepsTheRules) {
  const TemporaryFolder folder;
  const OpenJson whole = template_of(folder, "template.json");
  for (const std::string& fault : OpenJdRules::faults_of(whole))
    ADD_FAILURE() << fault << "\n" << whole.dump(2);
  EXPECT_EQ(whole.at("steps").at(0).at("parameterSpace").at("taskParameterDefinitions").at(0).at("range"),
            OpenJson({"bar-0.4", "bar-0.6"}));
  EXPECT_EQ(template_of(folder, "template.yaml"), whole);
  const OpenJson on_gpu = template_of(folder, "gpu.json", {"--device", "vulkan"});
  EXPECT_TRUE(OpenJdRules::faults_of(on_gpu).empty());
  EXPECT_TRUE(contains(on_gpu.dump(), "amount.worker.gpu"));
}

// The controls: each violation is detected.
TEST(OpenJd, WhatBreaksARuleIsSeen) {
  const TemporaryFolder folder;
  const OpenJson whole = template_of(folder, "template.json");
  const auto sees = [&](const std::string& pointer, const OpenJson& value) {
    OpenJson bad = whole;
    bad[OpenJson::json_pointer(pointer)] = value;
    EXPECT_FALSE(OpenJdRules::faults_of(bad).empty()) << pointer << " " << value;
  };
  sees("/specificationVersion", "jobtemplate-2024-01");
  sees("/name", std::string(129, 'x'));
  sees("/name", "two\nlines");
  sees("/extra", 1);
  sees("/parameterDefinitions/0/name", "a-b");
  sees("/parameterDefinitions/0/objectType", "FOLDER");
  sees("/parameterDefinitions/0/default", std::string(1025, 'x'));
  sees("/parameterDefinitions/4/default", 0);
  sees("/steps/0/name", std::string(65, 'x'));
  sees("/steps/1/name", "bake");
  sees("/steps/1/dependencies/0/dependsOn", "nothing");
  sees("/steps/0/hostRequirements/amounts/0/name", "worker.vcpu");
  sees("/steps/0/hostRequirements/amounts/1/name", "amount.worker.vcpu");
  sees("/steps/0/parameterSpace/taskParameterDefinitions/0/range", OpenJson::array());
  sees("/steps/0/parameterSpace/taskParameterDefinitions/0/range/0", "{{Param.Jobs}}");
  sees("/steps/1/script/actions/onRun/args/2", "{{Task.Param.Job}}");
  sees("/steps/0/script/actions/onRun/args/2", "{{Param.Jobs");
  sees("/steps/0/script/actions/onRun/cancelation/notifyPeriodInSeconds", 601);
  sees("/steps/0/script/actions/onRun/cancelation/mode", "TERMINATE_NOW");
}

// The template's command for a value of its parameter, as a farm runs it.
std::vector<std::string> command_of_step(const OpenJson& whole, std::size_t step, const std::string& job) {
  std::vector<std::string> command;
  for (std::string word : whole.at("steps").at(step).at("script").at("actions").at("onRun").at("args")) {
    for (const OpenJson& parameter : whole.at("parameterDefinitions"))
      if (word == "{{Param." + parameter.at("name").get<std::string>() + "}}") {
        const OpenJson& value = parameter.at("default");
        word = value.is_string() ? value.get<std::string>() : value.dump();
        break;
      }
    if (word == "{{Task.Param.Job}}") word = job;
    command.push_back(word);
  }
  return command;
}

TEST(OpenJd, TasksBakeAndSayHowFarTheyAre) {
  const TemporaryFolder folder;
  const OpenJson whole = template_of(folder, "template.json");
  for (const char* job : {"bar-0.4", "bar-0.6"}) {
    const Outcome outcome = fascicle(command_of_step(whole, 0, job));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "openjd_progress: 100\n")) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "openjd_status: ")) << outcome.err;
    EXPECT_FALSE(contains(outcome.err, "openjd_fail")) << outcome.err;
  }
  const Outcome merged = fascicle(command_of_step(whole, 1, ""));
  EXPECT_EQ(merged.status, 0) << merged.out << merged.err;
  EXPECT_TRUE(fs::exists(folder.path() / "a farm's {{Param.Jobs}}/out/batch.json"));
}

TEST(OpenJd, ReplacesNoFileThatIsNotItsOwn) {
  const TemporaryFolder folder;
  write_text(folder / "jobs.toml", "[job.bar]\nscene = \"bar-hang-none\"\nset = [\"scene.end=0.2\"]\n");
  for (const char* name : {"template.json", "template.yaml"}) {
    const std::vector<std::string> command{"batch", folder / "jobs.toml", "--emit", "openjd",
                                           "-o",    folder / name};
    write_text(folder / name, "{}");
    const Outcome refused = fascicle(command);
    EXPECT_EQ(refused.status, 2) << refused.err;
    EXPECT_TRUE(contains(refused.err, std::string(name) + ": --emit would replace")) << refused.err;
    EXPECT_EQ(read_text(folder / name), "{}");
    fs::remove(folder / name);
    EXPECT_EQ(fascicle(command).status, 0);
    EXPECT_EQ(fascicle(command).status, 0) << "its own";
  }
}

// A task begins in a folder that the farm chooses.
TEST(OpenJd, RefusesFilesThatATaskWouldNotFind) {
  const TemporaryFolder folder;
  const std::string mine = std::string(FASCICLE_SOURCE_DIR) + "/scenes/bar-hang-none.toml";
  for (const char* name : {"list", "work"}) fs::create_directory(folder.path() / name);
  write_text(
      folder / "list/jobs.toml",
      "output = \"" + (folder / "out") + "\"\n[job.bar]\nscene = \"mine.toml\"\nset = [\"scene.end=0.2\"]\n");
  fs::copy_file(mine, folder / "work/mine.toml");
  const auto run_from = [&](const std::string& here, const std::vector<std::string>& arguments) {
    std::string command =
        "cd '" + here + "' && FASCICLE_CACHE_DIR='" + (folder / "cache") + "' '" + FASCICLE_PROGRAM + "'";
    for (const std::string& word : arguments) command += " '" + word + "'";
    const int status = std::system((command + " > '" + (folder / "said") + "' 2>&1").c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  const std::string work = folder / "work";
  const std::vector<std::string> emit{"batch", "../list/jobs.toml", "--emit", "openjd",
                                      "-o",    "../template.json"};
  EXPECT_EQ(run_from(work, emit), 3);
  const std::string said = read_text(folder / "said");
  EXPECT_TRUE(contains(said, "job.bar: mine.toml: was found from the current folder")) << said;
  EXPECT_FALSE(fs::exists(folder / "template.json"));
  // Slurm's script returns to the folder.
  EXPECT_EQ(run_from(work, {"batch", "../list/jobs.toml", "--emit", "slurm", "-o", "../job"}), 0)
      << read_text(folder / "said");
  EXPECT_TRUE(contains(read_text(folder / "job/array.sbatch"), "/work' || exit 1\n"));

  fs::copy_file(mine, folder / "list/mine.toml");
  ASSERT_EQ(run_from(work, emit), 0) << read_text(folder / "said");
  const OpenJson whole = OpenJson::parse(read_text(folder / "template.json"));
  EXPECT_EQ(run_from("/", command_of_step(whole, 0, "bar")), 0) << read_text(folder / "said");
  EXPECT_TRUE(fs::exists(folder / "out/bar/manifest.json"));
}

TEST(OpenJd, ABakeSaysItsShareAndWhyItFailed) {
  const TemporaryFolder folder;
  const Outcome outcome =
      fascicle({"bake", "bar-hang-none", "--end", "0.2", "-o", folder / "out", "--log-format", "openjd"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  static const std::regex progress("(^|\n)openjd_progress: ([0-9.]+)\n");
  double last = -1.0;
  for (std::sregex_iterator found(outcome.err.begin(), outcome.err.end(), progress), end; found != end;
       ++found) {
    const double share = std::stod(found->str(2));
    EXPECT_GE(share, last);
    EXPECT_LE(share, 100.0);
    last = share;
  }
  EXPECT_EQ(last, 100.0) << outcome.err;
  const Outcome failed = fascicle({"bake", "bar-hang-nothing", "--log-format", "openjd"});
  EXPECT_EQ(failed.status, 3);
  EXPECT_TRUE(failed.err.starts_with("openjd_fail: ")) << failed.err;
  const Outcome unknown = fascicle({"bake", "--wrong", "--log-format=openjd"});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_TRUE(unknown.err.starts_with("openjd_fail: ")) << unknown.err;
}

// A cancelled task first gets SIGTERM. It ends its frame well within the template's grace period and resumes
// when it is run again.
TEST(OpenJd, ACanceledTaskGoesOn) {
  const TemporaryFolder folder;
  const std::string list = list_of_bars(folder.path());
  std::string text = read_text(list);
  text.replace(text.find("0.2"), 3, "300");
  write_text(list, text);
  const std::vector<std::string> command{"batch", list,       "--job",        "bar-0.4", "--threads",
                                         "1",     "--resume", "--log-format", "openjd"};
  Program task(command);
  wait_for_file(task, folder.path() / "out/bar-0.4/manifest.json");
  task.send(SIGTERM);
  const auto start = std::chrono::steady_clock::now();
  const Outcome canceled = task.wait();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
  EXPECT_EQ(canceled.status, 75) << canceled.err;
  EXPECT_FALSE(contains(canceled.err, "openjd_progress: 100\n")) << canceled.err;
  EXPECT_EQ(fascicle(command).status, 0);
}

}  // namespace
}  // namespace fascicle::tests
