// Commands run by the exactness tests.
#pragma once

#include <string>

namespace fascicle::tests {

struct Output {
  int status = 0;    // of pclose; 0 means success
  std::string text;  // stdout and stderr
};

Output run(const std::string& command);

}  // namespace fascicle::tests
