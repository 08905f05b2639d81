// Bakes of the fake solver, and what tests ask of them.
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

// Bakes until frame `last` is written, then stops as on ctrl-C.
bake::BakeResult bake_until(bake::BakeOptions options, const scene::Scene& scene, std::uint64_t last);

nlohmann::json manifest_in(const std::filesystem::path& folder);

// What a call throws as Error, or a line that no test expects.
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
