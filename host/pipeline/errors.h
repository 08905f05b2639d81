// Errors that concern neither the scene nor the disk: bad requests, and devices.
#pragma once

#include <stdexcept>

namespace fascicle::pipeline {

// A request that cannot be carried out. what() says what to do.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A requested device that does not exist or is not suitable.
struct NoSuchDevice : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A device that failed or was lost during the work, with none left to take over.
struct DeviceFailed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace fascicle::pipeline
