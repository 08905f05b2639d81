// The errors that are neither the scene's nor the disk's: of what was asked for, and of devices.
#pragma once

#include <stdexcept>

namespace fascicle::pipeline {

// A request that cannot be followed. what() says what to do.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A device that was asked for and is not there, or will not do.
struct NoSuchDevice : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A device that failed or was lost on the way, and none was left to go on.
struct DeviceFailed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace fascicle::pipeline
