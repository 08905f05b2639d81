// The commands that a page may send: docs/design/studio.md. A message is parsed and checked in full before
// anything is done.
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

// A refused message. what() says what is wrong and what to do; `id` is the message's, if it could be read.
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

// Part of a brush stroke.
struct StrokePiece {
  std::uint64_t stroke = 0;  // pieces with the same number form one change
  bool is_last = true;
  Brush brush;
  std::vector<std::array<double, 3>> places;  // m, in the bind pose, in order
  std::array<double, 3> direction{0, 0, 0};   // if the stroke has only one place
};

struct Command {
  std::optional<std::int64_t> id;
  Verb verb = Verb::play;
  std::uint16_t blocks = 0;               // show: bits of Block
  std::uint16_t beside_blocks = 0;        // show: likewise for the comparison bake
  std::uint64_t frame = 0;                // seek
  double factor = 1.0;                    // speed
  bool is_on = false;                     // loop
  std::vector<scene::KeyChange> changes;  // set
  std::string label;                      // set
  std::optional<std::uint64_t> gesture;   // set
  std::string name;                       // preset; save: file, bake: folder; empty: default; beside: a
                                          // bake's name, or empty for none
  HandAction action = HandAction::release;
  std::uint64_t vertex = 0;
  bool is_of_model = false;               // the vertex is of the model, not of the render mesh
  double radius = 0.0;                    // m; 0: default
  std::array<double, 3> vector{0, 0, 0};  // a place, m, or a force, N
  std::vector<std::string> formats;       // bake
  bool overwrite = false;                 // save, bake
  StrokePiece piece;                      // paint
};

// Throws BadMessage.
Command parse_command(std::string_view text);

// A name without folders: letters, digits, `-`, `_` and `.`, not beginning with a dot, at most 64 characters.
bool is_plain_name(std::string_view name);

}  // namespace fascicle::studio
