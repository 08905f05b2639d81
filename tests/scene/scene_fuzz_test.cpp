// Randomly damaged scene files give a Scene or a SceneError, and nothing else.
#include <random>

#include <gtest/gtest.h>

#include "host/scene/scene_file.h"
#include "tests/scene/scene_samples.h"
#include "tests/support/seed.h"

namespace fascicle::tests {
namespace {

// Valid pieces of scene files, inserted in wrong places.
const std::vector<std::string> pieces{"[",
                                      "]",
                                      "{",
                                      "}",
                                      "=",
                                      ".",
                                      ",",
                                      "\"",
                                      "'",
                                      "\n",
                                      "#",
                                      "nan",
                                      "inf",
                                      "-1",
                                      "1e400",
                                      "0x1F",
                                      "1e-400",
                                      "true",
                                      "[[bar]]",
                                      "[bar]",
                                      "where",
                                      "\\u0000",
                                      "\xff",
                                      "\xc3",
                                      "\"\"\"",
                                      "'''",
                                      "[layers]",
                                      "{}",
                                      "[]",
                                      "[[], []]",
                                      "layers",
                                      "9223372036854775807",
                                      "99999999999999999999",
                                      "1979-05-27T07:32:00Z",
                                      "[layers.body.where]",
                                      "= {",
                                      "bone_distance = { maximum = 1 }",
                                      "per_bone = { a = 1 }",
                                      "[skeleton]",
                                      "points = [[0, 0, 0], [0, 0, 1]]"};

std::string damaged(std::string text, std::mt19937_64& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  for (std::size_t times = 1 + below(2); times > 0; --times) {
    if (text.empty()) return text;
    const std::size_t at = below(text.size());
    const std::size_t length = std::min(1 + below(24), text.size() - at);
    switch (below(5)) {
      case 0:
        text[at] = static_cast<char>(random());
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, pieces[below(pieces.size())]);
        break;
      case 3:
        text.insert(below(text.size()), text.substr(at, length));
        break;
      default: {
        // Replaces a whole value: the result is still TOML, so later checks are reached.
        const std::size_t equals = text.find(" = ", at);
        const std::size_t end = text.find('\n', equals == std::string::npos ? text.size() : equals);
        if (end == std::string::npos) break;
        const std::size_t other = text.find(" = ", below(text.size()));
        if (other == std::string::npos) break;
        text.replace(equals, end - equals, text.substr(other, text.find('\n', other) - other));
      }
    }
  }
  return text;
}

TEST(SceneFuzz, DamagedTextsGiveASceneOrASceneError) {
  std::mt19937_64 random(seed_of_run(20170522));
  std::size_t scenes = 0, errors = 0;
  constexpr int rounds = 8000;
  for (int round = 0; round < rounds; ++round) {
    const std::string text = damaged(bar_sample(), random);
    try {
      const scene::Scene scene = scene::parse_scene({"sample", "sample.toml", text, {}}, {});
      EXPECT_FALSE(scene.layers.empty());
      EXPECT_GE(scene::frame_count(scene), 1u);
      ++scenes;
    } catch (const scene::SceneError& error) {
      const std::string message = error.what();
      EXPECT_TRUE(message.starts_with("sample.toml:")) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      ++errors;
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what() << "\nfrom\n" << text;
    }
  }
  // Both outcomes occurred often enough.
  EXPECT_GT(scenes, rounds / 50u);
  EXPECT_GT(errors, rounds / 50u);
}

TEST(SceneFuzz, DamagedOverridesGiveASceneOrASceneError) {
  const std::vector<std::string> sets{"layers.fat.alpha=0.2", "pin.plane.where.below.fraction=0.5",
                                      "bar.vertices=[3, 3, 3]", "probe.new={ where = { everywhere = true } }",
                                      "scene.description=text"};
  std::mt19937_64 random(seed_of_run(20170524));
  std::size_t scenes = 0, errors = 0;
  for (int round = 0; round < 4000; ++round) {
    const std::string set = damaged(sets[random() % sets.size()], random);
    try {
      const scene::Scene scene =
          scene::parse_scene({"sample", "sample.toml", bar_sample(), {}}, {.set = {set}});
      // An accepted scene can be written and read back.
      EXPECT_EQ(describe(scene::parse_scene({"sample", "sample.toml", scene.text, {}}, {})), describe(scene))
          << set;
      ++scenes;
    } catch (const scene::SceneError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      ++errors;
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what() << "\nfrom\n" << set;
    }
  }
  EXPECT_GT(scenes, 100u);
  EXPECT_GT(errors, 100u);
}

}  // namespace
}  // namespace fascicle::tests
