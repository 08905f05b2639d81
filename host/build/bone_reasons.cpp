#include "host/build/bone_reasons.h"

#include <cstddef>
#include <iomanip>
#include <sstream>

#include "host/base/text.h"

namespace fascicle::build {

namespace {

constexpr std::size_t most_named_roots = 5;

}  // namespace

std::string reason_of(const JointReport& joint, const JointDecision& decision, double least_share) {
  if (!(joint.share > 0.0)) return joint.is_bone ? "bone: requested" : "no bone: moves no skin";
  std::ostringstream text;
  text << std::fixed << (joint.is_bone ? "bone: " : "no bone: ");
  if (!decision.why.empty())
    text << decision.why;
  else if (decision.is_excluded)
    text << "excluded";
  else if (decision.is_control)
    text << "a control outside the skin";
  else if (joint.share < least_share)
    text << "moves less than " << std::setprecision(1) << 100.0 * least_share << " % of the skin";
  else
    text << "its skin does not close around it";
  text << " (open " << std::setprecision(2) << joint.openness << "); moves " << std::setprecision(1)
       << 100.0 * joint.share << " % of the skin";
  for (const std::string& next : decision.leads_to) text << "; leads to " << next;
  if (joint.ends_chain) text << "; ends a chain";
  if (joint.is_kinematic)
    text << "; its flesh follows the skeleton";
  else if (!joint.is_bone)
    text << "; its flesh is free";
  return text.str();
}

std::string small_joints_warning(double share, double least_share, const std::set<std::string>& roots) {
  std::string names;
  for (const std::string& name : roots) names += (names.empty() ? "" : ", ") + name;
  const std::string advice = roots.size() > most_named_roots
                                 ? "name joints in skeleton.simulated, or lower skeleton.least_share"
                                 : "set skeleton.simulated = [" + names + "], or name joints below";
  return base::percent_text(share) +
         " of the skin follows the skeleton because the joints there are too small to be bones: "
         "each moves less than " +
         base::percent_text(least_share) + " of the skin (skeleton.least_share); if it is flesh, " + advice;
}

}  // namespace fascicle::build
