#include "host/cli/device_failures.h"

#include <algorithm>

namespace fascicle::cli {

namespace {

constexpr int most_in_a_row = 2;

}  // namespace

std::string DeviceFailures::device_of(std::size_t job, const std::string& label) const {
  const auto failed = failed_.find(job);
  const bool has_failed = failed != failed_.end() && failed->second.contains(label);
  return label == automatic_device && has_failed ? "cpu" : label;
}

bool DeviceFailures::may_have(std::size_t job, const std::string& label) const {
  const auto failed = failed_.find(job);
  return !is_off(label) && (failed == failed_.end() || !failed->second.contains(device_of(job, label)));
}

bool DeviceFailures::has_a_device(std::size_t job) const {
  return std::any_of(labels_.begin(), labels_.end(),
                     [&](const std::string& label) { return may_have(job, label); });
}

bool DeviceFailures::is_failing(const std::string& label) const {
  const auto found = in_a_row_.find(label);
  return found != in_a_row_.end() && found->second >= most_in_a_row;
}

bool DeviceFailures::is_off(const std::string& label) const {
  return is_failing(label) && !std::all_of(labels_.begin(), labels_.end(),
                                           [&](const std::string& each) { return is_failing(each); });
}

void DeviceFailures::add(std::size_t job, const std::string& label, Clock::time_point start,
                         bool is_the_jobs) {
  failed_[job].insert(device_of(job, label));
  const auto last = last_.find(label);
  if (is_the_jobs || (last != last_.end() && start <= last->second)) return;
  ++in_a_row_[label];
  last_[label] = Clock::now();
}

}  // namespace fascicle::cli
