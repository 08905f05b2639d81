// Undo and redo.
#include "host/studio/history.h"

#include <memory>
#include <string>

#include <gtest/gtest.h>

namespace fascicle::tests {
namespace {

using studio::History;

TEST(History, TakesBackAndMakesAgain) {
  History history("a");
  EXPECT_EQ(history.undo_label(), nullptr);
  EXPECT_FALSE(history.undo());
  history.add("to b", "b", {});
  history.add("to c", "c", {});
  EXPECT_EQ(*history.undo_label(), "to c");
  EXPECT_TRUE(history.undo());
  EXPECT_EQ(history.text(), "b");
  EXPECT_EQ(*history.redo_label(), "to c");
  EXPECT_TRUE(history.undo());
  EXPECT_EQ(history.text(), "a");
  EXPECT_TRUE(history.redo());
  EXPECT_TRUE(history.redo());
  EXPECT_FALSE(history.redo());
  EXPECT_EQ(history.text(), "c");
}

TEST(History, GoesBackToWhatWasBuilt) {
  History history("a");
  history.add("to b", "b", {}, 1);
  EXPECT_TRUE(history.note_built("b", {}));
  EXPECT_FALSE(history.note_built("b", {})) << "known";
  EXPECT_FALSE(history.note_built("nothing", {}));
  EXPECT_FALSE(history.go_to_built());
  history.add("to c", "c", {});
  EXPECT_TRUE(history.go_to_built());
  EXPECT_EQ(history.text(), "b");
  EXPECT_EQ(*history.redo_label(), "to c");
  // A slider that was dragged on is not what was built.
  history.add("drag", "d", {}, 2);
  history.note_built("d", {});
  history.add("drag", "e", {}, 2);
  EXPECT_TRUE(history.go_to_built());
  EXPECT_EQ(history.text(), "b");
  EXPECT_TRUE(history.undo());
  EXPECT_FALSE(history.go_to_built()) << "the first step has nothing before it";
}

TEST(History, AChangeAfterTakingBackEndsWhatCouldBeMadeAgain) {
  History history("a");
  history.add("to b", "b", {});
  history.undo();
  history.add("to d", "d", {});
  EXPECT_EQ(history.redo_label(), nullptr);
  history.undo();
  EXPECT_EQ(history.text(), "a");
}

TEST(History, AGestureIsOneStep) {
  History history("a");
  history.add("drag", "b", {}, 1);
  history.add("drag", "c", {}, 1);
  history.add("drag", "d", {}, 2);
  EXPECT_EQ(history.text(), "d");
  history.undo();
  EXPECT_EQ(history.text(), "c");
  // The same number after another gesture is a new gesture.
  history.add("drag", "e", {}, 1);
  history.undo();
  EXPECT_EQ(history.text(), "c");
  history.undo();
  EXPECT_EQ(history.text(), "a");
}

TEST(History, WhatFailedIsDropped) {
  History history("a");
  history.add("to b", "b", {});
  history.fall_back("a", {});
  EXPECT_EQ(history.text(), "a");
  EXPECT_EQ(history.redo_label(), nullptr);
  history.fall_back("a", {});
  EXPECT_EQ(history.text(), "a");
}

// Paint is undone together with its text, and found by content.
TEST(History, HoldsPaintBesideTheText) {
  const auto painted = [](const char* text) {
    return studio::Paints{{"character.paint", std::make_shared<const std::string>(text)}};
  };
  const auto shown = [](const History& of) { return *of.paints().at("character.paint"); };
  History history("a", painted("bare"));
  history.add("paint", "a", painted("red"));
  history.add("paint", "a", painted("blue"));
  EXPECT_EQ(shown(history), "blue");
  history.undo();
  EXPECT_EQ(shown(history), "red");
  history.redo();
  history.fall_back("a", painted("red"));
  EXPECT_EQ(shown(history), "red");
  EXPECT_EQ(history.redo_label(), nullptr);
  history.fall_back("a", {});
  EXPECT_TRUE(history.paints().empty()) << "no step has this paint, so the current one takes it";
}

TEST(History, KeepsTheNewestOfTooMany) {
  History history("0");
  for (std::size_t k = 1; k <= 2 * History::most_steps; ++k) history.add("step", std::to_string(k), {});
  EXPECT_EQ(history.steps().size(), History::most_steps);
  EXPECT_EQ(history.text(), std::to_string(2 * History::most_steps));
  const std::string large(History::most_bytes / 2, 'x');
  for (int k = 0; k < 4; ++k) history.add("large", large + std::to_string(k), {});
  EXPECT_LE(history.steps().size(), 2u);
  EXPECT_EQ(history.text().back(), '3');
  // Paint counts once, however many steps share it.
  History small("0");
  const auto paint = std::make_shared<const std::string>(large);
  for (int k = 0; k < 10; ++k) small.add("step", std::to_string(k), {{"character.paint", paint}});
  EXPECT_EQ(small.steps().size(), 11u);
  for (int k = 0; k < 10; ++k)
    small.add("paint", "p", {{"character.paint", std::make_shared<const std::string>(large)}});
  EXPECT_LE(small.steps().size(), 2u);
}

}  // namespace
}  // namespace fascicle::tests
