// Exceptions for unusable inputs and outputs. The message is for the user.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace fascicle::base {

// Unusable input. what() reads "FILE:LINE: KEY: what is wrong; what to do".
struct SceneError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A folder that cannot be baked into, or a cache that does not match: bad input or usage. what() says what to
// do.
struct BakeError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A file that cannot be read as an input. what() reads "FILE: REASON".
struct InputError : SceneError {
  InputError(const std::filesystem::path& file, const std::string& why)
      : SceneError(file.string() + ": " + why), reason(why) {}
  std::string reason;
};

}  // namespace fascicle::base
