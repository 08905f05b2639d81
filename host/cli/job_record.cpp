#include "host/cli/job_record.h"

#include <array>
#include <cerrno>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/bake/folder.h"
#include "host/base/errors.h"
#include "host/base/file.h"
#include "host/base/json_number.h"
#include "host/base/json_text.h"
#include "host/cli/batch_summary.h"

namespace fascicle::cli {

namespace fs = std::filesystem;

fs::path job_record_file(const fs::path& output, const std::string& job) {
  return output / ".outcomes" / (job + ".json");
}

void write_job_record(const fs::path& output, const std::string& job, const JobRecord& record) {
  const fs::path file = job_record_file(output, job);
  bake::make_folder(output);
  base::make_own_folder(file.parent_path());
  const nlohmann::ordered_json json{
      {"host", record.host},
      {"process", record.process},
      {"device", record.device},
      {"exit_status",
       record.exit_status ? nlohmann::ordered_json(*record.exit_status) : nlohmann::ordered_json()},
      {"error", record.error},
      {"warnings", record.warnings},
      {"settings", record.settings}};
  // A job that was submitted twice may run twice at once.
  base::write_whole_beside_others(
      file, json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

std::optional<JobRecord> read_job_record(const fs::path& output, const std::string& job) {
  try {
    const std::string text =
        base::read_input_if_there(job_record_file(output, job), base::most_json_bytes).value_or("");
    const nlohmann::json json = nlohmann::json::parse(base::shallow_json(text), nullptr, false);
    const std::optional<pid_t> process = base::whole_number<pid_t>(json.at("process"));
    // kill() takes numbers below 1 for groups of processes.
    if (!process || *process < 1) return std::nullopt;
    JobRecord record{
        json.at("host"),           *process, json.at("device"), {}, json.at("error"), json.at("warnings"),
        json.value("settings", "")};
    if (const nlohmann::json& status = json.at("exit_status"); !status.is_null()) {
      if (!is_exit_status(status)) return std::nullopt;
      record.exit_status = status.get<int>();
    }
    return record;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  } catch (const base::InputError&) {
    return std::nullopt;
  }
}

void give_sign_of_life(const fs::path& output, const std::string& job) {
  // The time is that of the file system's server, whose clock may differ from ours.
  (void)::utimensat(AT_FDCWD, job_record_file(output, job).c_str(), nullptr, AT_SYMLINK_NOFOLLOW);
}

std::string name_of_this_host() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

bool is_there(long process) {
  return ::kill(static_cast<pid_t>(process), 0) == 0 || errno == EPERM;
}

}  // namespace fascicle::cli
