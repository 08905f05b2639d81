// Which devices the bakes of a batch may still have, after some of them failed.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace fascicle::cli {

inline constexpr const char* automatic_device = "auto";

class DeviceFailures {
 public:
  using Clock = std::chrono::steady_clock;

  explicit DeviceFailures(std::vector<std::string> labels) : labels_(std::move(labels)) {}

  // The device that a job has in the place of one of this label: "auto" has the CPU behind it.
  std::string device_of(std::size_t job, const std::string& label) const;
  // No job has a device twice that failed it.
  bool may_have(std::size_t job, const std::string& label) const;
  bool has_a_device(std::size_t job) const;
  // Whether it failed two bakes in a row, and another device is left.
  bool is_off(const std::string& label) const;

  // A job that began at `start` has failed for its device. What ends all bakes on a device at once, as a
  // driver's reset, is one failure of it. `is_the_jobs`: the device cannot run this job's model, which says
  // nothing of other jobs.
  void add(std::size_t job, const std::string& label, Clock::time_point start, bool is_the_jobs);
  // A bake has ended as it should there.
  void clear(const std::string& label) { in_a_row_[label] = 0; }

 private:
  bool is_failing(const std::string& label) const;

  std::vector<std::string> labels_;
  std::map<std::size_t, std::set<std::string>> failed_;  // of each job
  std::map<std::string, int> in_a_row_;
  std::map<std::string, Clock::time_point> last_;
};

}  // namespace fascicle::cli
