#include "host/base/json_text.h"

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace fascicle::tests {
namespace {

std::string nested(std::size_t levels) {
  return std::string(levels, '[') + std::string(levels, ']');
}

TEST(JsonText, AsDeepAsOurOwnStaysAsItIs) {
  for (const std::string& text : {nested(64), std::string(R"({"a": "[[[\"{{{", "b": [1, {"c": "\\"}]})"),
                                  std::string(), std::string("]]]]"), std::string("\"\\")})
    EXPECT_EQ(base::shallow_json(text), text);
}

TEST(JsonText, DeeperIsNoJson) {
  for (const std::size_t levels : {65UL, 1000000UL}) EXPECT_TRUE(base::shallow_json(nested(levels)).empty());
  // Mixed brackets, and a quoted quote that looks like the end of a string.
  std::string mixed;
  for (int k = 0; k < 40; ++k) mixed += "{\"\\\"\":[";
  EXPECT_TRUE(base::shallow_json(mixed).empty());
  EXPECT_TRUE(
      nlohmann::ordered_json::parse(base::shallow_json(nested(1000000)), nullptr, false).is_discarded());
}

TEST(JsonText, TheDepthCanBeChosen) {
  EXPECT_EQ(base::shallow_json(nested(16), 10, 16), nested(16));
  EXPECT_TRUE(base::shallow_json(nested(17), 10, 16).empty());
}

// Ten thousand keys take a second; a million would take hours.
TEST(JsonText, AnObjectWithTooManyKeysIsNoJson) {
  const auto object = [](int keys) {
    std::string text = "{\"of one\":{\"a\":1,\"b\":2},";
    for (int k = 1; k < keys; ++k) text += "\"k" + std::to_string(k) + ":\":1,";
    text.back() = '}';
    return text;
  };
  EXPECT_EQ(base::shallow_json(object(10'000)), object(10'000));
  EXPECT_TRUE(nlohmann::ordered_json::accept(object(10'000)));
  EXPECT_TRUE(base::shallow_json(object(10'001)).empty());
  EXPECT_EQ(base::shallow_json(object(10), 10), object(10));
  EXPECT_TRUE(base::shallow_json(object(11), 10).empty());
  EXPECT_TRUE(base::shallow_json("[{}," + object(1'000'000) + "]").empty());
  // The control: many objects with few keys.
  std::string text = "[";
  for (int k = 0; k < 100'000; ++k) text += "{\"a\":1},";
  text.back() = ']';
  EXPECT_EQ(base::shallow_json(text).size(), text.size());
}

// The control: a long flat array is not deep.
TEST(JsonText, LongIsNotDeep) {
  std::string text = "[";
  for (int k = 0; k < 100000; ++k) text += "[1],";
  text += "{}]";
  EXPECT_EQ(base::shallow_json(text).size(), text.size());
}

}  // namespace
}  // namespace fascicle::tests
