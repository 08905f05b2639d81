// Which devices a batch may still use for its bakes after failures.
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

  // The device that a job gets from the slot of this label: "auto" falls back to the CPU.
  std::string device_of(std::size_t job, const std::string& label) const;
  // A job does not get a device again on which it failed.
  bool may_have(std::size_t job, const std::string& label) const;
  bool has_a_device(std::size_t job) const;
  // Whether it failed two bakes in a row while another device remains.
  bool is_off(const std::string& label) const;

  // A job that started at `start` failed because of its device. An event that ends all bakes on a device at
  // once, such as a driver reset, counts as one failure. `is_the_jobs`: the device cannot run this job's
  // model, which says nothing about other jobs.
  void add(std::size_t job, const std::string& label, Clock::time_point start, bool is_the_jobs);
  // A bake ended normally on this device.
  void clear(const std::string& label) { in_a_row_[label] = 0; }

 private:
  bool is_failing(const std::string& label) const;

  std::vector<std::string> labels_;
  std::map<std::size_t, std::set<std::string>> failed_;  // per job
  std::map<std::string, int> in_a_row_;
  std::map<std::string, Clock::time_point> last_;
};

}  // namespace fascicle::cli
