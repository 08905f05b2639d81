// The texts that a scene has had, and what was painted on its characters, from the first to the last: every
// change can be taken back and made again.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fascicle::studio {

// A paint file's text, which steps share.
using PaintText = std::shared_ptr<const std::string>;
// What is painted on each character, by the key that names its file: "character.paint",
// "character.NAME.paint". None is null.
using Paints = std::map<std::string, PaintText>;

// Whether they say the same.
bool is_same(const Paints& a, const Paints& b);

struct HistoryStep {
  std::string label;  // what was done to come here; of the first step empty
  std::string text;   // of the scene
  Paints paints = {};
};

class History {
 public:
  // Of the oldest steps those go that do not fit in.
  static constexpr std::size_t most_steps = 1000, most_bytes = std::size_t{64} << 20;

  explicit History(std::string text, Paints paints = {}) : steps_{{"", std::move(text), std::move(paints)}} {}
  // `steps` is not empty and `at` is one of them.
  History(std::vector<HistoryStep> steps, std::size_t at);

  const std::string& text() const { return steps_[at_].text; }
  const Paints& paints() const { return steps_[at_].paints; }
  // Takes the place of the last change where both have this gesture.
  void add(std::string label, std::string text, Paints paints,
           std::optional<std::uint64_t> gesture = std::nullopt);
  // What would be taken back, and what would be made again; null where there is nothing.
  const std::string* undo_label() const { return at_ > 0 ? &steps_[at_].label : nullptr; }
  const std::string* redo_label() const { return at_ + 1 < steps_.size() ? &steps_[at_ + 1].label : nullptr; }
  bool undo();
  bool redo();
  // The step in force does not hold after all: the nearest one with this text and paint is in force again.
  // The last change goes for good where it led away from that; where no step has them, the step in force gets
  // them.
  void fall_back(const std::string& text, const Paints& paints);

  const std::vector<HistoryStep>& steps() const { return steps_; }
  std::size_t at() const { return at_; }

 private:
  std::vector<HistoryStep> steps_;
  std::size_t at_ = 0;
  std::optional<std::uint64_t> gesture_;  // of the step that is in force
};

}  // namespace fascicle::studio
