#include "host/scene/scene_table.h"

#include "host/scene/made_character.h"
#include "host/scene/material.h"
#include "host/scene/scene.h"
#include "host/scene/scene_table_parts.h"

namespace fascicle::scene {
namespace {

// Owns all tables: they point at each other.
struct Tables {
  const Table& shape = shape_table();

  Table general{
      .name = "scene",
      .doc = "What holds for the whole scene.",
      .keys = {
          {.name = "description", .type = KeyType::text, .doc = "One line that says what the scene shows."},
          {.name = "gravity",
           .type = KeyType::vector,
           .doc = "Gravity, m/s^2.",
           .range = between(-1e4, 1e4),
           .fallback = json_of(Scene{}.gravity)},
          {.name = "fps", .doc = "Frames a second.", .range = between(1e-3, 1e5), .fallback = Scene{}.fps},
          {.name = "start",
           .doc = "Time of the clip where frame 0 stands, s.",
           .range = between(-1e5, 1e5),
           .fallback = Scene{}.start},
          {.name = "end",
           .doc = "Time of the last frame, s; where absent, the clip's end, or 2 s after the start without a "
                  "clip.",
           .range = between(-1e5, 1e5)}}};

  Table bar{.name = "bar",
            .doc = "A box of tetrahedra, six to a cell, from the origin to its size.",
            .keys = {{.name = "size",
                      .type = KeyType::vector,
                      .doc = "Extent along x, y and z, m.",
                      .range = positive(1e4),
                      .fallback = json_of(Bar{}.size)},
                     {.name = "vertices",
                      .type = KeyType::integer_vector,
                      .doc = "Vertices along x, y and z.",
                      .range = between(2, 4096),
                      .fallback = Bar{}.vertices},
                     {.name = "jitter",
                      .doc = "Inner vertices are moved at random by up to this many spacings.",
                      .range = between(0.0, 0.3),
                      .fallback = Bar{}.jitter},
                     {.name = "seed",
                      .type = KeyType::integer,
                      .doc = "Which random moves.",
                      .range = {.minimum = 0.0},
                      .fallback = Bar{}.seed}}};

  Table mesh{
      .name = "mesh",
      .doc =
          "A mesh file: tetrahedra (.mesh .node .ele .msh .vtu) or a closed surface (.off .obj .ply .stl).",
      .keys = {
          {.name = "file",
           .type = KeyType::text,
           .doc = "The file, relative to the scene file's folder.",
           .required = true},
          {.name = "scale",
           .doc = "Metres per unit of the file.",
           .range = positive(1e6),
           .fallback = Scene{}.scale},
          {.name = "resolution",
           .doc = "Surfaces: wanted edge length of the tetrahedra, m; where absent, the surface's mean edge.",
           .range = positive(1e4)}}};

  Table character{
      .name = "character",
      .doc =
          "A rigged character: a glTF 2.0 file (.glb .gltf .vrm), an .fbx or .dae, or one of fascicle's own.",
      .keys = {{.name = "file",
                .type = KeyType::text,
                .doc = "The file, relative to the scene file's folder."},
               {.name = "made",
                .type = KeyType::text,
                .doc = "A character made in code: a bear that jumps, an arm that curls, straight or bent by "
                       "46 degrees in its bind pose.",
                .allowed = made_character_names()},
               {.name = "clip",
                .type = KeyType::text,
                .doc = "The animation, by name or by number from 0; empty: the first.",
                .fallback = Scene{}.clip},
               {.name = "resolution",
                .doc = "Wanted edge length of the tetrahedra, m; where absent, the surface's mean edge.",
                .range = positive(1e4)}},
      .choices = {{"file", "made"}}};

  Table body{
      .name = "body",
      .doc = "How a surface or a character is filled with tetrahedra.",
      .keys = {
          {.name = "cage",
           .type = KeyType::text,
           .doc = "auto: a cage around skins that cannot be filled as they are, or of a character that is "
                  "dense or uneven; off: never; wrap: always.",
           .fallback = BodySettings{}.cage,
           .allowed = {"auto", "off", "wrap"}},
          {.name = "cage_detail",
           .doc = "A cage closes gaps and holes narrower than the body's diagonal divided by this.",
           .range = between(10.0, 2000.0),
           .fallback = BodySettings{}.cage_detail},
          {.name = "resolution",
           .type = KeyType::text,
           .doc = "How fine: a number of vertices (\"20000\") or an edge length with its unit (\"20 mm\", "
                  "\"2 cm\", \"0.02 m\"). Where absent, 20000 vertices for a cage, else the surface's mean "
                  "edge."}}};

  Table layer{
      .name = "layer",
      .doc = "A layer of the body. Where several claim a point, the last of the file has it.",
      .keys =
          {{.name = "alpha",
            .doc = "Stiffness of equation (4), per substep.",
            .range = between(0.0, 1.0),
            .fallback = Layer{}.alpha},
           {.name = "alpha_outer",
            .doc = "Stiffness at the layer's outer side; alpha is then that of its inner side.",
            .range = between(0.0, 1.0)},
           {.name = "alpha_attribute",
            .type = KeyType::text,
            .doc = "Painted values from 0 to 1 that alpha is multiplied by: _STIFFNESS, COLOR_0.g; empty: "
                   "none.",
            .fallback = Layer{}.alpha_attribute},
           {.name = "youngs_modulus",
            .doc = "Stiffness with the implicit integrator: Young's modulus, Pa.",
            .range = positive(1e12)},
           {.name = "frequency",
            .doc =
                "Stiffness with the implicit integrator: the layer's lowest mode with everything else held "
                "still, Hz.",
            .range = positive(1e4)},
           {.name = "material",
            .type = KeyType::text,
            .doc = "Stiffness with the implicit integrator, and where absent density, of a tissue.",
            .allowed = material_names()},
           {.name = "beta",
            .doc = "Weight of the fibre, equation (14).",
            .range = between(0.0, 1.0),
            .fallback = Layer{}.beta},
           {.name = "damping",
            .doc = "Rate at which the motion relative to the skeleton dies out, 1/s.",
            .range = between(0.0, 1e4),
            .fallback = Layer{}.damping},
           {.name = "damping_ratio",
            .doc = "In place of damping, with the implicit integrator: of the layer's lowest mode; 1 is "
                   "critical.",
            .range = between(0.0, 100.0)},
           {.name = "density",
            .doc = "Density, kg/m^3.",
            .range = positive(1e5),
            .fallback = Layer{}.density},
           {.name = "fibre",
            .type = KeyType::vector,
            .doc = "Direction of the fibres at rest; its length and sign mean nothing.",
            .range = coordinate},
           {.name = "fibre_field",
            .type = KeyType::boolean,
            .doc = "The fibres follow the bones inside and the skin outside: equations (1) to (3).",
            .fallback = Layer{}.fibre_field},
           {.name = "kinematic",
            .type = KeyType::boolean,
            .doc = "Moved by the skeleton alone, or held still where there is none: bone.",
            .fallback = Layer{}.kinematic},
           {.name = "sliding",
            .type = KeyType::boolean,
            .doc = "Skin: slides along the flesh of layers that do not slide and keeps its distance from it; "
                   "attached where it meets bone.",
            .fallback = Layer{}.sliding},
           {.name = "inertia_scale",
            .doc = "Share of the skeleton's acceleration that the flesh feels; 0: it is carried along; above "
                   "1: it feels more than there is.",
            .range = between(0.0, most_inertia),
            .fallback = Layer{}.inertia_scale},
           {.name = "volume",
            .doc =
                "How strongly volume is drawn back to rest; 1: as strongly as the stiffness leaves stable.",
            .range = between(0.0, 1.0),
            .fallback = Layer{}.volume},
           {.name = "least_volume",
            .doc = "Share of its volume at rest below which no tetrahedron is crushed, with the implicit "
                   "integrator; 0: none. Where absent, 0.3 for a character, else 0.",
            .range = between(0.0, 0.9)},
           where_key(shape, false,
                     "What belongs to the layer; where absent, all that no other layer claims.")},
      .alternatives = {{"alpha", "youngs_modulus", "frequency", "material"},
                       {"alpha_outer", "youngs_modulus", "frequency", "material"},
                       {"alpha_attribute", "youngs_modulus", "frequency", "material"},
                       {"damping", "damping_ratio"}}};

  Table solver{
      .name = "solver",
      .doc = "How the motion is computed.",
      .keys = {
          {.name = "integrator",
           .type = KeyType::text,
           .doc = "Time stepping: explicit, equations (4) and (5), with stiffness as alpha; implicit, with "
                  "stiffness as youngs_modulus, frequency or material, the same at every fps and resolution. "
                  "Left "
                  "out, the one whose stiffness the layers state, explicit where they state none.",
           .allowed = {"explicit", "implicit"}},
          {.name = "rotation",
           .type = KeyType::text,
           .doc = "How the rotation of equation (9) is found.",
           .fallback = SolverSettings{}.rotation,
           .allowed = {"qcp", "mueller2016"}},
          {.name = "weights",
           .type = KeyType::text,
           .doc = "Equation (12) made symmetric in the fibre's sign and momentum-conserving, or as printed.",
           .fallback = SolverSettings{}.weights,
           .allowed = {"symmetric", "kaneda2017"}},
          {.name = "substeps",
           .type = KeyType::integer,
           .doc =
               "Steps a frame; the stiffness that alpha means grows with their square. auto: as many as make "
               "it the same at every frame rate and spacing; with the implicit integrator, as many as the "
               "layers' lowest modes need.",
           .range = between(1, 1000),
           .fallback = SolverSettings{}.substeps,
           .allowed = {"auto"}},
          {.name = "iterations",
           .type = KeyType::integer,
           .doc = "Iterations an implicit substep.",
           .range = between(1, 1000),
           .fallback = SolverSettings{}.iterations}}};

  Table motion{
      .name = "motion",
      .doc = "How time runs around the clip, and what gravity does to the rest shape.",
      .keys = {
          {.name = "rest",
           .type = KeyType::text,
           .doc =
               "sculpted: the rest shape hangs under gravity already, only its change in the bones' frames "
               "acts; weightless: all of it acts. Where absent, sculpted for a character, else weightless.",
           .allowed = {"sculpted", "weightless"}},
          {.name = "interpolation",
           .type = KeyType::text,
           .doc =
               "smooth: linear keys closer than a tenth of a second are samples of a smooth motion, and a "
               "cubic runs through them; as-authored: straight lines. Where absent, smooth for a character "
               "from a file.",
           .allowed = {"smooth", "as-authored"}},
          {.name = "preroll",
           .doc =
               "Time before frame 0 in which the bind pose goes over into the first pose, s; where absent, "
               "0.5 for a character.",
           .range = between(0.0, 1e3)},
          {.name = "settle",
           .doc =
               "Time before frame 0, and after the preroll, in which the first pose is held until the flesh "
               "is slower than 1 mm/s (root mean square); at most this long, s.",
           .range = between(0.0, 1e3),
           .fallback = Motion{}.settle},
          {.name = "loop",
           .type = KeyType::integer,
           .doc = "How often the clip is played.",
           .range = between(1, 100000),
           .fallback = Motion{}.loop},
          {.name = "seamless",
           .type = KeyType::boolean,
           .doc = "Play the clip before frame 0 until a cycle ends as it began, then write one cycle.",
           .fallback = Motion{}.seamless},
          {.name = "seamless_tolerance",
           .doc = "Largest distance of a vertex between a cycle's end and its beginning, as a share of the "
                  "body's extent.",
           .range = positive(1.0),
           .fallback = Motion{}.seamless_tolerance},
          {.name = "seamless_cycles",
           .type = KeyType::integer,
           .doc = "Cycles before frame 0, at most.",
           .range = between(1, 10000),
           .fallback = Motion{}.seamless_cycles},
          {.name = "hold",
           .doc = "Time after the clip's end in which its last pose is held, s.",
           .range = between(0.0, 1e5),
           .fallback = Motion{}.hold},
          {.name = "handles",
           .type = KeyType::integer,
           .doc = "Frames that are simulated and written before scene.start and after the end; beyond the "
                  "clip its first and last pose are held.",
           .range = between(0, 100000),
           .fallback = Motion{}.handles},
          {.name = "acceleration_limit",
           .doc = "Most of a joint's acceleration that its flesh feels, m/s^2; with the rest it is carried "
                  "along. Where absent, and keys are smooth, 200 times the body's extent.",
           .range = positive(1e9)},
          {.name = "cuts",
           .type = KeyType::numbers,
           .doc =
               "Times of the clip at which it jumps, s: the flesh is carried along and feels nothing of it.",
           .range = between(-1e5, 1e5)},
          {.name = "cut_distance",
           .doc = "A root that goes further than this in one frame has jumped, m; where absent, the body's "
                  "largest extent.",
           .range = positive(farthest)}}};

  Table pin{.name = "pin",
            .doc = "Vertices that are held where they are.",
            .keys = {where_key(shape, true, "Which vertices.")}};

  Table probe{.name = "probe",
              .doc = "Vertices whose mean position is written for each frame.",
              .keys = {where_key(shape, true, "Which vertices.")}};

  Table force{
      .name = "force",
      .doc = "A force beside gravity.",
      .keys = {{.name = "kind",
                .type = KeyType::text,
                .doc = "wind: a pressure on the whole surface; point: a force spread over vertices by mass.",
                .allowed = {"wind", "point"},
                .required = true},
               {.name = "vector",
                .type = KeyType::vector,
                .doc = "Direction and size: Pa for wind, N for point.",
                .range = between(-1e9, 1e9),
                .required = true},
               where_key(shape, false, "point only, and needed there: which vertices."),
               {.name = "start",
                .doc = "Acts from this time on, s.",
                .range = between(-1e5, 1e30),
                .fallback = Force{}.start},
               {.name = "end",
                .doc = "Acts before this time, s.",
                .range = between(-1e5, 1e30),
                .fallback = Force{}.end}}};

  Table bone{.name = "bone",
             .doc = "A bone of a mesh without a skeleton: a segment that layers can be measured from.",
             .keys = {point("from", "One end, m."), point("to", "The other end, m.")}};

  Table skeleton{
      .name = "skeleton",
      .doc = "Which joints are bones, and which flesh follows them. Where nothing is said, the skin decides.",
      .keys = {
          {.name = "bones", .type = KeyType::texts, .doc = "Joints that are bones."},
          {.name = "not_bones", .type = KeyType::texts, .doc = "Joints that are no bones."},
          {.name = "kinematic",
           .type = KeyType::texts,
           .doc = "Joints whose flesh follows the skeleton, with all below them."},
          {.name = "simulated",
           .type = KeyType::texts,
           .doc = "Joints whose flesh is simulated, with all below them; counts before kinematic."},
          {.name = "rigid",
           .type = KeyType::texts,
           .doc = "Joints (with all below them), objects or materials whose skin follows its joints alone, "
                  "beside the parts that the weights say so of; and so does the flesh below that skin."},
          {.name = "only",
           .type = KeyType::texts,
           .doc = "Joints whose flesh is simulated, with all below them; that of all others follows the "
                  "skeleton."},
          {.name = "least_share",
           .doc = "Share of the skin's area that a bone and the joints below it must move.",
           .range = between(0.0, 1.0),
           .fallback = SkeletonSettings{}.least_share},
          {.name = "connect",
           .type = KeyType::boolean,
           .doc = "Bone layers that are measured from the bones are completed along them until they "
                  "hold together.",
           .fallback = SkeletonSettings{}.connect}}};

  Table flesh{
      .name = "flesh",
      .doc = "What is wished of all flesh at once.",
      .keys = {
          {.name = "softness",
           .doc = "How many times as soft: the stiffness of all layers that move by themselves is divided by "
                  "it.",
           .range = between(0.01, 100.0),
           .fallback = FleshSettings{}.softness},
          {.name = "exaggerate",
           .doc =
               "How many times as much of the skeleton's acceleration all flesh feels, so that it trails and "
               "jiggles as many times as far.",
           .range = between(0.0, most_inertia),
           .fallback = FleshSettings{}.exaggerate}}};

  Table fibre_curve{.name = "fibre_curve",
                    .doc = "Fibres drawn as a line from origin to insertion: the fibre field follows it.",
                    .keys = {{.name = "points",
                              .type = KeyType::points,
                              .doc = "Corners of the line, m.",
                              .range = coordinate,
                              .required = true},
                             {.name = "radius",
                              .doc = "How far around the line it holds, m; where absent, the mean edge.",
                              .range = positive(farthest)}}};

  Table muscle{
      .name = "muscle",
      .doc =
          "A muscle on a bone: it bulges as a joint bends, or as a curve tells it: equations (15) to (17).",
      .keys = {
          {.name = "joint", .type = KeyType::text, .doc = "The joint whose bending makes it bulge."},
          {.name = "parent",
           .type = KeyType::text,
           .doc = "The joint where the upper bone begins; where absent, the next joint above `joint`."},
          {.name = "child",
           .type = KeyType::text,
           .doc = "The joint where the lower bone ends; where absent, the next one below `joint` that moves "
                  "the most skin."},
          {.name = "bone",
           .type = KeyType::text,
           .doc = "The joint whose bone carries the muscle; where absent, that of the upper bone."},
          {.name = "layer",
           .type = KeyType::text,
           .doc = "Only flesh of this layer; where absent, of any that is not kinematic."},
          where_key(shape, false, "Only what lies here; where absent, all along the bone."),
          {.name = "gain",
           .doc = "How much it bulges, equation (17).",
           .range = between(-10.0, 10.0),
           .fallback = Muscle{}.gain},
          {.name = "axis",
           .type = KeyType::text,
           .doc = "Where it bulges: flexion: on the side to which the joint folds, and thins on the other; "
                  "plane-normal: along the normal of the plane of the two bones.",
           .fallback = Muscle{}.axis,
           .allowed = {"flexion", "plane-normal"}},
          {.name = "activation",
           .type = KeyType::text,
           .doc =
               "Of the joint's angle, less its value in the bind pose: cosine: (1 - cos)/2, which rises all "
               "the way; sine: as printed, which turns back beyond 90 degrees.",
           .fallback = Muscle{}.activation,
           .allowed = {"cosine", "sine"}},
          {.name = "curve",
           .type = KeyType::curve,
           .doc = "Activation over the joint's angle in place of `activation`: [[degrees, value], ...].",
           .range = between(-1e3, 1e3)},
          {.name = "contraction",
           .type = KeyType::curve,
           .doc = "Activation over the clip's time, whatever the joint does: [[seconds, value], ...].",
           .range = between(-1e5, 1e5)},
          {.name = "contraction_channel",
           .type = KeyType::text,
           .doc = "Activation from the clip: a joint, translation or scale, and an axis, as "
                  "flex.translation.x; its value at rest counts as 0.",
           .fallback = Muscle{}.contraction_channel},
          {.name = "twist",
           .doc = "Share of the bone's twist by which the fibres wind around it.",
           .range = between(-1.0, 1.0),
           .fallback = Muscle{}.twist},
          {.name = "twist_joint",
           .type = KeyType::text,
           .doc =
               "The joint whose turn about the bone, relative to its parent, is the twist; where absent, the "
               "one where the bone ends."}}};

  Table root{
      .name = "root",
      .doc = "A fascicle scene. Metres, kilograms, seconds, Y up.",
      .keys =
          {{.name = "scene",
            .type = KeyType::table,
            .doc = "What holds for the whole scene.",
            .table = &general},
           {.name = "bar", .type = KeyType::table, .doc = "The body: a bar.", .table = &bar},
           {.name = "mesh", .type = KeyType::table, .doc = "The body: a mesh file.", .table = &mesh},
           {.name = "character",
            .type = KeyType::table,
            .doc = "The body: a character.",
            .table = &character},
           {.name = "body",
            .type = KeyType::table,
            .doc = "How a surface or a character is filled with tetrahedra.",
            .table = &body},
           {.name = "bones", .type = KeyType::named_tables, .doc = "Bones by name.", .table = &bone},
           {.name = "skeleton", .type = KeyType::table, .doc = "What joints are.", .table = &skeleton},
           {.name = "flesh", .type = KeyType::table, .doc = "What is wished of all flesh.", .table = &flesh},
           {.name = "layers",
            .type = KeyType::named_tables,
            .doc =
                "Layers by name, at least one; where absent, a character gets fat, muscle and bone by depth.",
            .table = &layer},
           {.name = "fibres",
            .type = KeyType::named_tables,
            .doc = "Drawn fibres by name.",
            .table = &fibre_curve},
           {.name = "muscle", .type = KeyType::named_tables, .doc = "Muscles by name.", .table = &muscle},
           {.name = "solver", .type = KeyType::table, .doc = "How the motion is computed.", .table = &solver},
           {.name = "motion",
            .type = KeyType::table,
            .doc = "How time runs around the clip.",
            .table = &motion},
           {.name = "pin", .type = KeyType::named_tables, .doc = "Pinned vertices by name.", .table = &pin},
           {.name = "probe", .type = KeyType::named_tables, .doc = "Probes by name.", .table = &probe},
           {.name = "force", .type = KeyType::named_tables, .doc = "Forces by name.", .table = &force}},
      .choices = {{"bar", "mesh", "character"}}};
};

}  // namespace

const Table& scene_table() {
  static const Tables tables;
  return tables.root;
}

const Key* find_key(const Table& table, std::string_view name) {
  for (const Key& key : table.keys) {
    if (key.name == name) return &key;
  }
  return nullptr;
}

std::vector<std::string> key_names(const Table& table) {
  std::vector<std::string> names;
  names.reserve(table.keys.size());
  for (const Key& key : table.keys) names.push_back(key.name);
  return names;
}

bool is_valid_name(std::string_view name) {
  if (name.empty() || name.size() > longest_name) return false;
  for (const char c : name) {
    const bool good =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    if (!good) return false;
  }
  return true;
}

}  // namespace fascicle::scene
