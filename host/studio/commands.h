// What a page may ask: docs/design/studio.md. A message is read whole and checked before anything is done.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/scene/scene_edit.h"
#include "host/scene/scene_json.h"
#include "host/studio/brush.h"

namespace fascicle::studio {

using scene::Json;

// A message that is refused. what() says what is wrong and what to do; `id` is the message's, where it could
// be read.
struct BadMessage : std::runtime_error {
  explicit BadMessage(const std::string& text, std::optional<std::int64_t> message_id = std::nullopt)
      : std::runtime_error(text), id(message_id) {}
  std::optional<std::int64_t> id;
};

enum class Verb {
  show,
  play,
  pause,
  step,
  seek,
  speed,
  loop,
  restart,
  set,
  undo,
  redo,
  preset,
  hand,
  record,
  save,
  bake,
  cancel,
  paint,
  beside
};

enum class HandAction { grab, move, release, force };

// A piece of a stroke of the brush.
struct StrokePiece {
  std::uint64_t stroke = 0;  // pieces of one number are one change
  bool is_last = true;
  Brush brush;
  std::vector<std::array<double, 3>> places;  // m, of the bind pose, one after the other
  std::array<double, 3> direction{0, 0, 0};   // where the stroke has one place alone
};

struct Command {
  std::optional<std::int64_t> id;
  Verb verb = Verb::play;
  std::uint16_t blocks = 0;               // show: of Block
  std::uint16_t beside_blocks = 0;        // show: the same of the bake beside
  std::uint64_t frame = 0;                // seek
  double factor = 1.0;                    // speed
  bool is_on = false;                     // loop
  std::vector<scene::KeyChange> changes;  // set
  std::string label;                      // set
  std::optional<std::uint64_t> gesture;   // set
  std::string name;                       // preset; save's file, bake's folder: empty where not given;
                                          // beside: a bake's name, or empty for none
  HandAction action = HandAction::release;
  std::uint64_t vertex = 0;
  bool is_of_model = false;               // the vertex is the model's, not the render mesh's
  double radius = 0.0;                    // m; 0: one that fits
  std::array<double, 3> vector{0, 0, 0};  // a place, m, or a force, N
  std::vector<std::string> formats;       // bake
  bool overwrite = false;                 // save, bake
  StrokePiece piece;                      // paint
};

// Throws BadMessage.
Command parse_command(std::string_view text);

// A name without folders, of letters, digits, `-`, `_` and `.`, that does not begin with a dot and has at
// most 64 characters.
bool is_plain_name(std::string_view name);

}  // namespace fascicle::studio
