// The record of a batch's job that runs as its own process on some host: that it has begun, and how it ended.
// A bake that is rejected, or killed before its first frame, has no manifest to show it.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fascicle::cli {

struct JobRecord {
  std::string host;
  long process = 0;  // on `host`
  std::string device;
  std::optional<int> exit_status;  // nullopt: still running, or cut off
  std::string error;
  std::vector<std::string> warnings;
  std::string settings = {};  // settings_text() of the job; empty in records of older versions
};

// OUTPUT/.outcomes/NAME.json. No job's folder can clash with it, because no job's name starts with a dot.
std::filesystem::path job_record_file(const std::filesystem::path& output, const std::string& job);

// Atomically replaces the record.
void write_job_record(const std::filesystem::path& output, const std::string& job, const JobRecord& record);
// nullopt if there is no readable record.
std::optional<JobRecord> read_job_record(const std::filesystem::path& output, const std::string& job);

// While a job runs, its record is marked as fresh at this interval. A record without exit status that is
// older than `sign_of_life_due` is of a process that was killed, or whose host went down.
inline constexpr std::chrono::seconds sign_of_life_interval(10), sign_of_life_due(600);
// Marks the record as fresh. Does nothing if that fails, for example because there is none.
void give_sign_of_life(const std::filesystem::path& output, const std::string& job);

std::string name_of_this_host();
// Whether this host has a process with this number.
bool is_there(long process);

}  // namespace fascicle::cli
