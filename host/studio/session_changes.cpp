// Changes to keys: from the page to the live simulation.
#include <algorithm>
#include <utility>

#include "host/pipeline/build_scene.h"
#include "host/scene/input_files.h"
#include "host/studio/scene_keys.h"
#include "host/studio/session.h"

namespace fascicle::studio {

using Clock = std::chrono::steady_clock;

namespace {

constexpr std::size_t most_pending = 256;
// For a change that needs no new body, playback waits this long at most: frames with outdated keys would only
// compete with the builder for the processors.
constexpr auto patience_for_change = std::chrono::milliseconds(250);

// The new values of keys that differ, by path; null for keys that are gone.
Json differences(const std::vector<scene::EditedTable>& before,
                 const std::vector<scene::EditedTable>& after) {
  std::map<std::string, const scene::EditedKey*> old;
  for (const scene::EditedTable& table : before)
    for (const scene::EditedKey& key : table.keys) old[key.path] = &key;
  Json changes = Json::object();
  for (const scene::EditedTable& table : after)
    for (const scene::EditedKey& key : table.keys) {
      const auto found = old.find(key.path);
      const bool is_same = found != old.end() && found->second->value == key.value &&
                           found->second->is_stated == key.is_stated;
      if (!is_same) changes[key.path] = key.value;
      if (found != old.end()) old.erase(found);
    }
  for (const auto& [path, key] : old) changes[path] = nullptr;
  return changes;
}

}  // namespace

void Session::set_keys(const std::vector<scene::KeyChange>& changes, const std::string& label,
                       std::optional<std::uint64_t> gesture) {
  const scene::ChangedText changed = scene::change_text(history_->text(), source_, changes);
  if (changed.text == history_->text()) return;
  std::vector<scene::EditedTable> after = scene::edited_tables(changed.text, source_);
  const Paints painted = history_->paints();
  history_->add(label, changed.text, paints_after(after), gesture);
  const std::vector<scene::EditedTable> before = std::exchange(tables_, std::move(after));
  take_text(before, painted);
}

void Session::step_in_history(bool is_undo) {
  const Paints painted = history_->paints();
  if (!(is_undo ? history_->undo() : history_->redo()))
    throw std::runtime_error(is_undo ? "nothing to undo" : "nothing to redo");
  std::vector<scene::EditedTable> after;
  try {
    after = scene::edited_tables(history_->text(), source_);
  } catch (const scene::SceneError&) {
    // The session file was edited by hand.
    is_undo ? history_->redo() : history_->undo();
    throw;
  }
  take_text(std::exchange(tables_, std::move(after)), painted);
}

// Publishes the new current text.
void Session::take_text(const std::vector<scene::EditedTable>& before, const Paints& painted_before,
                        bool is_running) {
  ++revision_;
  if (is_running) built_ = revision_;
  const Json changes = differences(before, tables_);
  const bool is_painted_anew = !is_same(history_->paints(), painted_before);
  bool is_rebuild = is_painted_anew;
  for (const auto& [path, value] : changes.items()) is_rebuild = is_rebuild || needs_new_body(path);
  is_rebuild = is_rebuild && !is_running;
  if (pending_.size() == most_pending) pending_.erase(pending_.begin());
  if (is_running)
    pending_.clear();
  else
    pending_.push_back({revision_, is_rebuild, Clock::now()});
  // The body being built is already outdated.
  if (builds_anew_) stops_build_ = true;
  Json message{{"type", "changed"},
               {"revision", revision_},
               {"changes", changes},
               {"effect", is_rebuild ? "rebuild" : "live"}};
  if (!is_rebuild && !is_running) player_->hold_until(Clock::now() + patience_for_change);
  if (is_rebuild) {
    message["message"] = "Rebuilding the body; the old one keeps moving until then";
    player_message_ = "Rebuilding the body";
    broadcast(player_json());
  }
  broadcast(message);
  if (is_painted_anew) send_paint(std::nullopt);
  broadcast(keys_message());
  broadcast(history_json());
  autosave();
  builder_wakes_.notify_all();
}

void Session::autosave() {
  writer_->put({source_, base_hash_, history_->steps(), history_->at(), saved_file_, saved_hash_, saved_text_,
                saved_paints_});
}

// The builder's thread. Always takes the newest text.
void Session::build_on() {
  const std::string getting_ready = "Preparing for changes";
  const auto say_on_top = [&](const std::string& text, const std::string& in_place_of) {
    const std::lock_guard lock(mutex_);
    if (player_message_ != in_place_of) return;
    player_message_ = text;
    broadcast(player_json());
  };
  say_on_top(getting_ready, "");
  try {
    workshop_->warm();
  } catch (const std::exception&) {
    // The first change will report the error.
  }
  say_on_top("", getting_ready);
  for (;;) {
    Order order;
    {
      std::unique_lock lock(mutex_);
      builder_wakes_.wait(lock, [this] { return stops_ || revision_ != built_ || !gpu_error_.empty(); });
      if (stops_) return;
      order = {.revision = revision_,
               .text = history_->text(),
               .paints = history_->paints(),
               .is_edit = revision_ != built_,
               .gpu_error = std::exchange(gpu_error_, {})};
      built_ = revision_;
      builds_anew_ =
          std::any_of(pending_.begin(), pending_.end(), [](const Pending& one) { return one.is_rebuild; });
      stops_build_ = false;
    }
    build(order);
    const std::lock_guard lock(mutex_);
    builds_anew_ = false;
  }
}

std::shared_ptr<RunningBody> Session::make(const std::string& text, const Paints& paints,
                                           std::uint32_t revision) {
  try {
    return workshop_->make(text, paints, revision, say_);
  } catch (const pipeline::NoSuchDevice& error) {
    if (!may_leave_gpu()) throw;
    leave_gpu(error.what(), "the model does not fit the GPU");
  } catch (const gpu::DeviceError& error) {
    if (!may_leave_gpu()) throw;
    leave_gpu(devices_.back().label() + ": " + error.what(), gpu_failed);
  }
  return workshop_->make(text, paints, revision, say_);
}

bool Session::may_leave_gpu() const {
  return options_.device.kind == pipeline::DeviceRequest::Kind::automatic && devices_.back().gpu() != nullptr;
}

// From now on, bodies are made for the CPU. On the builder's thread, or before it starts.
void Session::leave_gpu(const std::string& problem, const std::string& why) {
  pipeline::say_warning(say_, problem + "; the CPU takes over");
  pipeline::ChosenDevice cpu = pipeline::ChosenDevice::cpu(options_.threads, options_.device.simd, why);
  {
    const std::lock_guard lock(mutex_);
    devices_.push_back(std::move(cpu));
    broadcast({{"type", "device"}, {"device", devices_.back().text()}});
  }
  workshop_->use(devices_.back());
}

// Whether the newest body, on show or waiting for the player, is still on a GPU that was left.
bool Session::is_left_on_gpu() const {
  const std::lock_guard lock(mutex_);
  return &(next_ ? next_->body : body_)->device() != &devices_.back();
}

void Session::build(const Order& order) {
  try {
    if (!order.gpu_error.empty() && may_leave_gpu())
      leave_gpu(devices_.back().label() + ": " + order.gpu_error, gpu_failed);
    if (!order.is_edit && !is_left_on_gpu()) return;
    Publication made = prepare(make(order.text, order.paints, order.revision));
    made.text = order.text;
    made.paints = order.paints;
    made.is_edit = order.is_edit;
    prepared_ = made;
    {
      // If several bodies wait for a busy player, only the last counts.
      const std::lock_guard lock(mutex_);
      made.is_edit = made.is_edit || (next_ && next_->is_edit);
      if (std::exchange(next_, std::move(made))) return;
    }
    player_->post_needed([this](Motion& motion) {
      std::optional<Publication> next;
      {
        const std::lock_guard lock(mutex_);
        next.swap(next_);
      }
      if (!next) return;
      auto& live = static_cast<LiveMotion&>(motion);
      ShownFrame frame;
      try {
        frame = live.take(next->body);
      } catch (const std::exception& error) {
        // If the GPU failed, the CPU takes over: player_events.
        if (is_left_to_cpu(error)) throw;
        // The old body is still there.
        return give_up(next->body->revision(), next->is_edit, error.what());
      }
      meter_.reset();  // it belonged to the old model
      {
        const std::lock_guard lock(mutex_);
        publish(*next);
        if (live.hand() == nullptr) let_go();
        if (next->body->device().gpu() == nullptr && end_of_takeover()) player_->play();
      }
      player_->show(frame);
      player_->hurry();
    });
  } catch (const build::Cancelled&) {
    // A newer text is waiting, or the session ends.
  } catch (const std::exception& error) {
    give_up(order.revision, order.is_edit, error.what());
  }
}

// After a body that could not be built, or not be taken over by the player.
void Session::give_up(std::uint32_t revision, bool is_edit, const std::string& error) {
  if (is_edit)
    take_back(revision, error);
  else
    pipeline::say_warning(say_, error);
  const std::lock_guard lock(mutex_);
  if (!awaits_cpu_) return;
  if (is_edit) {
    // The text on show is still to be built for the CPU.
    gpu_error_ = gpu_failed;
    builder_wakes_.notify_all();
  } else if (revision_ == built_) {
    // The next attempt to play tries again.
    (void)end_of_takeover();
    broadcast({{"type", "failed"}, {"what", "motion"}, {"error", error}});
  }
}

// With the mutex held. Returns whether the playback that was interrupted should go on.
bool Session::end_of_takeover() {
  awaits_cpu_ = false;
  if (player_message_ == gpu_left) {
    player_message_.clear();
    broadcast(player_json());
  }
  return std::exchange(resumes_, false);
}

Session::Publication Session::prepare(const std::shared_ptr<RunningBody>& body) {
  // Another file has other looks, and the same file read differently has vertices that they do not match.
  if (const std::filesystem::path file = scene::character_file(body->scene());
      prepared_.number == 0 || file != looks_of_ ||
      body->model().surface_count() != prepared_.body->model().surface_count()) {
    looks_ = read_body_looks(file, body->model(), say_);
    looks_of_ = file;
  }
  const BodyParts parts{body->model(), &body->built().report, &body->scene()};
  Publication made;
  made.body = body;
  made.places = workshop_->places(body->scene(), prepared_.places);
  const std::uint32_t number = prepared_.number + 1;
  made.arrays = array_messages(parts, looks_, number, prepared_.arrays);
  made.body_message = body_json(parts, looks_, number, made.arrays);
  made.number = number;
  Json old = prepared_.body_message;
  if (!old.is_null()) old["body"] = number;
  const bool is_same =
      old == made.body_message &&
      std::equal(made.arrays.begin(), made.arrays.end(), prepared_.arrays.begin(), prepared_.arrays.end(),
                 [](const ArrayMessage& a, const ArrayMessage& b) { return a.bytes == b.bytes; });
  if (is_same) {
    made.number = prepared_.number;
    made.body_message = prepared_.body_message;
  }
  made.clip_message =
      clip_json(body->scene(), body->frames(), body->built().steps.substeps, body->built().steps.iterations);
  made.warnings_message = {{"type", "warnings"},
                           {"list", warnings_json(body->model(), body->built().report.warnings)}};
  return made;
}

// Sends pages what they do not have yet.
void Session::publish(const Publication& made) {
  const bool is_new = made.number != body_number_;
  const std::vector<ArrayMessage> before = std::exchange(arrays_, made.arrays);
  const bool has_same_places = places_ == made.places;
  const bool paints_otherwise =
      !has_same_places || body_->scene().solver.integrator != made.body->scene().solver.integrator;
  body_ = made.body;
  places_ = made.places;
  running_text_ = made.text;
  running_paints_ = made.paints;
  body_number_ = made.number;
  body_message_ = made.body_message;
  if (is_new) {
    broadcast(body_message_);
    for (const ArrayMessage& array : arrays_) {
      const bool is_known = std::any_of(before.begin(), before.end(),
                                        [&](const ArrayMessage& old) { return old.bytes == array.bytes; });
      for (const auto& [page, state] : pages_)
        if (!is_known && server_ != nullptr) server_->send_binary(page, array.bytes);
    }
  }
  if (is_new || clip_message_ != made.clip_message) broadcast(made.clip_message);
  if (is_new || warnings_message_ != made.warnings_message) broadcast(made.warnings_message);
  clip_message_ = made.clip_message;
  warnings_message_ = made.warnings_message;
  broadcast(presets_message());
  if (paints_otherwise) {
    if (!has_same_places) stroke_.reset();  // it was on another mesh
    send_paint(std::nullopt);
  }
  if (is_new) broadcast({{"type", "ready"}});
}

// On the player's thread, with the mutex held: reports changes as applied, with the first frame that shows
// them.
void Session::tell_applied(const FrameNumbers& numbers) {
  if (pending_.empty() || pending_.front().revision > numbers.revision) return;
  // Where nothing moves or nobody looks, no frame is computed; the present one then counts as the first.
  if (!(numbers.seconds > 0.0f) && !pages_.empty() && player_->state().mode == PlayerMode::playing) return;
  if (body_->revision() == numbers.revision && history_->note_built(running_text_, running_paints_))
    autosave();
  Pending last = pending_.front();
  while (!pending_.empty() && pending_.front().revision <= numbers.revision) {
    const bool was_rebuild = last.is_rebuild;
    last = pending_.front();
    last.is_rebuild = last.is_rebuild || was_rebuild;
    pending_.erase(pending_.begin());
  }
  const std::chrono::duration<double> seconds = Clock::now() - last.since;
  if (!player_message_.empty() && pending_.empty()) {
    player_message_.clear();
    broadcast(player_json());
  }
  broadcast({{"type", "applied"},
             {"revision", last.revision},
             {"effect", last.is_rebuild ? "rebuild" : "live"},
             {"seconds", seconds.count()},
             {"sequence", numbers.sequence}});
}

// Restores the text of the live body, so nothing needs to be built.
void Session::take_back(std::uint32_t revision, const std::string& error) {
  const std::lock_guard lock(mutex_);
  // A newer text is waiting and will report its own errors.
  if (revision_ != revision) return;
  broadcast({{"type", "failed"}, {"what", "change"}, {"revision", revision}, {"error", error}});
  const Paints painted = history_->paints();
  history_->fall_back(next_ ? next_->text : running_text_, next_ ? next_->paints : running_paints_);
  player_message_ = awaits_cpu_ ? gpu_left : "";
  try {
    take_text(std::exchange(tables_, scene::edited_tables(history_->text(), source_)), painted, true);
  } catch (const std::exception& failure) {
    pipeline::say_warning(say_, failure.what());
  }
  broadcast(player_json());
}

}  // namespace fascicle::studio
