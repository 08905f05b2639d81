#include "tests/exactness/process.h"

#include <cstdio>

namespace fascicle::tests {

Output run(const std::string& command) {
  Output output;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return {-1, "popen failed"};
  char buffer[4096];
  while (std::size_t n = fread(buffer, 1, sizeof buffer, pipe)) output.text.append(buffer, n);
  output.status = pclose(pipe);
  return output;
}

}  // namespace fascicle::tests
