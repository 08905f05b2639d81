// The message of a failed call of the C API.
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "include/fascicle/fascicle.h"

namespace fascicle_tests {

inline std::string message() {
  return fascicle_last_message();
}

// Expects the status, and `part` in the message.
#define EXPECT_FAILS(call, wanted, part)                                            \
  do {                                                                              \
    EXPECT_EQ(call, wanted) << message();                                           \
    EXPECT_NE(message().find(part), std::string::npos) << "message: " << message(); \
  } while (false)

}  // namespace fascicle_tests
