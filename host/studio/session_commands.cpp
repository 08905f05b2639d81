// What a page asks for: each command goes to the part of the session that carries it out.
#include <algorithm>
#include <array>

#include "host/base/text.h"
#include "host/studio/scene_keys.h"
#include "host/studio/session.h"

namespace fascicle::studio {

namespace {

constexpr unsigned gesture_bits = 40;

}  // namespace

void Session::obey(PageId page, const Command& command) {
  // Finish the stroke before these commands.
  constexpr std::array after_strokes{Verb::set,    Verb::preset, Verb::undo, Verb::redo,
                                     Verb::record, Verb::save,   Verb::bake};
  if (std::find(after_strokes.begin(), after_strokes.end(), command.verb) != after_strokes.end())
    end_stroke();
  switch (command.verb) {
    case Verb::show:
      pages_.at(page).blocks = command.blocks;
      pages_.at(page).beside_blocks = command.beside_blocks;
      player_->post([this](Motion& motion) {
        if (player_->state().mode == PlayerMode::paused) player_->show(motion.again());
      });
      break;
    case Verb::play:
    case Verb::pause:
    case Verb::step:
    case Verb::seek:
    case Verb::speed:
    case Verb::loop:
    case Verb::restart:
      obey_player(command);
      break;
    case Verb::set:
      must_be_live();
      // Each page counts gestures from 1.
      set_keys(command.changes, command.label.empty() ? command.changes.front().path : command.label,
               command.gesture ? std::optional((page << gesture_bits) ^ *command.gesture) : std::nullopt);
      break;
    case Verb::preset: {
      must_be_live();
      for (const Preset& preset : presets_of(*body_, tables_)) {
        if (preset.name != command.name) continue;
        if (!preset.why_not.empty()) throw std::runtime_error(preset.title + ": " + preset.why_not);
        set_keys(preset.changes, preset.title, std::nullopt);
        return answer_done(page, command);
      }
      throw BadMessage("\"" + base::shown_text(command.name.substr(0, 64)) + "\" is not a preset",
                       command.id);
    }
    case Verb::undo:
    case Verb::redo:
      must_be_live();
      step_in_history(command.verb == Verb::undo);
      break;
    case Verb::hand:
      must_be_live();
      obey_hand(page, command);
      break;
    case Verb::record:
      must_be_live();
      record();
      break;
    case Verb::save: {
      must_be_live();
      Json answer{{"type", "saved"}};
      (void)save(command, answer);
      broadcast(answer);
      broadcast(history_json());
      break;
    }
    case Verb::bake:
      must_be_live();
      bake(command);
      break;
    case Verb::paint:
      must_be_live();
      paint(page, command.piece);
      break;
    case Verb::beside:
      choose_beside(command.name);
      break;
    case Verb::cancel:
      stops_bake_ = true;
      player_->cancel();
      break;
  }
  answer_done(page, command);
}

void Session::obey_player(const Command& command) {
  if (command.verb == Verb::play || command.verb == Verb::pause || command.verb == Verb::step) {
    is_to_play_ = command.verb == Verb::play;
    resumes_ = is_to_play_ && awaits_cpu_;
  }
  const bool is_taken = [&] {
    switch (command.verb) {
      case Verb::play:
        return player_->play();
      case Verb::pause:
        return player_->pause();
      case Verb::step:
        return player_->step();
      case Verb::seek:
        return player_->seek(command.frame);
      case Verb::speed:
        return player_->set_speed(command.factor);
      case Verb::loop:
        return player_->set_loop(command.is_on);
      default:
        return player_->restart();
    }
  }();
  if (!is_taken) throw std::runtime_error(too_many_wait);
}

void Session::obey_hand(PageId page, const Command& command) {
  if (command.action == HandAction::grab || command.action == HandAction::force) {
    if (hand_of_ && *hand_of_ != page) throw std::runtime_error("another page is holding the flesh");
    const model::Model& model = body_->model();
    std::uint64_t vertex = command.vertex;
    if (!command.is_of_model) {
      if (vertex >= model.surface_count()) throw std::runtime_error("the render mesh has no such vertex");
      // The vertex of largest weight of the four that embed it.
      const auto first = model.surface_weight.begin() + static_cast<std::ptrdiff_t>(4 * vertex);
      const auto most = static_cast<std::size_t>(std::max_element(first, first + 4) - first);
      vertex = model.surface_vertex[4 * vertex + most];
    }
    if (vertex >= model.vertex_count) throw std::runtime_error("the model has no such vertex");
    const bool is_taken = player_->post([this, page, command, vertex, body = body_number_](Motion& motion) {
      auto& live = static_cast<LiveMotion&>(motion);
      const Vector3d place(command.vector[0], command.vector[1], command.vector[2]);
      std::size_t held = 0;
      {
        const std::lock_guard lock(mutex_);
        if (hand_of_ != page) return;
        if (body != body_number_) return let_go();
      }
      held = live.grab(static_cast<std::uint32_t>(vertex), command.radius, place);
      if (held > 0 && command.action == HandAction::force) live.hand()->push(place);
      const std::lock_guard lock(mutex_);
      if (held == 0) hand_of_.reset();
      broadcast({{"type", "hand"}, {"is_held", held > 0}, {"vertices", held}});
    });
    if (!is_taken) throw std::runtime_error(too_many_wait);
    hand_of_ = page;
    return;
  }
  if (hand_of_ != page) throw std::runtime_error("this page is not holding any flesh");
  if (command.action == HandAction::move) {
    // If several targets wait, only the last counts.
    const bool waits = hand_place_.has_value();
    hand_place_ = Vector3d(command.vector[0], command.vector[1], command.vector[2]);
    if (waits) return;
    player_->post_needed([this](Motion& motion) {
      std::optional<Vector3d> place;
      {
        const std::lock_guard lock(mutex_);
        place.swap(hand_place_);
      }
      Hand* hand = static_cast<LiveMotion&>(motion).hand();
      if (hand != nullptr && place) hand->move(*place);
    });
    return;
  }
  let_go();
  release_hand();
}

// Lets go of the flesh, between two frames. One release is enough for all that wait: a grab after it that is
// no longer wanted finds hand_of_ empty.
void Session::release_hand() {
  if (std::exchange(release_waits_, true)) return;
  player_->post_needed([this](Motion& motion) {
    {
      const std::lock_guard lock(mutex_);
      release_waits_ = false;
    }
    static_cast<LiveMotion&>(motion).release();
  });
}

}  // namespace fascicle::studio
