#include "host/studio/player.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

namespace fascicle::studio {

using Clock = std::chrono::steady_clock;

namespace {

// s: time constant of the averaged rate.
constexpr double rate_time = 0.5;
// A motion that diverges this often, with fewer calm frames in between, is paused, because it would do so for
// ever.
constexpr unsigned most_divergences = 5, calm_enough = 60;

Clock::duration as_duration(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

const char* name_of(PlayerMode mode) {
  switch (mode) {
    case PlayerMode::playing:
      return "playing";
    case PlayerMode::paused:
      return "paused";
    case PlayerMode::recording:
      return "recording";
    case PlayerMode::baking:
      return "baking";
  }
  return "";
}

Player::Player(std::unique_ptr<Motion> motion, PlayerEvents events)
    : motion_(std::move(motion)), events_(std::move(events)), due_(Clock::now()) {
  thread_ = std::thread([this] { run(); });
}

Player::~Player() {
  stop();
}

void Player::stop() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
  }
  wakes_.notify_all();
  if (thread_.joinable()) thread_.join();
}

PlayerState Player::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

void Player::tell() {
  if (events_.on_state) events_.on_state(state());
}

bool Player::post(Work work) {
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() >= most_waiting) return false;
    waiting_.emplace_back([this, work = std::move(work)] { work(*motion_); });
  }
  wakes_.notify_all();
  return true;
}

void Player::post_needed(Work work) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.emplace_back([this, work = std::move(work)] { work(*motion_); });
  }
  wakes_.notify_all();
}

void Player::hold_until(Clock::time_point time) {
  const std::lock_guard lock(mutex_);
  held_until_ = time;
}

void Player::hurry() {
  hold_until({});
  due_ = Clock::now();
}

bool Player::post_long(PlayerMode mode, Work work) {
  return post([this, mode, number = ++posted_long_, work = std::move(work)](Motion& motion) {
    PlayerMode before;
    {
      const std::lock_guard lock(mutex_);
      before = std::exchange(state_.mode, mode);
    }
    tell();
    running_long_ = number;
    attempt([&] { work(motion); });
    running_long_ = 0;
    {
      const std::lock_guard lock(mutex_);
      state_.mode = before;
      state_.frame = motion.frame();
    }
    tell();
  });
}

void Player::cancel() {
  cancelled_long_ = posted_long_.load();
}

bool Player::play() {
  return post([this](Motion& motion) {
    {
      const std::lock_guard lock(mutex_);
      state_.mode = PlayerMode::playing;
    }
    // At the end of a clip that does not loop, "play" starts again.
    if (!state().loops && motion.frame() >= motion.frames()) show(motion.seek(0));
    due_ = Clock::now();
    tell();
  });
}

bool Player::pause() {
  return post([this](Motion&) {
    {
      const std::lock_guard lock(mutex_);
      state_.mode = PlayerMode::paused;
    }
    tell();
  });
}

bool Player::step() {
  return post([this](Motion& motion) {
    {
      const std::lock_guard lock(mutex_);
      state_.mode = PlayerMode::paused;
    }
    show(motion.advance());
    tell();
  });
}

bool Player::seek(std::uint64_t frame) {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(seek_, frame)) return true;
  }
  const bool is_taken = post([this](Motion& motion) {
    std::uint64_t wanted = 0;
    {
      const std::lock_guard lock(mutex_);
      wanted = std::exchange(seek_, std::nullopt).value_or(motion.frame());
    }
    show(motion.seek(wanted));
    tell();
  });
  if (!is_taken) {
    const std::lock_guard lock(mutex_);
    seek_.reset();
  }
  return is_taken;
}

bool Player::set_speed(double factor) {
  return post([this, factor](Motion&) {
    {
      const std::lock_guard lock(mutex_);
      state_.speed = factor;
    }
    due_ = Clock::now();
    tell();
  });
}

bool Player::set_loop(bool loops) {
  return post([this, loops](Motion&) {
    {
      const std::lock_guard lock(mutex_);
      state_.loops = loops;
    }
    tell();
  });
}

void Player::watch(bool is_watched) {
  {
    const std::lock_guard lock(mutex_);
    is_watched_ = is_watched;
  }
  wakes_.notify_all();
}

bool Player::restart() {
  return post([this](Motion& motion) {
    // New requests interrupt the lead-in before frame 0.
    const auto stop = [this] {
      const std::lock_guard lock(mutex_);
      return stops_ || !waiting_.empty();
    };
    show(motion.restart(stop));
    tell();
  });
}

void Player::show(ShownFrame frame) {
  frame.numbers.sequence = ++sequence_;
  if (frame.numbers.seconds > 0.0f) {
    const double now = 1.0 / double{frame.numbers.seconds};
    const double share = std::min(1.0, double{frame.numbers.seconds} / rate_time);
    rate_ = rate_ > 0.0 ? rate_ + share * (now - rate_) : now;
  }
  frame.numbers.rate = static_cast<float>(rate_);
  {
    const std::lock_guard lock(mutex_);
    state_.frame = frame.numbers.frame;
  }
  if (events_.on_frame) events_.on_frame(*motion_, frame);
}

void Player::pause_now() {
  {
    const std::lock_guard lock(mutex_);
    if (state_.mode == PlayerMode::playing) state_.mode = PlayerMode::paused;
  }
  tell();
}

// An error while reporting trouble must not end the thread.
void Player::tell_trouble(const std::exception& error, bool shows_again) {
  try {
    if (events_.on_trouble) events_.on_trouble(error);
    if (shows_again) show(motion_->again());
  } catch (const std::exception&) {
    pause_now();
  }
}

bool Player::attempt(const std::function<void()>& what) {
  try {
    what();
    return true;
  } catch (const Diverged& error) {
    calm_frames_ = 0;
    ++divergences_;
    tell_trouble(error, true);
  } catch (const std::exception& error) {
    tell_trouble(error, false);
  }
  return false;
}

void Player::advance() {
  const PlayerState now = state();
  if (!now.loops && motion_->frame() >= motion_->frames()) return pause_now();
  const unsigned before = divergences_;
  if (attempt([&] { show(motion_->advance()); })) {
    if (++calm_frames_ >= calm_enough) divergences_ = 0;
  } else if (divergences_ == before || divergences_ >= most_divergences) {
    // The next frame would fail in the same way.
    divergences_ = 0;
    pause_now();
  }
  const double period = 1.0 / (motion_->fps() * now.speed);
  due_ += as_duration(period);
  // Late frames are not made up for.
  due_ = std::max(due_, Clock::now() - as_duration(period));
}

bool Player::may_begin() const {
  const std::lock_guard lock(mutex_);
  return state_.mode == PlayerMode::playing && Clock::now() >= std::max(due_, held_until_);
}

void Player::run() {
  attempt([&] { show(motion_->again()); });
  due_ = Clock::now();
  while (!stops_) {
    std::function<void()> work;
    bool plays = false;
    {
      std::unique_lock lock(mutex_);
      const auto must_play = [&] { return is_watched_ && state_.mode == PlayerMode::playing; };
      const auto has_work = [&] { return stops_ || !waiting_.empty() || must_play() != plays; };
      plays = must_play();
      if (plays)
        wakes_.wait_until(lock, std::max(due_, held_until_), has_work);
      else
        wakes_.wait(lock, has_work);
      if (stops_) return;
      if (!waiting_.empty()) {
        work = std::move(waiting_.front());
        waiting_.pop_front();
      }
    }
    if (work) attempt(work);
    // A stream of requests must not hold up a frame that is due.
    if (plays && may_begin()) advance();
  }
}

}  // namespace fascicle::studio
