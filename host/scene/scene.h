// Scene: the artist's input, parsed and checked, with the meshes it names loaded. Metres, kilograms, seconds,
// Y up.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "host/base/errors.h"
#include "host/base/names.h"
#include "host/base/stepping.h"
#include "host/mesh/mesh.h"
#include "host/rig/character.h"

namespace fascicle::scene {

using base::Integrator;
using base::name_of;
using base::Rotation;
using base::SceneError;
using base::WeightForm;
using Eigen::Vector3d;

// A box of Kuhn tetrahedra, six per cell, from the origin to `size`; `vertices` along each axis (at least 2).
// Interior vertices are moved by up to jitter x spacing along each axis.
struct Bar {
  Vector3d size{0.4, 0.08, 0.08};
  std::array<std::uint32_t, 3> vertices{21, 5, 5};
  std::uint32_t count = 1;  // number of bars, stacked vertically
  double gap = 0.01;        // m, between neighbouring bars
  double jitter = 0.0;      // [0, 0.3]
  std::uint64_t seed = 1;
};

using Geometry = std::variant<Bar, mesh::TetMesh, mesh::SurfaceMesh, rig::Character>;

enum class Axis { x = 0, y = 1, z = 2 };
constexpr auto names_of(Axis) {
  return std::array{"x", "y", "z"};
}

// Regions of space. A point is in a Where if it is in any of its shapes. All bounds are inclusive.
struct Box {
  Vector3d minimum = Vector3d::Zero(), maximum = Vector3d::Zero();
};
struct Sphere {
  Vector3d center = Vector3d::Zero();
  double radius = 0.0;
};
struct Capsule {
  Vector3d from = Vector3d::Zero(), to = Vector3d::Zero();
  double radius = 0.0;
};
// Below or above a plane across an axis, at a coordinate in metres or a fraction of the bounding box.
struct HalfSpace {
  Axis axis = Axis::y;
  bool below = true;
  bool is_fraction = false;
  double value = 0.0;
};
// By joint name, the maximum for vertices whose nearest bone belongs to that joint.
using PerBone = std::vector<std::pair<std::string, double>>;
// Distance to the nearest bone (Scene::bones, or the character's) within [minimum, maximum] metres.
struct BoneDistance {
  double minimum = 0.0;
  double maximum = 0.0;
  PerBone per_bone = {};
};
// Relative depth within [minimum, maximum]: 0 at the bone, 1 at the skin.
struct Depth {
  double minimum = 0.0;
  double maximum = 0.0;
  PerBone per_bone = {};
};
// The vertices between two fractions of the body's volume, counted from the bones outward by relative depth,
// or by distance from the bone.
struct VolumeShare {
  double minimum = 0.0;
  double maximum = 0.0;
  bool by_distance = false;
};
// Vertices with at least `share` of their weights on the named joints and, if `below`, on joints below them.
struct JointSet {
  std::vector<std::string> names;
  double share = 0.5;
  bool below = true;
};
// Vertices whose nearest point on the skin has one of these materials, or belongs to one of these objects
// (SurfacePart).
struct PartSet {
  std::vector<std::string> names;
  bool by_object = false;
};
// Points whose painted value lies within [minimum, maximum]. The attribute has its name from the file, a
// colour also its channel: "_LAYER", "COLOR_0.r".
struct Painted {
  std::string attribute;
  double minimum = 0.0;
  double maximum = 0.0;
};
struct Everywhere {};
using Shape = std::variant<Box, Sphere, Capsule, HalfSpace, BoneDistance, Depth, VolumeShare, JointSet,
                           PartSet, Painted, Everywhere>;
using Where = std::vector<Shape>;

struct BoneSegment {
  std::string name;
  Vector3d from = Vector3d::Zero(), to = Vector3d::Zero();
};

// Upper bound of a layer's inertia_scale: the flesh feels four times the skeleton's acceleration.
inline constexpr double most_inertia = 4.0;

struct Layer {
  std::string name;
  double alpha = 1.0;                 // [0, 1] per substep
  std::optional<double> alpha_outer;  // at the layer's outer side; alpha then holds at its inner side
  std::string alpha_attribute;        // painted factor of the stiffness; [0, 1] for alpha; empty: none
  // With integrator "implicit", a layer states its stiffness by one of these, or takes the material's.
  std::optional<double> youngs_modulus;  // Pa
  std::optional<double> frequency;       // Hz, of its lowest mode with everything else fixed
  std::string material;                  // "fat", ... (material.h); empty: none
  double beta = 0.0;                     // [0, 1]
  double damping = 0.0;                  // 1/s, >= 0
  std::optional<double> damping_ratio;   // of the lowest mode; replaces damping
  double density = 1000.0;               // kg/m^3, > 0
  std::optional<Vector3d> fibre;         // constant direction, normalised when read
  bool fibre_field = false;              // the direction comes from the fibre field; excludes `fibre`
  bool kinematic = false;                // bone layer: moved by skinning; pinned without a skeleton
  bool sliding = false;                  // skin: tied to the flesh of other layers only along the normal
  double inertia_scale = 1.0;  // [0, most_inertia]: share of the skeleton's acceleration that the flesh feels
  double volume = 0.0;         // [0, 1]: strength of volume preservation
  double least_volume = 0.0;   // [0, 0.9]: smallest share of its rest volume that it can be compressed to
  bool contact = true;         // takes part in contact, if contact is on
  Where where;          // empty: everything no other layer claims; of several matching layers the last wins
  Where by_paint = {};  // from a paint file, added to `where`; takes precedence over everything unpainted
};

// One of a scene's several characters, [character.NAME], and its placement.
struct CharacterSettings {
  std::string name;
  std::string file = {};  // relative to the scene file's folder; empty: `made`
  std::string made = {};
  std::string paint = {};                 // file with its paint, relative like `file`; empty: none
  std::string clip = {};                  // name or index; empty: the first
  std::string joint = {};                 // of another character, which carries it; empty: none
  Vector3d at = Vector3d::Zero();         // m: position of its origin; with `joint`, relative to that joint
  Vector3d turn = Vector3d::Zero();       // degrees about this direction: its orientation there
  double start = 0.0;                     // s of scene time at which its clip starts
  bool rigid = false;                     // all of its flesh follows its skeleton
  double thickness = 0.0;                 // m, if rigid: distance that flesh keeps from it
  std::optional<double> resolution = {};  // target edge length of its tetrahedra, m
};

// The same, loaded. Names of its joints, objects and materials start with NAME/. Positions that refer to it
// (`where`, drawn fibres and bones, colliders attached to a joint) are in its own bind pose.
struct PlacedCharacter {
  CharacterSettings settings;
  std::filesystem::path file = {};          // empty: made in code
  rig::Character own = {};                  // as in its file, except for the names
  Vector3d bind_offset = Vector3d::Zero();  // m: from its own bind pose to its position in the scene's
  std::uint32_t first_joint = 0;  // in the scene's skeleton: the joint NAME, followed by its own joints
  std::uint32_t first_node = 0;   // index of its first node in the scene's SurfacePart

  std::optional<std::uint32_t> bearer = {};  // the scene's joint that carries it
  // From its file's space to the world, or to its bearer's space.
  Eigen::Matrix4d place = Eigen::Matrix4d::Identity();
};

// The user's settings for joints, by name. By default the skin decides which joints are bones.
struct SkeletonSettings {
  std::vector<std::string> bones;      // are bones
  std::vector<std::string> not_bones;  // are none
  std::vector<std::string> kinematic;  // their flesh follows the skeleton
  std::vector<std::string> simulated;  // their flesh does not
  std::vector<std::string> rigid;      // joints, objects or materials: their skin follows its joints rigidly
  std::vector<std::string> only;       // if not empty: the flesh of all other joints follows the skeleton
  double least_share = 0.01;           // smallest share of the skin's area that a bone must move
  bool connect = true;                 // extend bone layers along the bones until they are connected
};

// Adjustments to all flesh at once. The layers that were read already include both.
struct FleshSettings {
  double softness = 1.0;    // > 0: all free layers' moduli are divided by it
  double exaggerate = 1.0;  // [0, 4]: all free layers' inertia_scale is multiplied by it
};

// Lists of one or two names.
using NameLists = std::vector<std::vector<std::string>>;

// How flesh meets flesh.
struct ContactSettings {
  bool self = false;               // flesh of a character does not pass through itself
  bool unless_torn = false;        // a bake leaves that out if a trial shows that it tears the skin
  std::optional<double> distance;  // m: flesh closer at rest does not collide; absent: from the mesh
  double friction = 0.5;           // Coulomb's coefficient, at least 0
  NameLists ignore;                // pairs of flesh that do not collide; a single name collides with nothing
  std::string attribute;           // painted: flesh below 0.5 collides with nothing; empty: none
};
// Maximum number of distinct names in pairs of ContactSettings::ignore: the bits of a group.
inline constexpr std::size_t most_ignored_names = 32;

// Muscle fibres drawn as a polyline from origin to insertion, m.
struct FibreCurve {
  std::string name;
  std::vector<Vector3d> points;  // at least two
  std::optional<double> radius;  // m: its range of influence; absent: the mean edge length
};

// A curve through keys (x, value), x ascending: linear between them, constant before the first and after the
// last.
using KeyedCurve = std::vector<std::pair<double, double>>;

// Direction in which a muscle bulges, tau: towards the side to which the joint folds, or along the normal of
// the bones' plane.
enum class BulgeAxis { flexion, plane_normal };
constexpr auto names_of(BulgeAxis) {
  return std::array{"flexion", "plane-normal"};
}
// A muscle's activation by joint angle: (1 - cos)/2, or the sine, as printed; 0 in the bind pose.
enum class Activation { cosine, sine };
constexpr auto names_of(Activation) {
  return std::array{"cosine", "sine"};
}

// A muscle, section 3.6 of the paper: flesh on a bone that bulges with a joint's bend or a contraction curve.
// Joints are given by name; muscle_bones.h resolves them.
struct Muscle {
  std::string name;
  std::string joint = {};  // the joint that bends; empty: none
  // Start of the upper bone and end of the lower one; empty: the neighbouring joints.
  std::string parent = {}, child = {};
  std::string bone = {};   // the joint whose bone carries the muscle; empty: the upper bone
  std::string layer = {};  // layer of its flesh; empty: any that is not kinematic
  Where where = {};        // restricts its flesh further; empty: all along the bone
  double gain = 1.5;       // of equation (17)
  BulgeAxis axis = BulgeAxis::flexion;
  Activation activation = Activation::cosine;
  KeyedCurve curve = {};        // replaces `activation`: by angle in degrees, less its bind-pose value
  KeyedCurve contraction = {};  // over clip time in s: bulges on all sides, whatever the joint does
  std::string contraction_channel = {};  // the same, from a channel of the clip: "JOINT.translation.x"
  double twist = 0.0;                    // share of the bone's twist that winds the fibres around it
  std::string twist_joint = {};  // joint whose rotation about the bone twists it; empty: at the bone's end
};

struct Pin {
  std::string name;
  Where where;
};
struct ProbeSet {
  std::string name;
  Where where;
};

// wind: a pressure (Pa) along a direction, on every vertex of the surface by its share of the rest area.
// point: a force (N) on a vertex set, distributed by mass.
enum class ForceKind { wind, point };
constexpr auto names_of(ForceKind) {
  return std::array{"wind", "point"};
}
struct Force {
  std::string name;
  ForceKind kind = ForceKind::point;
  Vector3d vector = Vector3d::Zero();  // Pa or N
  Where where;                         // point: which vertices
  double start = -1e30;                // s; acts for start <= t < end
  double end = 1e30;
};

// A solid that flesh does not enter. Its position is given in the bind pose (for a body without a skeleton,
// at rest). It follows a joint, or its own keys.
enum class ColliderShape { plane, sphere, capsule, box };
constexpr auto names_of(ColliderShape) {
  return std::array{"plane", "sphere", "capsule", "box"};
}
struct Collider {
  std::string name;
  ColliderShape shape = ColliderShape::plane;
  Vector3d center = Vector3d::Zero();           // sphere, box; plane: any point of it
  Vector3d normal{0, 1, 0};                     // plane: towards the flesh
  Vector3d from = Vector3d::Zero(), to = from;  // capsule: ends of its axis
  Vector3d size = Vector3d::Zero();             // box: edge lengths
  Vector3d rotation = Vector3d::Zero();         // box: degrees about this direction
  double radius = 0.0;                          // sphere, capsule; box: radius of its rounded edges
  double thickness = 0.0;                       // m: margin around it that flesh does not enter either
  double friction = 0.5;                        // Coulomb's coefficient, at least 0
  std::string joint = {};                       // the joint it follows; empty: none
  std::vector<double> times = {};               // s of clip time: keys of its own motion, ascending
  std::vector<Vector3d> offsets = {};           // per key, m from its position
  std::vector<Vector3d> turns = {};             // per key, degrees about this direction
};
// Maximum number in a scene.
inline constexpr std::size_t most_colliders = 32;

// automatic: the skin's own vertices if it encloses a volume and, for a character, is even enough; otherwise
// a cage around it. off: the skin's own, or an error. wrap: always a cage.
enum class Cage { automatic, off, wrap };
constexpr auto names_of(Cage) {
  return std::array{"auto", "off", "wrap"};
}

// How a surface or a character becomes tetrahedra.
struct BodySettings {
  Cage cage = Cage::automatic;
  double cage_detail = 100.0;  // a cage closes gaps up to twice the body's diagonal divided by this
  std::optional<std::uint32_t> vertices;  // target number of vertices; overrides Scene::resolution
  double thickness = 0.0;                 // m: distance of a prop's cage outside its skin
};

// Accuracy of the time step when substeps are "auto" (build/steps.h).
enum class Quality { draft, normal, final };
constexpr auto names_of(Quality) {
  return std::array{"draft", "normal", "final"};
}

// SolverSettings::viscosity of an implicit scene with joints that states none: nearly all that 480 substeps a
// second can give.
inline constexpr double viscosity_of_character = 0.002;

struct SolverSettings {
  Integrator integrator = Integrator::explicit_step;
  Rotation rotation = Rotation::qcp;
  WeightForm weights = WeightForm::symmetric;
  std::uint32_t substeps = 1;  // per frame, [1, 1000]; ignored with auto_substeps
  bool auto_substeps = false;  // substeps = "auto": build::choose_steps decides
  // Per implicit substep, [1, 1000]; nullopt: "auto", build::choose_steps decides.
  std::optional<std::uint32_t> iterations = {};
  Quality quality = Quality::normal;  // for auto_substeps of an implicit scene
  double viscosity = 0.0;             // s, [0, 1], of an implicit scene; at most a substep's length acts
  bool has_stated_viscosity = false;  // false: the default, of which a short substep may take less unsaid
};

// Whether the rest shape already includes the sag under gravity, so that only gravity's change in the bones'
// frames acts (f_i = m_i (g - R_i g)), or was shaped without gravity, which then acts in full.
enum class Rest { sculpted, weightless };
constexpr auto names_of(Rest) {
  return std::array{"sculpted", "weightless"};
}

// How to treat a clip's linear keys if they are less than a tenth of a second apart: as samples of a smooth
// motion (smooth_clip.h), or as corners between straight lines, as glTF defines them.
enum class KeyInterpolation { smooth, as_authored };
constexpr auto names_of(KeyInterpolation) {
  return std::array{"smooth", "as-authored"};
}

// Playback of the clip. The written frames show the clip from `start` to `end`, `loop` times, and then its
// last pose for `hold` seconds. Everything before frame 0 is simulated but not written.
struct Motion {
  Rest rest = Rest::weightless;                                    // characters: sculpted
  KeyInterpolation interpolation = KeyInterpolation::as_authored;  // characters from files: smooth
  double preroll = 0.0;    // s: blend from the bind pose, at the first pose's place, to the first pose
  double settle = 0.0;     // s, at most: hold the first pose until the flesh is still
  std::uint32_t loop = 1;  // cycles, at least 1
  bool seamless = false;   // run cycles before frame 0 until one ends as it began, then write one
  double seamless_tolerance = 1e-3;    // share of the body's extent: tolerance of "as it began"
  std::uint32_t seamless_cycles = 10;  // before frame 0, at most
  double hold = 0.0;                   // s
  std::uint64_t handles = 0;           // frames before and after the range; start, end and hold include them
  std::optional<double>
      acceleration_limit;              // m/s^2: limit of the skeleton's as flesh feels it; absent: by size
  std::vector<double> cuts;            // s of clip time: the motion jumps in the substep that contains it
  std::optional<double> cut_distance;  // m: a root that moves more in a frame jumps; absent: body's extent
};

// Flesh slower than this counts as still (root mean square over the free vertices, m/s).
inline constexpr double still_speed = 1e-3;

struct Scene {
  std::string name;    // file stem or built-in name
  std::string source;  // path as given, or "builtin:NAME"
  std::string text;    // scene text as parsed (after --set), for the manifest; also for a bare mesh
  std::vector<std::pair<std::string, std::string>>
      input_hashes;  // file, xxh3-64 hex, for everything that was read

  // The fascicle-convert program for the character's file, which a bake reads again; empty: next to this
  // program or on PATH.
  std::filesystem::path converter;

  Geometry geometry = Bar{};
  std::vector<PlacedCharacter> characters;  // from [character.NAME], joined in `geometry`; otherwise empty
  double scale = 1.0;                       // metres per unit of the mesh file
  std::optional<double> resolution;         // surfaces: target edge length of tetrahedra, metres
  BodySettings body;
  std::vector<BoneSegment> bones;
  SkeletonSettings skeleton;
  FleshSettings flesh;
  ContactSettings contact;
  std::vector<Layer> layers;  // at least one
  std::vector<FibreCurve> fibres;
  std::vector<Muscle> muscles;
  std::vector<Pin> pins;
  std::vector<ProbeSet> probes;
  std::vector<Force> forces;
  std::vector<Collider> colliders;
  Vector3d gravity{0, -9.81, 0};
  SolverSettings solver;
  Motion motion;
  double fps = 60.0;
  double start = 0.0;  // s of clip time at frame 0
  double end = 2.0;    // s of clip time; a cycle has round((end - start) fps) frames
  std::string clip;    // name or index; empty: the first
  std::string paint;   // file with the paint of the only character; empty: none
};

// Frames of one cycle of the clip.
std::uint64_t cycle_frames(const Scene& scene);
// Frames after frame 0: all cycles plus the hold.
std::uint64_t frame_count(const Scene& scene);
// Index of the character that the scene's joint belongs to; 0 if there is only one.
std::size_t character_of_joint(const Scene& scene, std::size_t joint);
// Whether a character comes from a mesh file: a single joint carries it, and it has no materials.
bool is_still_mesh(const PlacedCharacter& character);
// Whether a character is rigid and has no clip, a still mesh among them.
bool is_still_prop(const PlacedCharacter& character);
// From the world, or the bearer's space, to the character's own space: the inverse of its place.
Eigen::Matrix4d back_from(const PlacedCharacter& character);
// Indices of the characters that are not rigid props; of all if all are. {0} if the scene has only one body.
std::vector<std::size_t> characters_with_flesh(const Scene& scene);
// PlacedCharacter::first_joint of each of the scene's characters.
std::vector<std::uint32_t> first_joints(const Scene& scene);
// Joins the scene's characters into its geometry, side by side in the bind pose. Throws SceneError.
void join_characters(Scene& scene);
// Name of the clip that the scene plays; empty if none.
std::string clip_name(const Scene& scene);
// Substeps per frame. Throws std::invalid_argument if the scene leaves them to build::choose_steps.
std::uint32_t stated_substeps(const Scene& scene);

// Changes to a scene before it is checked, and the converter that reads it.
struct SceneOverrides {
  std::vector<std::string> set = {};  // "layers.fat.alpha=0.2"
  std::optional<double> fps = {}, start = {}, end = {};
  std::optional<std::string> clip = {};
  std::optional<std::string> rest = {};
  std::optional<std::string> interpolation = {};
  std::optional<std::string> preroll = {};  // frames, or seconds as in "0.5s"
  std::optional<double> settle = {}, hold = {};
  std::optional<std::uint64_t> handles = {};
  std::optional<std::uint32_t> loop = {};
  bool seamless = false;
  std::optional<std::string> cage = {}, cage_detail = {}, resolution = {};
  std::vector<std::string> rigid = {};  // joints, objects or materials
  std::optional<double> softness = {}, exaggerate = {};
  std::optional<std::string> quality = {};  // also sets substeps and iterations to "auto"
  std::vector<std::string> only = {};       // joints
  std::filesystem::path converter = {};     // Scene::converter; does not change the scene
};

bool has_overrides(const SceneOverrides& overrides);

// `name` is a scene file (.toml), a mesh (.mesh .node .ele .msh .vtu .off .obj .ply .stl), a character (.glb
// .gltf .vrm) or a built-in scene. Throws SceneError.
Scene load_scene(const std::string& name, const SceneOverrides& overrides = {});

// The scene's text as a file to edit: every key left at its default appears as a comment, and each key is
// explained. Parses to the same scene. The text's own comments are lost.
std::string documented_text(const Scene& scene);

// The built-in scenes, in the order `fascicle scenes` lists them.
struct BuiltinScene {
  std::string name;
  std::string description;
  std::string text;  // TOML, what `fascicle scenes NAME` prints
};
const std::vector<BuiltinScene>& builtin_scenes();
inline constexpr const char* default_scene = "jump";

// JSON Schema (2020-12) of the scene file, generated from the table that load_scene checks against; and the
// same as Markdown.
std::string scene_schema();
std::string scene_reference();

}  // namespace fascicle::scene
