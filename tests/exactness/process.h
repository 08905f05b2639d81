// Commands that the exactness tests run.
#pragma once

#include <string>

namespace fascicle::tests {

struct Output {
  int status = 0;    // as of pclose; 0: all well
  std::string text;  // stdout and stderr
};

Output run(const std::string& command);

}  // namespace fascicle::tests
