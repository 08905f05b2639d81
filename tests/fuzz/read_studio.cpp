#include <algorithm>
#include <array>
#include <span>
#include <string>

#include "host/scene/scene.h"
#include "host/scene/scene_edit.h"
#include "host/studio/commands.h"
#include "host/studio/session_file.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/taken.h"

namespace fascicle::fuzz {
namespace {

// As the studio does with each step that it goes to.
void edit(const std::string& text, const std::string& source) {
  (void)scene::edited_tables(text, source);
  const std::array changes{scene::KeyChange{"scene.fps", scene::Json(24.0)},
                           scene::KeyChange{"scene.end", std::nullopt}};
  for (const scene::KeyChange& change : changes)
    (void)scene::edited_tables(scene::change_text(text, source, std::span(&change, 1)).text, source);
}

}  // namespace

bool message(std::string_view bytes) {
  return is_taken<studio::BadMessage>([&] { studio::parse_command(bytes); });
}

bool session(std::string_view bytes) {
  const auto record = studio::parse_session(std::string(bytes));
  if (!record) return false;
  // A step of a wrong text is refused alone, so all of them are tried.
  return std::count_if(record->steps.begin(), record->steps.end(), [&](const studio::HistoryStep& step) {
           return !is_taken<scene::SceneError>([&] { edit(step.text, record->source); });
         }) == 0;
}

}  // namespace fascicle::fuzz
