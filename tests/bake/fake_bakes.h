// Bakes with the fake solver, and checks of them.
#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/bake/bake.h"
#include "tests/bake/fake_solver.h"

namespace fascicle::tests {

bake::BakeResult fake_bake_into(const bake::BakeOptions& options, const scene::Scene& scene,
                                FakeOptions fake = {});

// Bakes until frame `last` is written, then stops as with ctrl-C.
bake::BakeResult bake_until(bake::BakeOptions options, const scene::Scene& scene, std::uint64_t last);

nlohmann::json manifest_in(const std::filesystem::path& folder);

// The message of the Error that a call throws, or a line that no test expects.
template <class Error, class Call>
std::string message_of(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

testing::AssertionResult contains(const std::string& text, const std::string& part);

}  // namespace fascicle::tests
