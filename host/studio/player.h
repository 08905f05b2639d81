// The thread that plays a motion in real time and carries out requests between frames.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "host/studio/motion.h"

namespace fascicle::studio {

enum class PlayerMode { playing, paused, recording, baking };
const char* name_of(PlayerMode mode);

struct PlayerState {
  PlayerMode mode = PlayerMode::playing;
  std::uint64_t frame = 0;
  double speed = 1.0;
  bool loops = true;
};

// Called on the player's thread. Must not throw.
struct PlayerEvents {
  // `sequence` and `rate` are filled in. The motion does not advance during the call.
  std::function<void(Motion&, const ShownFrame&)> on_frame;
  std::function<void(const PlayerState&)> on_state;
  std::function<void(const std::exception&)> on_trouble;  // the motion diverged, or work failed
};

class Player {
 public:
  // Plays from the motion's current frame.
  Player(std::unique_ptr<Motion> motion, PlayerEvents events);
  ~Player();
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;
  // Ends the thread, including long work; nothing is played afterwards. An owner whose events use the player
  // calls this before destroying it.
  void stop();

  // From any thread; carried out in order, between frames. If more than most_waiting requests wait, the
  // request is dropped and false returned.
  bool play();
  bool pause();
  bool step();
  bool seek(std::uint64_t frame);  // if several wait, only the last counts
  bool set_speed(double factor);
  bool set_loop(bool loops);
  bool restart();
  // Whether anyone is watching; nothing plays otherwise. Initially true. Any thread.
  void watch(bool is_watched);
  // Runs work with the motion on the player's thread. Playback continues from when it ends, without catching
  // up.
  using Work = std::function<void(Motion&)>;
  bool post(Work work);
  // The same for work that must not be dropped, such as releasing the hand.
  void post_needed(Work work);
  // No new frame is played before this time, because a better one is expected. Any thread.
  void hold_until(std::chrono::steady_clock::time_point time);
  // Long work that calls show() for its frames; the player's mode is `mode` meanwhile. It should end soon
  // after must_stop() becomes true.
  bool post_long(PlayerMode mode, Work work);

  // On the player's thread only.
  void show(ShownFrame frame);
  // Resumes playback at once, cancelling hold_until.
  void hurry();
  bool must_stop() const { return stops_ || (running_long_ > 0 && cancelled_long_ >= running_long_); }
  // Cancels the long work posted so far, running or waiting, but none posted later.
  void cancel();
  PlayerState state() const;
  std::uint32_t last_sequence() const { return sequence_; }

  static constexpr std::size_t most_waiting = 1024;

 private:
  void run();
  bool may_begin() const;
  void advance();
  void tell();
  // False if it threw.
  bool attempt(const std::function<void()>& what);
  void tell_trouble(const std::exception& error, bool shows_again);
  void pause_now();

  std::unique_ptr<Motion> motion_;
  PlayerEvents events_;
  mutable std::mutex mutex_;  // guards state_, waiting_, is_watched_, held_until_ and seek_
  std::condition_variable wakes_;
  std::deque<std::function<void()>> waiting_;
  PlayerState state_;
  bool is_watched_ = true;
  std::chrono::steady_clock::time_point held_until_;
  std::optional<std::uint64_t> seek_;  // the waiting one
  std::atomic<bool> stops_ = false;
  std::atomic<std::uint64_t> posted_long_ = 0, cancelled_long_ = 0;
  std::uint64_t running_long_ = 0;  // 0: none; only for the player's thread
  std::atomic<std::uint32_t> sequence_ = 0;
  std::chrono::steady_clock::time_point due_;
  double rate_ = 0.0;
  unsigned divergences_ = 0, calm_frames_ = 0;  // of recent frames; only for the player's thread
  std::thread thread_;
};

}  // namespace fascicle::studio
