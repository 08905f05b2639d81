// The history of a scene's text and its characters' paint: every change can be undone and redone.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fascicle::studio {

// A paint file's text, shared between steps.
using PaintText = std::shared_ptr<const std::string>;
// What is painted on each character, by the key that names its file: "character.paint",
// "character.NAME.paint". No entry is null.
using Paints = std::map<std::string, PaintText>;

// Whether the contents are equal.
bool is_same(const Paints& a, const Paints& b);

struct HistoryStep {
  std::string label;  // the change that led here; empty for the first step
  std::string text;   // the scene's text
  Paints paints = {};
  bool is_built = false;  // a body was made of it, and a frame of that body was shown
};

class History {
 public:
  // The oldest steps beyond these limits are dropped.
  static constexpr std::size_t most_steps = 1000, most_bytes = std::size_t{64} << 20;

  explicit History(std::string text, Paints paints = {}) : steps_{{"", std::move(text), std::move(paints)}} {}
  // `steps` must not be empty, and `at` must be an index into it.
  History(std::vector<HistoryStep> steps, std::size_t at);

  const std::string& text() const { return steps_[at_].text; }
  const Paints& paints() const { return steps_[at_].paints; }
  // Replaces the last change if both have the same gesture.
  void add(std::string label, std::string text, Paints paints,
           std::optional<std::uint64_t> gesture = std::nullopt);
  // Labels of the changes that undo and redo would apply; null if there is none.
  const std::string* undo_label() const { return at_ > 0 ? &steps_[at_].label : nullptr; }
  const std::string* redo_label() const { return at_ + 1 < steps_.size() ? &steps_[at_ + 1].label : nullptr; }
  bool undo();
  bool redo();
  // Call when the current step turns out to be invalid: returns to the nearest step with this text and paint.
  // If that is the step before the last change, the last change is dropped. If no step has them, the current
  // step takes them.
  void fall_back(const std::string& text, const Paints& paints);
  // Call when a frame of this text and paint has been shown. Returns whether that is news of a step.
  bool note_built(const std::string& text, const Paints& paints);
  // Goes back to the nearest step that was built, or else to the first. Later ones can be redone. Returns
  // whether the current step is another now.
  bool go_to_built();

  const std::vector<HistoryStep>& steps() const { return steps_; }
  std::size_t at() const { return at_; }

 private:
  std::vector<HistoryStep> steps_;
  std::size_t at_ = 0;
  std::optional<std::uint64_t> gesture_;  // of the current step
};

}  // namespace fascicle::studio
