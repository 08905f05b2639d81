// The thread that plays a motion: in time with the clock, and whatever is asked of it between two frames.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
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
  // `sequence` and `rate` are filled in. The motion stands still meanwhile.
  std::function<void(Motion&, const ShownFrame&)> on_frame;
  std::function<void(const PlayerState&)> on_state;
  std::function<void(const std::string&)> on_trouble;  // a motion that came apart, or work that failed
};

class Player {
 public:
  // Plays from where the motion stands.
  Player(std::unique_ptr<Motion> motion, PlayerEvents events);
  ~Player();
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;
  // Ends the thread, long work too; after that nothing is played any more. Whoever has events that reach back
  // to the player calls it before the player goes.
  void stop();

  // Any thread, in order; each between two frames. Where more than most_waiting wait already, what is asked
  // is dropped, and false returned.
  bool play();
  bool pause();
  bool step();
  bool seek(std::uint64_t frame);  // of several that wait the last one goes
  bool set_speed(double factor);
  bool set_loop(bool loops);
  bool restart();
  // Whether anybody looks: where nobody does, what plays stands still. At first somebody does. Any thread.
  void watch(bool is_watched);
  // Work with the motion on the player's thread. Its time counts against nothing: the clock goes on from when
  // it ends.
  using Work = std::function<void(Motion&)>;
  bool post(Work work);
  // The same for work that must not be lost, such as letting go; it is always taken.
  void post_needed(Work work);
  // Until then no frame begins that plays by itself: something better is about to be there. Any thread.
  void hold_until(std::chrono::steady_clock::time_point time);
  // Work that takes long and shows its frames itself by show(): the player's mode meanwhile is `mode`. It
  // should end soon when must_stop() is true.
  bool post_long(PlayerMode mode, Work work);

  // On the player's thread only.
  void show(ShownFrame frame);
  // What plays goes on at once, and is held no longer.
  void hurry();
  bool must_stop() const { return stops_ || (running_long_ > 0 && cancelled_long_ >= running_long_); }
  // Ends the long work that was posted before, under way or waiting, and none that is posted later.
  void cancel();
  PlayerState state() const;
  std::uint32_t last_sequence() const { return sequence_; }

  static constexpr std::size_t most_waiting = 1024;

 private:
  void run();
  bool may_begin() const;
  void advance();
  void tell();
  // False where it came to trouble.
  bool attempt(const std::function<void()>& what);
  void tell_trouble(const char* text, bool shows_again);
  void pause_now();

  std::unique_ptr<Motion> motion_;
  PlayerEvents events_;
  mutable std::mutex mutex_;  // of state_, waiting_, is_watched_, held_until_ and seek_
  std::condition_variable wakes_;
  std::deque<std::function<void()>> waiting_;
  PlayerState state_;
  bool is_watched_ = true;
  std::chrono::steady_clock::time_point held_until_;
  std::optional<std::uint64_t> seek_;  // that waits
  std::atomic<bool> stops_ = false;
  std::atomic<std::uint64_t> posted_long_ = 0, cancelled_long_ = 0;
  std::uint64_t running_long_ = 0;  // 0: none; the player's thread alone has it
  std::atomic<std::uint32_t> sequence_ = 0;
  std::chrono::steady_clock::time_point due_;
  double rate_ = 0.0;
  unsigned divergences_ = 0, calm_frames_ = 0;  // of the last frames; the player's thread alone has them
  std::thread thread_;
};

}  // namespace fascicle::studio
