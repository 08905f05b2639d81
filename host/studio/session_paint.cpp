// Painting in the session: brush strokes become changes of a paint file's text.
#include <algorithm>
#include <map>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "host/scene/input_files.h"
#include "host/scene/paint_file.h"
#include "host/studio/scene_keys.h"
#include "host/studio/session.h"
#include "host/studio/wire.h"

namespace fascicle::studio {

namespace {

// A stroke's label in the history.
std::string label_of(const rig::PaintKind& kind) {
  const std::string name = kind.name;
  return name == "_RIGID"   ? "paint rigid parts"
         : name == "_LAYER" ? "paint layers"
         : name == "_FIBER" ? "paint fibres"
                            : "paint stiffness";
}

}  // namespace

PaintText Session::read_paint_file(const std::string& key, const std::string& name) const {
  try {
    return std::make_shared<const std::string>(
        scene::read_text_file(source_folder_ / name, scene::most_paint_bytes));
  } catch (const scene::InputFileError& error) {
    throw scene::SceneError(key + ": " + error.what());
  }
}

// The paints for the next text: existing paint stays if its file has the same name.
Paints Session::paints_after(const std::vector<scene::EditedTable>& after) const {
  const std::map<std::string, std::string> files_before = paint_files(tables_);
  Paints paints;
  for (const auto& [key, file] : paint_files(after)) {
    const auto before = files_before.find(key);
    const bool is_same_file = history_ && before != files_before.end() && before->second == file;
    const auto known = is_same_file ? history_->paints().find(key) : paints.end();
    if (is_same_file && known != history_->paints().end())
      paints[key] = known->second;
    else
      paints[key] = read_paint_file(key, file);
  }
  return paints;
}

// Without a copy: paints of many megabytes may be shared by many characters.
std::string hash_of_all(std::string_view text, const Paints& paints) {
  std::vector<std::string_view> texts{text};
  for (const auto& [key, paint] : paints) texts.push_back(*paint);
  return scene::hash_of(texts);
}

// Of the current text and paint.
std::string Session::state_hash() const {
  return hash_of_all(history_->text(), history_->paints());
}

std::string paint_name_of(const std::string& stem, const std::string& key) {
  if (key == paint_path) return stem + paint_suffix;
  // A character's name has only characters that are valid in file names everywhere.
  const std::size_t begin = key.find('.') + 1;
  return stem + "-" + key.substr(begin, key.rfind('.') - begin) + paint_suffix;
}

// Empty if painting is possible.
std::string Session::why_no_paint() const {
  const bool has_any =
      std::any_of(places_.begin(), places_.end(), [](const PaintPlace& one) { return !one.is_rigid; });
  return has_any ? "" : "only a character, [character] or [character.NAME], can be painted";
}

// The largest paintable value. Alpha is at most 1, but a modulus can be multiplied by more.
double Session::most_painted(const rig::PaintKind& kind) const {
  const bool is_stiffness = kind.name == std::string_view("_STIFFNESS");
  return is_stiffness && body_->scene().solver.integrator == base::Integrator::explicit_step ? 1.0
                                                                                             : kind.most;
}

std::vector<Painting> Session::paintings_in_force() const {
  std::vector<Painting> paintings;
  for (const PaintPlace& one : places_) {
    const auto text = history_->paints().find(one.key);
    const rig::Paint none{one.ground->hash(), one.ground->surface().vertices.size(), {}};
    try {
      paintings.emplace_back(one.ground,
                             text != history_->paints().end()
                                 ? scene::parse_paint(*text->second, one.key, one.ground->surface())
                                 : none);
    } catch (const scene::InputFileError& error) {
      throw std::runtime_error(error.what());
    }
  }
  return paintings;
}

void Session::paint(PageId page, const StrokePiece& piece) {
  const rig::PaintKind& kind = *piece.brush.kind;
  if (const std::string why = why_no_paint(); !why.empty()) throw std::runtime_error(why);
  if (const double most = most_painted(kind); double{piece.brush.value} > most)
    throw std::runtime_error("alpha is at most 1, and painted stiffness multiplies it; paint 1 or less");
  if (reaches_too_many(piece.brush, places_, piece.places)) {
    // The page sends no more pieces of a stroke that was refused.
    if (stroke_) end_stroke();
    throw std::runtime_error(
        "the brush reaches too many vertices at these places together; use a smaller radius");
  }
  if (stroke_ && (stroke_->page != page || stroke_->number != piece.stroke || stroke_->kind != &kind))
    end_stroke();
  const auto vector_of = [](const std::array<double, 3>& v) { return Vector3d(v[0], v[1], v[2]); };
  const bool is_first = !stroke_;
  if (is_first)
    stroke_.emplace(
        Stroke{page, piece.stroke, &kind, paintings_in_force(), std::vector<bool>(places_.size(), false)});
  for (std::size_t k = 0; k < piece.places.size(); ++k) {
    const Vector3d place = vector_of(piece.places[k]);
    const bool has_way = !is_first || k > 0;
    const Vector3d along = has_way ? Vector3d(place - stroke_->last) : vector_of(piece.direction);
    stroke_->last = place;
    // A stroke may cross to another character.
    const PaintPlace* under = place_under(places_, place);
    if (under == nullptr || under->is_rigid) continue;
    const auto at = static_cast<std::size_t>(under - places_.data());
    stroke_->paintings[at].stamp(piece.brush, place - under->offset, along);
    stroke_->is_stamped[at] = true;
  }
  send_sheet(stroke_->paintings, kind, std::nullopt);
  if (piece.is_last) end_stroke();
}

// Turns the stroke into an ordinary change. If that fails, pages are shown the current paint again.
void Session::end_stroke() {
  if (!stroke_) return;
  const Stroke stroke = *std::exchange(stroke_, std::nullopt);
  try {
    keep_stroke(stroke);
  } catch (const std::exception&) {
    send_paint(std::nullopt);
    throw;
  }
}

void Session::keep_stroke(const Stroke& stroke) {
  const Paints before = history_->paints();
  Paints after = before;
  std::map<std::string, std::string> files = paint_files(tables_);
  std::vector<scene::KeyChange> changes;
  for (std::size_t k = 0; k < places_.size(); ++k) {
    if (!stroke.is_stamped[k]) continue;
    const std::string& key = places_[k].key;
    const rig::Paint paint = stroke.paintings[k].paint();
    auto text = std::make_shared<const std::string>(scene::paint_text(paint));
    if (text->size() > scene::most_paint_bytes)
      throw std::runtime_error("the paint exceeds the limit of a paint file, " +
                               std::to_string(scene::most_paint_bytes >> 20) + " MiB");
    const auto known = before.find(key);
    if (known != before.end() ? *known->second == *text : paint.attributes.empty()) continue;
    after[key] = std::move(text);
    // Characters may share a file, but paint applies to only one of them.
    const auto file = files.find(key);
    const auto has_name = [&](const auto& other) { return other.second == file->second; };
    if (file != files.end() && std::count_if(files.begin(), files.end(), has_name) == 1) continue;
    std::string name = paint_name_of(name_, key);
    const auto is_taken = [&](const auto& other) { return other.second == name; };
    for (int n = 2; std::any_of(files.begin(), files.end(), is_taken); ++n)
      name = paint_name_of(name_ + "-" + std::to_string(n), key);
    files[key] = name;
    changes.push_back({key, Json(name)});
  }
  if (is_same(before, after)) return;
  std::string text = history_->text();
  if (!changes.empty()) text = scene::change_text(text, source_, changes).text;
  std::vector<scene::EditedTable> tables = scene::edited_tables(text, source_);
  history_->add(label_of(*stroke.kind), std::move(text), std::move(after));
  take_text(std::exchange(tables_, std::move(tables)), before);
}

// Values over the render mesh, which has the characters one after the other.
void Session::send_sheet(const std::vector<Painting>& paintings, const rig::PaintKind& kind,
                         std::optional<PageId> page) {
  if (server_ == nullptr) return;
  std::vector<float> values;
  for (const Painting& painting : paintings) {
    const std::vector<float> shown = painting.shown(kind);
    values.insert(values.end(), shown.begin(), shown.end());
  }
  const auto bytes = std::make_shared<const std::string>(
      encode_array(std::string("paint.") + kind.name, body_number_, std::span<const float>(values)));
  for (const auto& [each, state] : pages_)
    if (!page || *page == each) server_->send_binary(each, bytes);
}

// Sends what can be painted, then all paint.
void Session::send_paint(std::optional<PageId> page) {
  const std::string why = why_no_paint();
  Json message{{"type", "paint"}, {"can_paint", why.empty()}, {"why_not", why}};
  Json attributes = Json::array(), sheets = Json::array();
  std::vector<Painting> paintings;
  if (why.empty()) try {
      paintings = paintings_in_force();
    } catch (const std::runtime_error& error) {
      message["can_paint"] = false;
      message["why_not"] = error.what();
    }
  const auto has = [&](const rig::PaintKind& kind) {
    return std::any_of(paintings.begin(), paintings.end(),
                       [&](const Painting& painting) { return painting.has(kind); });
  };
  for (const rig::PaintKind& kind : rig::paint_kinds()) {
    attributes.push_back({{"name", kind.name}, {"why_not", ""}, {"most", most_painted(kind)}});
    if (has(kind)) sheets.push_back(std::string("paint.") + kind.name);
  }
  message["attributes"] = std::move(attributes);
  message["arrays"] = std::move(sheets);
  page ? send(*page, message) : broadcast(message);
  for (const rig::PaintKind& kind : rig::paint_kinds())
    if (has(kind)) send_sheet(paintings, kind, page);
}

}  // namespace fascicle::studio
