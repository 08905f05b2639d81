// The choice of bones in words.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "host/build/build.h"

namespace fascicle::build {

// What decided about a joint, besides the measures in its report.
struct JointDecision {
  std::string why;  // why it is a bone or not; empty: one of the next two, or its measures
  bool is_excluded = false, is_control = false;
  std::vector<std::string> leads_to = {};  // names of the joints that take over from it
};

// "bone: its skin closes around it (open 0.12); moves 4.1 % of the skin; ..." `least_share`: of the skin's
// area, what a bone moves at least.
std::string reason_of(const JointReport& joint, const JointDecision& decision, double least_share);

// The warning that `share` (0 to 1) of the skin's area follows the skeleton, because its joints are too small
// for bones. `roots`: names of the skeleton's roots above them, in quotes.
std::string small_joints_warning(double share, double least_share, const std::set<std::string>& roots);

}  // namespace fascicle::build
