// The body and its tetrahedra: [scene], [bar], [mesh], [character], [body].
#include "host/made/made_bunny.h"
#include "host/made/made_character.h"
#include "host/scene/scene_keys.h"
#include "host/scene/scene_rows.h"

namespace fascicle::scene {
namespace {

const auto& general_rows() {
  using namespace rows;
  static const std::tuple all{
      loose_key({.name = "description", .type = KeyType::text, .doc = "One-line description of the scene."}),
      key(&Scene::gravity, {.name = "gravity", .doc = "Gravity, m/s^2.", .range = between(-1e4, 1e4)}),
      key(&Scene::fps, {.name = "fps", .doc = "Frames per second.", .range = between(1e-3, 1e5)}),
      key(&Scene::start, {.name = "start", .doc = "Clip time of frame 0, s.", .range = between(-1e5, 1e5)}),
      key(&Scene::end,
          {.name = "end",
           .doc = "Clip time of the last frame, s. Default: the clip's end, or 2 s after the start without a "
                  "clip; one frame after the start if nothing moves.",
           .range = between(-1e5, 1e5)},
          {.depends = true})};
  return all;
}

const auto& bar_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&Bar::size, {.name = "size", .doc = "Extent along x, y and z, m.", .range = positive(1e4)}),
      key(&Bar::vertices,
          {.name = "vertices", .doc = "Vertices along x, y and z.", .range = between(2, 4096)}),
      key(&Bar::count,
          {.name = "count", .doc = "Number of bars, stacked along Y.", .range = between(1, 1000)}),
      key(&Bar::gap, {.name = "gap", .doc = "Gap between stacked bars, m.", .range = between(0.0, 1e4)}),
      key(&Bar::jitter, {.name = "jitter",
                         .doc = "Largest random offset of inner vertices, in vertex spacings.",
                         .range = between(0.0, 0.3)}),
      key(&Bar::seed, {.name = "seed", .doc = "Seed of the random offsets.", .range = {.minimum = 0.0}})};
  static_assert(base::has_row_for_each_member<Bar, decltype(all)>, "a member of Bar has no row here");
  return all;
}

const auto& mesh_rows() {
  using namespace rows;
  static const std::tuple all{
      loose_key({.name = "file", .type = KeyType::text, .doc = "Path, relative to the scene file's folder."}),
      loose_key({.name = "made",
                 .type = KeyType::text,
                 .doc = "A built-in surface: a sitting bunny.",
                 .allowed = made::made_surface_names()}),
      key(&Scene::scale, {.name = "scale", .doc = "Metres per unit of the file.", .range = positive(1e6)}),
      key(&Scene::resolution,
          {.name = "resolution",
           .doc = "Surfaces: target edge length of the tetrahedra, m. Default: as for body.resolution.",
           .range = positive(1e4)})};
  return all;
}

const auto& character_rows() {
  using namespace rows;
  static const std::tuple all{
      loose_key({.name = "file", .type = KeyType::text, .doc = "Path, relative to the scene file's folder."}),
      loose_key({.name = "made",
                 .type = KeyType::text,
                 .doc = "A built-in character: a bear that jumps, or an arm that curls, straight or bent by "
                        "46 degrees in its bind pose.",
                 .allowed = made::made_character_names()}),
      key(&Scene::paint,
          {.name = "paint",
           .doc = "Paint file, relative to the scene file's folder. It takes precedence over paint in the "
                  "character's own file. Empty: none."},
          {.shown = Shown::where_set}),
      key(&Scene::clip,
          {.name = "clip", .doc = "Animation clip, by name or by number from 0; empty: the first."}),
      key(&Scene::resolution,
          {.name = "resolution",
           .doc = "Target edge length of the tetrahedra, m. Default: as for body.resolution.",
           .range = positive(1e4)})};
  return all;
}

const auto& placed_character_rows() {
  using namespace rows;
  static const std::tuple all{
      member("name", &CharacterSettings::name),
      key(&CharacterSettings::file,
          {.name = "file",
           .doc = "Path, relative to the scene file's folder. With `rigid` also a static prop: a glTF file "
                  "without skeleton and clip, or a closed mesh in metres, Y up (.off, .obj, .ply, .stl)."},
          {.depends = true}),
      key(&CharacterSettings::made,
          {.name = "made", .doc = "A built-in character.", .allowed = made::made_character_names()},
          {.depends = true}),
      key(&CharacterSettings::paint,
          {.name = "paint",
           .doc = "Paint file, relative to the scene file's folder. It takes precedence over paint in the "
                  "character's own file. Empty: none."},
          {.shown = Shown::where_set}),
      key(&CharacterSettings::clip,
          {.name = "clip", .doc = "Animation clip, by name or by number from 0; empty: the first."}),
      key(&CharacterSettings::joint,
          {.name = "joint",
           .doc = "Joint of another character to which it is attached, such as \"man/hand\" for a sword. "
                  "`at` and `turn` then place it in that character's bind pose, relative to the joint and "
                  "along the axes of that character's file."}),
      key(&CharacterSettings::at,
          {.name = "at",
           .doc = "Position of its file's origin, m; with `joint`, relative to the joint.",
           .range = coordinate}),
      key(&CharacterSettings::turn,
          {.name = "turn",
           .doc = "Rotation, as an axis times degrees: [0, 180, 0] is half a turn about Y.",
           .range = between(-1e5, 1e5)}),
      key(&CharacterSettings::start, {.name = "start",
                                      .doc = "Scene time at which its clip starts, s; it holds its first "
                                             "pose until then. Negative: the clip starts before time 0.",
                                      .range = between(-1e5, 1e5)}),
      key(&CharacterSettings::rigid, {.name = "rigid",
                                      .doc = "Makes it a prop: all of its flesh follows its skeleton; it "
                                             "pushes the flesh of other characters and is not pushed."}),
      key(&CharacterSettings::thickness,
          {.name = "thickness",
           .doc = "With `rigid`: distance that flesh keeps from it, m; its cage is offset from its skin by "
                  "this.",
           .range = between(0.0, 1e3)},
          {.depends = true}),
      key(&CharacterSettings::resolution,
          {.name = "resolution",
           .doc = "Target edge length of its tetrahedra, m. Default: body.resolution.",
           .range = positive(1e4)})};
  static_assert(base::has_row_for_each_member<CharacterSettings, decltype(all)>,
                "a member of CharacterSettings has no row here");
  return all;
}

const auto& body_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&BodySettings::cage,
          {.name = "cage",
           .doc = "When to wrap a cage around the skin. auto: if it cannot be filled as it is, or if a "
                  "character's is too dense or uneven; off: never; wrap: always."}),
      key(&BodySettings::cage_detail, {.name = "cage_detail",
                                       .doc = "A cage closes gaps and holes up to about twice as wide as the "
                                              "body's diagonal divided by this.",
                                       .range = between(10.0, 2000.0)}),
      loose_key(
          {.name = "resolution",
           .type = KeyType::text,
           .doc = "Number of vertices (\"20000\") or edge length with its unit (\"20 mm\", \"2 cm\", "
                  "\"0.02 m\"). Default: 20000 vertices for a cage, else the surface's mean edge length."}),
      member("vertices", &BodySettings::vertices), member("thickness", &BodySettings::thickness)};
  static_assert(base::has_row_for_each_member<BodySettings, decltype(all)>,
                "a member of BodySettings has no row here");
  return all;
}

}  // namespace

const Table& general_table() {
  static const Table table =
      with_keys({.name = "scene", .doc = "Settings for the whole scene."}, general_rows());
  return table;
}
void read_general_keys(const toml::table& table, Scene& scene) {
  read_rows(table, general_rows(), scene);
}

const Table& bar_table() {
  static const Table table = with_keys(
      {.name = "bar", .doc = "A box from the origin to `size`, in cells of six tetrahedra."}, bar_rows());
  return table;
}
void read_keys(const toml::table& table, Bar& bar) {
  read_rows(table, bar_rows(), bar);
}
Json json_of(const Bar& bar) {
  return json_of_rows(bar_rows(), bar);
}

const Table& mesh_table() {
  static const Table table = with_keys({.name = "mesh",
                                        .doc = "A file of tetrahedra (.mesh .node .ele .msh .vtu) or of a "
                                               "closed surface (.off .obj .ply .stl), or a built-in surface.",
                                        .choices = {{"file", "made"}}},
                                       mesh_rows());
  return table;
}
void read_mesh_keys(const toml::table& table, Scene& scene) {
  read_rows(table, mesh_rows(), scene);
}

const Table& character_table() {
  static const Table table = with_keys(
      {.name = "character",
       .doc =
           "A rigged character: a glTF 2.0 file (.glb .gltf .vrm), an .fbx or .dae file, or a built-in one.",
       .choices = {{"file", "made"}}},
      character_rows());
  return table;
}
void read_character_keys(const toml::table& table, Scene& scene) {
  read_rows(table, character_rows(), scene);
}

const Table& placed_character_table() {
  static const Table table =
      with_keys({.name = "characters",
                 .doc = "One of several characters in a scene. The names of its joints, objects and "
                        "materials begin with NAME/. Coordinates in `where`, in drawn fibres and bones, and "
                        "in colliders on its joints refer to the bind pose in its own file.",
                 .choices = {{"file", "made"}}},
                placed_character_rows());
  return table;
}
void read_keys(const toml::table& table, CharacterSettings& character) {
  read_rows(table, placed_character_rows(), character);
}
Json json_of(const CharacterSettings& character) {
  return json_of_rows(placed_character_rows(), character);
}

const Table& body_table() {
  static const Table table = with_keys(
      {.name = "body", .doc = "How a surface or a character is filled with tetrahedra."}, body_rows());
  return table;
}
void read_keys(const toml::table& table, BodySettings& body) {
  read_rows(table, body_rows(), body);
}
Json json_of(const BodySettings& body) {
  return json_of_rows(body_rows(), body);
}

Json json_of_scene_keys(const Scene& scene) {
  Json object = json_of_rows(general_rows(), scene);
  object.update(json_of_rows(mesh_rows(), scene));
  object.update(json_of_rows(character_rows(), scene));
  return object;
}

}  // namespace fascicle::scene
