// What the body is and how it is filled: [scene], [bar], [mesh], [character], [body].
#include "host/made/made_bunny.h"
#include "host/made/made_character.h"
#include "host/scene/scene_keys.h"
#include "host/scene/scene_rows.h"

namespace fascicle::scene {
namespace {

const auto& general_rows() {
  using namespace rows;
  static const std::tuple all{
      loose_key(
          {.name = "description", .type = KeyType::text, .doc = "One line that says what the scene shows."}),
      key(&Scene::gravity, {.name = "gravity", .doc = "Gravity, m/s^2.", .range = between(-1e4, 1e4)}),
      key(&Scene::fps, {.name = "fps", .doc = "Frames a second.", .range = between(1e-3, 1e5)}),
      key(&Scene::start,
          {.name = "start", .doc = "Time of the clip where frame 0 stands, s.", .range = between(-1e5, 1e5)}),
      key(&Scene::end,
          {.name = "end",
           .doc = "Time of the last frame, s; where absent, the clip's end, or 2 s after the start without a "
                  "clip.",
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
          {.name = "count", .doc = "How many of them lie one above the other.", .range = between(1, 1000)}),
      key(&Bar::gap, {.name = "gap", .doc = "Between one and the next, m.", .range = between(0.0, 1e4)}),
      key(&Bar::jitter, {.name = "jitter",
                         .doc = "Inner vertices are moved at random by up to this many spacings.",
                         .range = between(0.0, 0.3)}),
      key(&Bar::seed, {.name = "seed", .doc = "Which random moves.", .range = {.minimum = 0.0}})};
  static_assert(base::has_row_for_each_member<Bar, decltype(all)>, "a member of Bar has no row here");
  return all;
}

const auto& mesh_rows() {
  using namespace rows;
  static const std::tuple all{
      loose_key(
          {.name = "file", .type = KeyType::text, .doc = "The file, relative to the scene file's folder."}),
      loose_key({.name = "made",
                 .type = KeyType::text,
                 .doc = "A surface made in code: a bunny that sits.",
                 .allowed = made::made_surface_names()}),
      key(&Scene::scale, {.name = "scale", .doc = "Metres per unit of the file.", .range = positive(1e6)}),
      key(&Scene::resolution,
          {.name = "resolution",
           .doc = "Surfaces: wanted edge length of the tetrahedra, m; where absent, the surface's mean edge.",
           .range = positive(1e4)})};
  return all;
}

const auto& character_rows() {
  using namespace rows;
  static const std::tuple all{
      loose_key(
          {.name = "file", .type = KeyType::text, .doc = "The file, relative to the scene file's folder."}),
      loose_key({.name = "made",
                 .type = KeyType::text,
                 .doc = "A character made in code: a bear that jumps, an arm that curls, straight or bent by "
                        "46 degrees in its bind pose.",
                 .allowed = made::made_character_names()}),
      key(&Scene::paint,
          {.name = "paint",
           .doc =
               "A file with what is painted on it, relative to the scene file's folder: it goes before what "
               "the character's own file has painted there; empty: none."},
          {.shown = Shown::where_set}),
      key(&Scene::clip,
          {.name = "clip", .doc = "The animation, by name or by number from 0; empty: the first."}),
      key(&Scene::resolution,
          {.name = "resolution",
           .doc = "Wanted edge length of the tetrahedra, m; where absent, the surface's mean edge.",
           .range = positive(1e4)})};
  return all;
}

const auto& placed_character_rows() {
  using namespace rows;
  static const std::tuple all{
      member("name", &CharacterSettings::name),
      key(&CharacterSettings::file,
          {.name = "file",
           .doc =
               "The file, relative to the scene file's folder. With `rigid` also a still thing: a glTF file "
               "without skeleton and clip, or a closed mesh in metres, Y up (.off, .obj, .ply, .stl)."},
          {.depends = true}),
      key(&CharacterSettings::made,
          {.name = "made", .doc = "A character made in code.", .allowed = made::made_character_names()},
          {.depends = true}),
      key(&CharacterSettings::paint,
          {.name = "paint",
           .doc =
               "A file with what is painted on it, relative to the scene file's folder: it goes before what "
               "its own file has painted there; empty: none."},
          {.shown = Shown::where_set}),
      key(&CharacterSettings::clip,
          {.name = "clip", .doc = "Its animation, by name or by number from 0; empty: the first."}),
      key(&CharacterSettings::joint,
          {.name = "joint",
           .doc = "It goes with this joint of another character, \"man/hand\", as a sword with a hand. Then "
                  "`at` and `turn` say how it is held in that one's bind pose: seen from the joint's place, "
                  "along the axes of that one's file."}),
      key(&CharacterSettings::at,
          {.name = "at",
           .doc = "Where the origin of its file stands, m; with `joint` how far from the joint.",
           .range = coordinate}),
      key(&CharacterSettings::turn,
          {.name = "turn",
           .doc = "How it is turned there: an axis times degrees, [0, 180, 0] is half a turn about Y.",
           .range = between(-1e5, 1e5)}),
      key(&CharacterSettings::start,
          {.name = "start",
           .doc = "When its clip begins, s of the scene's time; before that its first pose stands. Below 0 "
                  "it has begun before.",
           .range = between(-1e5, 1e5)}),
      key(&CharacterSettings::rigid,
          {.name = "rigid",
           .doc = "All of its flesh follows its skeleton. It pushes the flesh of others and is not pushed: a "
                  "prop, a helper."}),
      key(&CharacterSettings::thickness,
          {.name = "thickness",
           .doc = "With `rigid`: how far from it flesh stays, m. Its cage stands so far outside of its skin.",
           .range = between(0.0, 1e3)},
          {.depends = true}),
      key(&CharacterSettings::resolution,
          {.name = "resolution",
           .doc = "Wanted edge length of its tetrahedra, m; where absent, body.resolution, or its surface's "
                  "mean edge.",
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
           .doc = "auto: a cage around skins that cannot be filled as they are, or of a character that is "
                  "dense or uneven; off: never; wrap: always."}),
      key(&BodySettings::cage_detail,
          {.name = "cage_detail",
           .doc = "A cage closes gaps and holes narrower than the body's diagonal divided by this.",
           .range = between(10.0, 2000.0)}),
      loose_key(
          {.name = "resolution",
           .type = KeyType::text,
           .doc = "How fine: a number of vertices (\"20000\") or an edge length with its unit (\"20 mm\", "
                  "\"2 cm\", \"0.02 m\"). Where absent, 20000 vertices for a cage, else the surface's mean "
                  "edge."}),
      member("vertices", &BodySettings::vertices), member("thickness", &BodySettings::thickness)};
  static_assert(base::has_row_for_each_member<BodySettings, decltype(all)>,
                "a member of BodySettings has no row here");
  return all;
}

}  // namespace

const Table& general_table() {
  static const Table table =
      with_keys({.name = "scene", .doc = "What holds for the whole scene."}, general_rows());
  return table;
}
void read_general_keys(const toml::table& table, Scene& scene) {
  read_rows(table, general_rows(), scene);
}

const Table& bar_table() {
  static const Table table = with_keys(
      {.name = "bar", .doc = "A box of tetrahedra, six to a cell, from the origin to its size."}, bar_rows());
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
                                        .doc = "A mesh file: tetrahedra (.mesh .node .ele .msh .vtu) or a "
                                               "closed surface (.off .obj .ply .stl); or "
                                               "one of fascicle's own.",
                                        .choices = {{"file", "made"}}},
                                       mesh_rows());
  return table;
}
void read_mesh_keys(const toml::table& table, Scene& scene) {
  read_rows(table, mesh_rows(), scene);
}

const Table& character_table() {
  static const Table table = with_keys({.name = "character",
                                        .doc = "A rigged character: a glTF 2.0 file (.glb .gltf .vrm), an "
                                               ".fbx or .dae, or one of fascicle's own.",
                                        .choices = {{"file", "made"}}},
                                       character_rows());
  return table;
}
void read_character_keys(const toml::table& table, Scene& scene) {
  read_rows(table, character_rows(), scene);
}

const Table& placed_character_table() {
  static const Table table = with_keys(
      {.name = "characters",
       .doc = "One of several characters in a scene. Names of its joints, objects and materials begin "
              "with NAME/. Where it stands in its own file is what `where`, drawn fibres and bones, and "
              "solids that go with one of its joints speak of.",
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
