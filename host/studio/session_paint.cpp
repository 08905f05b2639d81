// What is painted in the session: strokes of the brush become changes of a paint file's text.
#include <span>
#include <stdexcept>
#include <utility>

#include "host/scene/input_files.h"
#include "host/scene/paint_file.h"
#include "host/studio/scene_keys.h"
#include "host/studio/session.h"
#include "host/studio/wire.h"

namespace fascicle::studio {

namespace {

// What a stroke is called where it can be taken back.
std::string label_of(const rig::PaintKind& kind) {
  const std::string name = kind.name;
  return name == "_RIGID"   ? "paint what is rigid"
         : name == "_LAYER" ? "paint layers"
         : name == "_FIBER" ? "paint fibres"
                            : "paint stiffness";
}

}  // namespace

// Of the name in character.paint; nothing for none.
PaintText Session::read_paint_file(const std::string& name) const {
  if (name.empty()) return nullptr;
  try {
    return std::make_shared<const std::string>(
        scene::read_text_file(source_folder_ / name, scene::most_paint_bytes));
  } catch (const scene::InputFileError& error) {
    throw scene::SceneError(std::string(paint_path) + ": " + error.what());
  }
}

// Of the text and the paint in force.
std::string Session::state_hash() const {
  const PaintText& paint = history_->paint();
  return scene::hash_of(paint ? history_->text() + *paint : history_->text());
}

// Empty where this can be painted; without a kind: where anything can.
std::string Session::why_no_paint(const rig::PaintKind* kind) const {
  if (!ground_)
    return "only a scene of a single character, [character], can be painted; of several each in its own "
           "scene";
  if (kind != nullptr && kind->name == std::string("_STIFFNESS") &&
      body_->scene().solver.integrator == base::Integrator::implicit_step)
    return "stiffness multiplies alpha, and the layers of this scene are as stiff as youngs_modulus, "
           "frequency or "
           "material say";
  return {};
}

Painting Session::painting_in_force() const {
  const PaintText& text = history_->paint();
  const rig::Paint none{ground_->hash(), ground_->surface().vertices.size(), {}};
  try {
    return {ground_, text ? scene::parse_paint(*text, std::string(paint_path), ground_->surface()) : none};
  } catch (const scene::InputFileError& error) {
    throw std::runtime_error(error.what());
  }
}

void Session::paint(PageId page, const StrokePiece& piece) {
  const rig::PaintKind& kind = *piece.brush.kind;
  if (const std::string why = why_no_paint(&kind); !why.empty()) throw std::runtime_error(why);
  if (stroke_ && (stroke_->page != page || stroke_->number != piece.stroke || stroke_->kind != &kind))
    end_stroke();
  const auto vector_of = [](const std::array<double, 3>& v) { return Vector3d(v[0], v[1], v[2]); };
  const bool is_first = !stroke_;
  if (is_first) stroke_.emplace(Stroke{page, piece.stroke, &kind, painting_in_force()});
  for (std::size_t k = 0; k < piece.places.size(); ++k) {
    const Vector3d place = vector_of(piece.places[k]);
    const bool has_way = !is_first || k > 0;
    const Vector3d along = has_way ? Vector3d(place - stroke_->last) : vector_of(piece.direction);
    stroke_->painting.stamp(piece.brush, place, along);
    stroke_->last = place;
  }
  send_sheet(stroke_->painting, kind, std::nullopt);
  if (piece.is_last) end_stroke();
}

// What the stroke has left is a change like any other. Where it cannot be one, pages are shown what holds.
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
  auto text = std::make_shared<const std::string>(scene::paint_text(stroke.painting.paint()));
  if (text->size() > scene::most_paint_bytes)
    throw std::runtime_error("this is more paint than a file may hold, " +
                             std::to_string(scene::most_paint_bytes >> 20) + " MiB");
  const PaintText before = history_->paint();
  if (before ? *before == *text : stroke.painting.paint().attributes.empty()) return;
  std::string scene_text = history_->text();
  if (paint_key(tables_).empty()) {
    const scene::KeyChange key{std::string(paint_path), Json(name_ + paint_suffix)};
    scene_text = scene::change_text(scene_text, source_, std::span(&key, 1)).text;
  }
  std::vector<scene::EditedTable> after = scene::edited_tables(scene_text, source_);
  history_->add(label_of(*stroke.kind), std::move(scene_text), std::move(text));
  take_text(std::exchange(tables_, std::move(after)), before);
}

void Session::send_sheet(const Painting& painting, const rig::PaintKind& kind, std::optional<PageId> page) {
  if (server_ == nullptr) return;
  const std::vector<float> values = painting.shown(kind);
  const auto bytes = std::make_shared<const std::string>(
      encode_array(std::string("paint.") + kind.name, body_number_, std::span<const float>(values)));
  for (const auto& [each, state] : pages_)
    if (!page || *page == each) server_->send_binary(each, bytes);
}

// What can be painted, and then all that is.
void Session::send_paint(std::optional<PageId> page) {
  const std::string why = why_no_paint();
  Json message{{"type", "paint"}, {"can_paint", why.empty()}, {"why_not", why}};
  Json attributes = Json::array(), sheets = Json::array();
  std::optional<Painting> painting;
  if (why.empty()) try {
      painting = painting_in_force();
    } catch (const std::runtime_error& error) {
      message["can_paint"] = false;
      message["why_not"] = error.what();
    }
  for (const rig::PaintKind& kind : rig::paint_kinds()) {
    attributes.push_back({{"name", kind.name}, {"why_not", why_no_paint(&kind)}});
    if (painting && painting->has(kind)) sheets.push_back(std::string("paint.") + kind.name);
  }
  message["attributes"] = std::move(attributes);
  message["arrays"] = std::move(sheets);
  page ? send(*page, message) : broadcast(message);
  for (const rig::PaintKind& kind : rig::paint_kinds())
    if (painting && painting->has(kind)) send_sheet(*painting, kind, page);
}

}  // namespace fascicle::studio
