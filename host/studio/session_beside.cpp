// The comparison bake. It is opened, read and closed on the player's thread.
#include <utility>

#include "host/base/text.h"
#include "host/studio/session.h"

namespace fascicle::studio {

Json Session::beside_message() const {
  Json names = Json::array();
  for (const BesideChoice& choice : beside_choices(options_.beside, options_.folder))
    names.push_back(choice.name);
  return {{"type", "beside"},
          {"choices", std::move(names)},
          {"bake", beside_ ? beside_->description() : Json(nullptr)}};
}

void Session::send_beside(PageId page, const Json& message) {
  send(page, message);
  if (!beside_ || server_ == nullptr) return;
  for (const ArrayMessage& array : beside_->arrays()) server_->send_binary(page, array.bytes);
}

// The name must be one of the choices and is never used as a path, so a page cannot reach other folders.
void Session::choose_beside(const std::string& name) {
  std::optional<BesideChoice> chosen;
  for (BesideChoice& choice : beside_choices(options_.beside, options_.folder))
    if (choice.name == name) chosen = std::move(choice);
  if (!chosen && !name.empty())
    throw std::runtime_error(
        "\"" + base::shown_text(name.substr(0, 256)) +
        "\" is not a bake of this session; start fascicle studio with --beside and its folder");
  if (!player_->post([this, chosen](Motion& motion) {
        put_beside(chosen);
        player_->show(motion.again());
      }))
    throw std::runtime_error(too_many_wait);
}

// On the player's thread. If the bake cannot be opened, the previous one stays.
void Session::put_beside(const std::optional<BesideChoice>& choice) {
  std::unique_ptr<BesideBake> next;
  try {
    if (choice) next = std::make_unique<BesideBake>(*choice);
  } catch (const std::exception& error) {
    const std::lock_guard lock(mutex_);
    return broadcast({{"type", "failed"}, {"what", "beside"}, {"error", error.what()}});
  }
  const std::lock_guard lock(mutex_);
  beside_ = std::move(next);
  broadcast_beside();
}

void Session::broadcast_beside() {
  if (pages_.empty()) return;
  const Json message = beside_message();  // reads folders
  for (const auto& [page, state] : pages_) send_beside(page, message);
}

// On the player's thread: the comparison bake's frame for the current time; nullopt if there is no such bake.
std::optional<ShownFrame> Session::frame_beside(const Motion& motion) {
  if (!beside_) return std::nullopt;
  try {
    return beside_->at(motion.start() + static_cast<double>(motion.frame()) / motion.fps());
  } catch (const std::exception& error) {
    put_beside(std::nullopt);
    const std::lock_guard lock(mutex_);
    broadcast({{"type", "failed"}, {"what", "beside"}, {"error", error.what()}});
    return std::nullopt;
  }
}

}  // namespace fascicle::studio
