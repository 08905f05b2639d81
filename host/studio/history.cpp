#include "host/studio/history.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace fascicle::studio {

History::History(std::vector<HistoryStep> steps, std::size_t at) : steps_(std::move(steps)), at_(at) {
  assert(at_ < steps_.size());
}

bool is_same(const Paints& a, const Paints& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& one, const auto& other) {
    return one.first == other.first && (one.second == other.second || *one.second == *other.second);
  });
}

namespace {

// Bytes of the paints not shared with the next step.
std::size_t own_bytes(const Paints& paints, const Paints* next) {
  std::size_t bytes = 0;
  for (const auto& [key, text] : paints) {
    const auto found = next != nullptr ? next->find(key) : paints.end();
    const bool is_shared = next != nullptr && found != next->end() && found->second == text;
    if (!is_shared) bytes += text->size();
  }
  return bytes;
}

}  // namespace

void History::add(std::string label, std::string text, Paints paints, std::optional<std::uint64_t> gesture) {
  steps_.resize(at_ + 1);
  if (gesture && gesture == gesture_ && at_ > 0) {
    steps_.back().text = std::move(text);
    steps_.back().paints = std::move(paints);
    steps_.back().is_built = false;
    return;
  }
  gesture_ = gesture;
  steps_.push_back({std::move(label), std::move(text), std::move(paints)});
  std::size_t bytes = 0, kept = 0;
  for (std::size_t k = steps_.size(); k > 0; --k) {
    const HistoryStep& step = steps_[k - 1];
    bytes += step.text.size() + step.label.size();
    bytes += own_bytes(step.paints, k == steps_.size() ? nullptr : &steps_[k].paints);
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

void History::fall_back(const std::string& text, const Paints& paints) {
  gesture_.reset();
  const auto has_both = [&](std::size_t k) {
    return steps_[k].text == text && is_same(steps_[k].paints, paints);
  };
  for (std::size_t away = 1; away < steps_.size(); ++away) {
    const std::size_t before = at_ - away, after = at_ + away;
    if (away <= at_ && has_both(before)) {
      if (away == 1 && after == steps_.size()) steps_.pop_back();
      at_ = before;
      return;
    }
    if (after < steps_.size() && has_both(after)) {
      at_ = after;
      return;
    }
  }
  steps_[at_].text = text;
  steps_[at_].paints = paints;
  steps_[at_].is_built = true;
}

bool History::note_built(const std::string& text, const Paints& paints) {
  bool is_news = false;
  for (HistoryStep& step : steps_) {
    if (step.is_built || step.text != text || !is_same(step.paints, paints)) continue;
    step.is_built = true;
    is_news = true;
  }
  return is_news;
}

bool History::go_to_built() {
  const std::size_t before = at_;
  while (at_ > 0 && !steps_[at_].is_built) --at_;
  if (at_ != before) gesture_.reset();
  return at_ != before;
}

}  // namespace fascicle::studio
