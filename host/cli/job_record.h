// What a job of a batch leaves beside its bake where each job is a process on some host: that it has begun,
// and how its run ended. A bake that is refused, or killed before its first frame, has no manifest to say so.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fascicle::cli {

struct JobRecord {
  std::string host;
  long process = 0;  // on that host
  std::string device;
  std::optional<int> exit_status;  // none: it has begun
  std::string error;
  std::vector<std::string> warnings;
};

// OUTPUT/.outcomes/NAME.json: no job's folder can have that name, as none begins with a dot.
std::filesystem::path job_record_file(const std::filesystem::path& output, const std::string& job);

// Of this process. Replaces the file whole.
void write_job_record(const std::filesystem::path& output, const std::string& job, const JobRecord& record);
// Nothing where there is none that can be read.
std::optional<JobRecord> read_job_record(const std::filesystem::path& output, const std::string& job);

std::string name_of_this_host();
// Whether a process of this host is there.
bool is_there(long process);

}  // namespace fascicle::cli
