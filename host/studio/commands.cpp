#include "host/studio/commands.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

#include "host/bake/options.h"
#include "host/base/json_text.h"
#include "host/base/nearest_name.h"
#include "host/base/text.h"
#include "host/studio/wire.h"

namespace fascicle::studio {
namespace {

constexpr unsigned deepest = 16;
constexpr std::size_t most_changes = 256, most_formats = 32, longest_text = 4096, longest_name = 64;
constexpr double farthest = 1e6;  // m, N
constexpr double slowest = 0.01, fastest = 4.0;

constexpr std::size_t most_stroke_places = 256;
constexpr unsigned most_keys = 1000;
constexpr double largest_brush = 1e3;  // m
constexpr std::array<std::string_view, 19> verbs{
    "show", "play",   "pause", "step",   "seek", "speed", "loop",   "restart", "set",   "undo",
    "redo", "preset", "hand",  "record", "save", "bake",  "cancel", "paint",   "beside"};
constexpr std::array<std::string_view, 3> falloffs{"smooth", "linear", "constant"};
constexpr std::array<std::string_view, 4> hand_actions{"grab", "move", "release", "force"};

template <std::size_t count>
std::optional<std::size_t> find(const std::array<std::string_view, count>& names, std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names.begin());
}

template <std::size_t count>
std::string hint(const std::array<std::string_view, count>& names, const std::string& name) {
  return base::nearest_name_hint(name, std::vector<std::string>(names.begin(), names.end()));
}

Json parse_json(std::string_view text) {
  constexpr unsigned any_number = std::numeric_limits<unsigned>::max();
  if (!text.empty() && base::shallow_json(text, any_number, deepest).empty())
    throw BadMessage("nested deeper than " + std::to_string(deepest) + " levels");
  try {
    // The session waits while a message is read, so an object's keys, each compared with all before it, must
    // be few.
    return Json::parse(base::shallow_json(text, most_keys));
  } catch (const Json::exception&) {
    throw BadMessage("not valid JSON, or too large an object");
  }
}

// The members of a message; each is taken once, and those left at the end are unknown.
class Members {
 public:
  explicit Members(Json message) : message_(std::move(message)) {
    if (!message_.is_object()) throw BadMessage("a message must be one JSON object");
    id_ = integer("id", -9e15, 9e15);
  }
  std::optional<std::int64_t> id() const { return id_; }

  [[noreturn]] void refuse(const std::string& text) const { throw BadMessage(text, id_); }

  std::optional<std::string> text(const char* name, std::size_t longest = longest_text) {
    const std::optional<Json> value = take(name);
    if (!value) return std::nullopt;
    if (!value->is_string()) refuse(std::string(name) + " takes text");
    const auto text = value->get<std::string>();
    if (text.size() > longest)
      refuse(std::string(name) + " has more than " + std::to_string(longest) + " bytes");
    return text;
  }
  std::string must_text(const char* name) { return must(text(name), name); }

  std::optional<double> number(const char* name, double least, double most) {
    const std::optional<Json> value = take(name);
    if (!value) return std::nullopt;
    return number_of(*value, name, least, most);
  }
  double must_number(const char* name, double least, double most) {
    return must(number(name, least, most), name);
  }

  std::optional<std::int64_t> integer(const char* name, double least, double most) {
    const std::optional<Json> value = take(name);
    if (!value) return std::nullopt;
    const double number = number_of(*value, name, least, most);
    if (number != std::floor(number)) refuse(std::string(name) + " takes a whole number");
    return static_cast<std::int64_t>(number);
  }
  std::uint64_t must_count(const char* name, double most) {
    return static_cast<std::uint64_t>(must(integer(name, 0.0, most), name));
  }

  std::optional<bool> truth(const char* name) {
    const std::optional<Json> value = take(name);
    if (!value) return std::nullopt;
    if (!value->is_boolean()) refuse(std::string(name) + " takes true or false");
    return value->get<bool>();
  }

  std::array<double, 3> must_vector(const char* name) { return vector_of(must(take(name), name), name); }
  std::optional<std::array<double, 3>> vector(const char* name) {
    const std::optional<Json> value = take(name);
    if (!value) return std::nullopt;
    return vector_of(*value, name);
  }
  std::vector<std::array<double, 3>> must_vectors(const char* name, std::size_t most) {
    const Json value = must(take(name), name);
    if (!value.is_array() || value.empty() || value.size() > most)
      refuse(std::string(name) + " takes a list of 1 to " + std::to_string(most) + " places");
    std::vector<std::array<double, 3>> vectors;
    for (const Json& one : value) vectors.push_back(vector_of(one, name));
    return vectors;
  }

  std::vector<std::string> texts(const char* name, std::size_t most) {
    const std::optional<Json> value = take(name);
    if (!value) return {};
    if (!value->is_array() || value->size() > most)
      refuse(std::string(name) + " takes a list of at most " + std::to_string(most) + " texts");
    std::vector<std::string> list;
    for (const Json& one : *value) {
      if (!one.is_string() || one.get_ref<const std::string&>().size() > longest_name)
        refuse(std::string(name) + " takes a list of short texts");
      list.push_back(one.get<std::string>());
    }
    return list;
  }

  Json must_object(const char* name, std::size_t most) {
    Json value = must(take(name), name);
    if (!value.is_object() || value.empty() || value.size() > most)
      refuse(std::string(name) + " takes an object of 1 to " + std::to_string(most) + " members");
    return value;
  }

  void end() const {
    for (const auto& [name, value] : message_.items())
      refuse("\"" + base::shown_text(name.substr(0, longest_name)) + "\" is not a member of this message");
  }

 private:
  std::optional<Json> take(const char* name) {
    const auto found = message_.find(name);
    if (found == message_.end()) return std::nullopt;
    Json value = std::move(*found);
    message_.erase(found);
    return value;
  }
  template <class T>
  T must(std::optional<T> value, const char* name) const {
    if (!value) refuse(std::string(name) + " is missing");
    return std::move(*value);
  }
  std::array<double, 3> vector_of(const Json& value, const char* name) const {
    if (!value.is_array() || value.size() != 3) refuse(std::string(name) + " takes three numbers");
    std::array<double, 3> vector{};
    for (std::size_t a = 0; a < 3; ++a) vector[a] = number_of(value[a], name, -farthest, farthest);
    return vector;
  }
  double number_of(const Json& value, const char* name, double least, double most) const {
    if (!value.is_number()) refuse(std::string(name) + " takes a number");
    const auto number = value.get<double>();
    if (!(number >= least && number <= most))
      refuse(std::string(name) + " must be from " + base::number_text(least) + " to " +
             base::number_text(most));
    return number;
  }

  Json message_;
  std::optional<std::int64_t> id_;
};

std::uint16_t blocks_of(Members& members, const char* list) {
  unsigned blocks = 0;
  for (const std::string& name : members.texts(list, block_names.size())) {
    const auto bit = find(block_names, name);
    if (!bit) members.refuse("\"" + base::shown_text(name) + "\" is not a block" + hint(block_names, name));
    blocks |= 1u << *bit;
  }
  return static_cast<std::uint16_t>(blocks);
}

void read_set(Members& members, Command& command) {
  const Json changes = members.must_object("changes", most_changes);
  for (const auto& [path, value] : changes.items()) {
    if (path.empty() || path.size() > longest_text) members.refuse("a key's path is empty or too long");
    command.changes.push_back({path, value.is_null() ? std::nullopt : std::optional<Json>(value)});
  }
  command.label = members.text("label", 200).value_or("");
  if (const auto gesture = members.integer("gesture", 0.0, 9e15))
    command.gesture = static_cast<std::uint64_t>(*gesture);
}

void read_hand(Members& members, Command& command) {
  const std::string word = members.must_text("action");
  const auto action = find(hand_actions, word);
  if (!action)
    members.refuse("\"" + base::shown_text(word) + "\" is not an action" + hint(hand_actions, word));
  command.action = static_cast<HandAction>(*action);
  if (command.action == HandAction::release) return;
  if (command.action == HandAction::force) {
    command.vector = members.must_vector("force");
  } else {
    command.vector = members.must_vector("place");
  }
  if (command.action == HandAction::move) return;
  command.vertex = members.must_count("vertex", 4e9);
  const std::string of = members.text("of").value_or("surface");
  if (of != "surface" && of != "vertices") members.refuse("of takes \"surface\" or \"vertices\"");
  command.is_of_model = of == "vertices";
  command.radius = members.number("radius", 0.0, farthest).value_or(0.0);
}

void read_save(Members& members, Command& command) {
  command.name = members.text("file").value_or("");
  command.overwrite = members.truth("overwrite").value_or(false);
  if (!command.name.empty() && (!is_plain_name(command.name) || !command.name.ends_with(".toml")))
    members.refuse("file takes a name without folders, of letters, digits, -, _ and ., that ends in .toml");
}

void read_bake(Members& members, Command& command) {
  command.name = members.text("folder").value_or("");
  command.overwrite = members.truth("overwrite").value_or(false);
  if (!command.name.empty() && !is_plain_name(command.name))
    members.refuse("folder takes a name without folders, of letters, digits, -, _ and .");
  const std::vector<std::string> known = bake::accepted_formats();
  for (const std::string& format : members.texts("formats", most_formats)) {
    if (std::find(known.begin(), known.end(), format) == known.end())
      members.refuse("\"" + base::shown_text(format) + "\" is not a format" +
                     base::nearest_name_hint(format, known));
    command.formats.push_back(format);
  }
}

void read_paint(Members& members, StrokePiece& piece) {
  const std::string attribute = members.must_text("attribute");
  Brush& brush = piece.brush;
  brush.kind = rig::find_paint_kind(attribute);
  if (brush.kind == nullptr) {
    std::vector<std::string> names;
    for (const rig::PaintKind& kind : rig::paint_kinds()) names.emplace_back(kind.name);
    members.refuse("\"" + base::shown_text(attribute.substr(0, longest_name)) + "\" cannot be painted" +
                   base::nearest_name_hint(attribute, names));
  }
  brush.erases = members.truth("erase").value_or(false);
  if (!brush.erases && !brush.kind->is_direction) {
    const double value = members.must_number("value", brush.kind->least, brush.kind->most);
    if (brush.kind->is_whole && value != std::floor(value)) members.refuse("value takes a whole number");
    brush.value = static_cast<float>(value);
  }
  brush.radius = members.must_number("radius", 0.0, largest_brush);
  brush.strength = members.number("strength", 0.0, 1.0).value_or(1.0);
  const std::string falloff = members.text("falloff").value_or(std::string(falloffs[0]));
  const auto found = find(falloffs, falloff);
  if (!found)
    members.refuse("\"" + base::shown_text(falloff.substr(0, longest_name)) + "\" is not a falloff" +
                   hint(falloffs, falloff));
  brush.falloff = static_cast<Falloff>(*found);
  brush.is_mirrored = members.truth("mirror").value_or(false);
  piece.places = members.must_vectors("places", most_stroke_places);
  piece.direction = members.vector("direction").value_or(piece.direction);
  piece.stroke = members.must_count("stroke", 9e15);
  piece.is_last = members.truth("last").value_or(true);
}

}  // namespace

bool is_plain_name(std::string_view name) {
  if (name.empty() || name.size() > longest_name || name.front() == '.') return false;
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_' || c == '.';
  });
}

Command parse_command(std::string_view text) {
  Members members(parse_json(text));
  Command command;
  command.id = members.id();
  const std::string word = members.must_text("type");
  const auto verb = find(verbs, word);
  if (!verb)
    members.refuse("\"" + base::shown_text(word.substr(0, longest_name)) + "\" is not a message" +
                   hint(verbs, word));
  command.verb = static_cast<Verb>(*verb);
  switch (command.verb) {
    case Verb::show:
      command.blocks = blocks_of(members, "blocks");
      command.beside_blocks = blocks_of(members, "beside");
      break;
    case Verb::seek:
      command.frame = members.must_count("frame", 1e9);
      break;
    case Verb::speed:
      command.factor = members.must_number("factor", slowest, fastest);
      break;
    case Verb::loop:
      if (const auto on = members.truth("on"))
        command.is_on = *on;
      else
        members.refuse("on is missing");
      break;
    case Verb::set:
      read_set(members, command);
      break;
    case Verb::preset:
      command.name = members.must_text("name");
      break;
    case Verb::hand:
      read_hand(members, command);
      break;
    case Verb::save:
      read_save(members, command);
      break;
    case Verb::bake:
      read_bake(members, command);
      break;
    case Verb::paint:
      read_paint(members, command.piece);
      break;
    case Verb::beside:
      command.name = members.must_text("name");
      break;
    default:
      break;
  }
  members.end();
  return command;
}

}  // namespace fascicle::studio
