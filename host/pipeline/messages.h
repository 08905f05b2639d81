// Destination of messages during work: the caller's log, of any kind.
#pragma once

#include <functional>
#include <string>

namespace fascicle::pipeline {

enum class Severity { detail, info, warning };
// Called on the thread that does the work. Must not throw.
using Say = std::function<void(Severity severity, const std::string& message)>;

inline void say_detail(const Say& say, const std::string& message) {
  if (say) say(Severity::detail, message);
}
inline void say_info(const Say& say, const std::string& message) {
  if (say) say(Severity::info, message);
}
inline void say_warning(const Say& say, const std::string& message) {
  if (say) say(Severity::warning, message);
}

}  // namespace fascicle::pipeline
