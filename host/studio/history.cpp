#include "host/studio/history.h"

#include <cassert>
#include <utility>

namespace fascicle::studio {

History::History(std::vector<HistoryStep> steps, std::size_t at) : steps_(std::move(steps)), at_(at) {
  assert(at_ < steps_.size());
}

void History::add(std::string label, std::string text, std::optional<std::uint64_t> gesture) {
  steps_.resize(at_ + 1);
  if (gesture && gesture == gesture_ && at_ > 0) {
    steps_.back().text = std::move(text);
    return;
  }
  gesture_ = gesture;
  steps_.push_back({std::move(label), std::move(text)});
  std::size_t bytes = 0, kept = 0;
  for (std::size_t k = steps_.size(); k > 0; --k) {
    bytes += steps_[k - 1].text.size() + steps_[k - 1].label.size();
    if (kept > 0 && (bytes > most_bytes || kept == most_steps)) break;
    ++kept;
  }
  steps_.erase(steps_.begin(), steps_.end() - static_cast<std::ptrdiff_t>(kept));
  at_ = steps_.size() - 1;
}

bool History::undo() {
  if (at_ == 0) return false;
  --at_;
  gesture_.reset();
  return true;
}

bool History::redo() {
  if (at_ + 1 >= steps_.size()) return false;
  ++at_;
  gesture_.reset();
  return true;
}

void History::fall_back(const std::string& text) {
  gesture_.reset();
  for (std::size_t away = 1; away < steps_.size(); ++away) {
    const std::size_t before = at_ - away, after = at_ + away;
    if (away <= at_ && steps_[before].text == text) {
      if (away == 1 && after == steps_.size()) steps_.pop_back();
      at_ = before;
      return;
    }
    if (after < steps_.size() && steps_[after].text == text) {
      at_ = after;
      return;
    }
  }
  steps_[at_].text = text;
}

}  // namespace fascicle::studio
