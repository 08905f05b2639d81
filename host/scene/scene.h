// Scene: what the artist said, read and checked, with the meshes it names loaded. Metres, kilograms, seconds,
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

// A box of Kuhn tetrahedra, six a cell, from the origin to `size`; `vertices` along each axis (at least 2).
// Interior vertices are moved by up to jitter x spacing along each axis.
struct Bar {
  Vector3d size{0.4, 0.08, 0.08};
  std::array<std::uint32_t, 3> vertices{21, 5, 5};
  std::uint32_t count = 1;  // so many of them, one above the other
  double gap = 0.01;        // m between one and the next
  double jitter = 0.0;      // [0, 0.3]
  std::uint64_t seed = 1;
};

using Geometry = std::variant<Bar, mesh::TetMesh, mesh::SurfaceMesh, rig::Character>;

enum class Axis { x = 0, y = 1, z = 2 };
constexpr auto names_of(Axis) {
  return std::array{"x", "y", "z"};
}

// Parts of space. A point is in a Where if it is in any of its shapes. All bounds are inclusive.
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
// Below or above a plane across an axis, at a coordinate in metres, or at a fraction of the bounding box.
struct HalfSpace {
  Axis axis = Axis::y;
  bool below = true;
  bool is_fraction = false;
  double value = 0.0;
};
// Other maxima for the vertices whose nearest bone is that of a joint, by the joint's name.
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
// The vertices between two shares of the body's volume, counted from the bones outward: ordered by relative
// depth, or by distance from the bone.
struct VolumeShare {
  double minimum = 0.0;
  double maximum = 0.0;
  bool by_distance = false;
};
// Vertices with at least `share` of their weights on the joints named and, if `below`, those below them.
struct JointSet {
  std::vector<std::string> names;
  double share = 0.5;
  bool below = true;
};
// Vertices whose nearest place on the skin is of a material, or of an object, with one of these names
// (SurfacePart).
struct PartSet {
  std::vector<std::string> names;
  bool by_object = false;
};
// Where a painted value lies within [minimum, maximum]. The attribute is named as in the file, a colour with
// its channel: "_LAYER", "COLOR_0.r".
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

// Of a layer's inertia_scale: flesh that feels four times the skeleton's acceleration.
inline constexpr double most_inertia = 4.0;

struct Layer {
  std::string name;
  double alpha = 1.0;                 // [0, 1] per substep
  std::optional<double> alpha_outer;  // at the layer's outer side; alpha is then that of its inner one
  std::string alpha_attribute;        // painted, [0, 1]: alpha is multiplied by it; empty: none
  // With integrator "implicit" a layer's stiffness is one of these, or its material's.
  std::optional<double> youngs_modulus;  // Pa
  std::optional<double> frequency;       // Hz: of its lowest mode, everything else held still
  std::string material;                  // "fat", ... (material.h); empty: none
  double beta = 0.0;                     // [0, 1]
  double damping = 0.0;                  // 1/s, >= 0
  std::optional<double> damping_ratio;   // of the lowest mode; in place of damping
  double density = 1000.0;               // kg/m^3, > 0
  std::optional<Vector3d> fibre;         // constant direction, normalised when read
  bool fibre_field = false;              // the direction comes from the fibre field; not beside `fibre`
  bool kinematic = false;                // a bone layer: moved by skinning, pinned without a skeleton
  bool sliding = false;                  // skin: tied to the flesh of other layers across it only
  double inertia_scale = 1.0;  // [0, most_inertia]: share of the skeleton's acceleration that the flesh feels
  double volume = 0.0;         // [0, 1]: how strongly volume is drawn back to rest
  double least_volume = 0.0;   // [0, 0.9]: share of its volume below which it is not crushed
  bool contact = true;         // its flesh meets other flesh, where that is asked for
  Where where;          // empty: everything no other layer claims; else the last layer that matches wins
  Where by_paint = {};  // where a paint file puts it as well; goes before all that is not painted
};

// One of several characters of a scene, [character.NAME], and where it stands.
struct CharacterSettings {
  std::string name;
  std::string file = {};  // relative to the scene file's folder; empty: `made`
  std::string made = {};
  std::string paint = {};                 // file with what is painted on it, relative as `file`; empty: none
  std::string clip = {};                  // name or index; empty: the first
  std::string joint = {};                 // of another character, that it goes with; empty: none
  Vector3d at = Vector3d::Zero();         // m: where its origin stands; with `joint` from that one's place
  Vector3d turn = Vector3d::Zero();       // degrees about this direction: how it is turned there
  double start = 0.0;                     // s of the scene's time: when its clip begins
  bool rigid = false;                     // all of its flesh follows its skeleton
  double thickness = 0.0;                 // m, of a rigid one: how far from it flesh stays
  std::optional<double> resolution = {};  // wanted edge length of its tetrahedra, m
};

// The same, read. Names of its joints, objects and materials begin with NAME/. What is said by place
// (`where`, drawn fibres and bones, solids that go with a joint) is seen in its own bind pose.
struct PlacedCharacter {
  CharacterSettings settings;
  std::filesystem::path file = {};          // empty: made in code
  rig::Character own = {};                  // as it is alone but for the names
  Vector3d bind_offset = Vector3d::Zero();  // m: from its own bind pose to where that stands in the scene's
  std::uint32_t first_joint = 0;            // of the scene's skeleton: the joint NAME; its own joints follow
  std::uint32_t first_node = 0;             // of the nodes in the scene's SurfacePart

  std::optional<std::uint32_t> bearer = {};  // the scene's joint that it goes with
  // From the space of its file to the world, or to its bearer's space.
  Eigen::Matrix4d place = Eigen::Matrix4d::Identity();
};

// What the user says of the joints, by name; where nothing is said, the skin decides which are bones.
struct SkeletonSettings {
  std::vector<std::string> bones;      // are bones
  std::vector<std::string> not_bones;  // are none
  std::vector<std::string> kinematic;  // their flesh follows the skeleton
  std::vector<std::string> simulated;  // their flesh does not
  std::vector<std::string> rigid;      // joints, objects or materials: their skin follows its joints alone
  std::vector<std::string> only;       // if any: the flesh of all other joints follows the skeleton
  double least_share = 0.01;           // of the skin's area, that a bone must move
  bool connect = true;                 // bone layers are completed along the bones, until they hold together
};

// What the user wishes of all flesh at once. Layers are read first: their stiffness and inertia_scale hold
// both.
struct FleshSettings {
  double softness = 1.0;    // > 0: all free layers' moduli are divided by it
  double exaggerate = 1.0;  // [0, 4]: all free layers' inertia_scale is multiplied by it
};

// Lists of one or two names.
using NameLists = std::vector<std::vector<std::string>>;

// How flesh meets flesh.
struct ContactSettings {
  bool self = false;               // flesh of a character does not pass through other flesh of its own
  std::optional<double> distance;  // m: flesh nearer than that at rest does not meet; absent: by the mesh
  double friction = 0.5;           // Coulomb's coefficient, at least 0
  NameLists ignore;                // pairs of flesh that do not meet; a name alone meets nothing
  std::string attribute;           // painted: below a half flesh meets nothing; empty: none
};
// At most so many distinct names in pairs of ContactSettings::ignore: the bits of a group.
inline constexpr std::size_t most_ignored_names = 32;

// Muscle fibres drawn as a polyline from origin to insertion, m.
struct FibreCurve {
  std::string name;
  std::vector<Vector3d> points;  // at least two
  std::optional<double> radius;  // m: how far around it holds; the mean edge where absent
};

// A curve through keys (x, value), x ascending: straight between them, held before the first and after the
// last.
using KeyedCurve = std::vector<std::pair<double, double>>;

// To where a muscle bulges, tau: to the side to which the joint folds, or along the normal of the bones'
// plane.
enum class BulgeAxis { flexion, plane_normal };
constexpr auto names_of(BulgeAxis) {
  return std::array{"flexion", "plane-normal"};
}
// What a joint's angle makes of a muscle: (1 - cos)/2, or the sine, as printed; 0 in the bind pose.
enum class Activation { cosine, sine };
constexpr auto names_of(Activation) {
  return std::array{"cosine", "sine"};
}

// A muscle, section 3.6 of the paper: flesh on a bone that bulges as a joint bends, or as it is told to.
// Joints by name; muscle_bones.h says which bones and flesh that makes.
struct Muscle {
  std::string name;
  std::string joint = {};  // the joint that bends; empty: none
  // Where the upper bone begins and the lower one ends; empty: the next joints.
  std::string parent = {}, child = {};
  std::string bone = {};   // the joint whose bone carries the muscle; empty: that of the upper bone
  std::string layer = {};  // its flesh is of this layer; empty: of any that is not kinematic
  Where where = {};        // and here; empty: all along the bone
  double gain = 1.5;       // of equation (17)
  BulgeAxis axis = BulgeAxis::flexion;
  Activation activation = Activation::cosine;
  KeyedCurve curve = {};        // of the angle in degrees instead; its value in the bind pose is taken off
  KeyedCurve contraction = {};  // over the time of the clip, s: bulges on all sides, whatever the joint does
  std::string contraction_channel = {};  // the same, from the clip: "JOINT.translation.x"
  double twist = 0.0;                    // share of the bone's twist that carries the fibres around it
  std::string twist_joint = {};  // the joint whose turn about the bone twists it; empty: where the bone ends
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
// point: a force (N) on a vertex set, spread by mass.
enum class ForceKind { wind, point };
constexpr auto names_of(ForceKind) {
  return std::array{"wind", "point"};
}
struct Force {
  std::string name;
  ForceKind kind = ForceKind::point;
  Vector3d vector = Vector3d::Zero();  // Pa or N
  Where where;                         // point: which vertices
  double start = 0.0;                  // s; acts for start <= t < end
  double end = 1e30;
};

// A solid that flesh does not enter. Where it stands is said for the bind pose (of a body without a skeleton,
// for the body at rest); it goes with a joint, or along keys of its own.
enum class ColliderShape { plane, sphere, capsule, box };
constexpr auto names_of(ColliderShape) {
  return std::array{"plane", "sphere", "capsule", "box"};
}
struct Collider {
  std::string name;
  ColliderShape shape = ColliderShape::plane;
  Vector3d center = Vector3d::Zero();           // sphere, box; plane: any point of it
  Vector3d normal{0, 1, 0};                     // plane: to the side where the flesh is
  Vector3d from = Vector3d::Zero(), to = from;  // capsule: where its axis begins and ends
  Vector3d size = Vector3d::Zero();             // box: its edges
  Vector3d rotation = Vector3d::Zero();         // box: degrees about this direction
  double radius = 0.0;                          // sphere, capsule; box: of its rounded edges
  double thickness = 0.0;                       // m around it that flesh does not enter either
  double friction = 0.5;                        // Coulomb's coefficient, at least 0
  std::string joint = {};                       // it goes with this joint; empty: it does not
  std::vector<double> times = {};               // s of the clip: keys of its own motion, ascending
  std::vector<Vector3d> offsets = {};           // at each of them, m from where it stands
  std::vector<Vector3d> turns = {};             // at each of them, degrees about this direction
};
// At most so many in a scene.
inline constexpr std::size_t most_colliders = 32;

// automatic: the skin's own vertices where it encloses a volume and, of a character, is even enough; else a
// cage around it. off: the skin's or an error. wrap: always a cage.
enum class Cage { automatic, off, wrap };
constexpr auto names_of(Cage) {
  return std::array{"auto", "off", "wrap"};
}

// How a surface or a character becomes tetrahedra.
struct BodySettings {
  Cage cage = Cage::automatic;
  double cage_detail = 100.0;  // a cage closes gaps narrower than the body's diagonal divided by this
  std::optional<std::uint32_t> vertices;  // wanted number of vertices; goes before Scene::resolution
  double thickness = 0.0;                 // m: how far outside the skin the cage of a prop stands
};

// How small the time step's errors shall be where substeps are "auto" (build/steps.h).
enum class Quality { draft, normal, final };
constexpr auto names_of(Quality) {
  return std::array{"draft", "normal", "final"};
}

struct SolverSettings {
  Integrator integrator = Integrator::explicit_step;
  Rotation rotation = Rotation::qcp;
  WeightForm weights = WeightForm::symmetric;
  std::uint32_t substeps = 1;  // a frame, [1, 1000]; of no meaning beside auto_substeps
  bool auto_substeps = false;  // substeps = "auto": build::choose_steps says how many
  // An implicit substep, [1, 1000]; none: "auto", build::choose_steps says how many.
  std::optional<std::uint32_t> iterations = {};
  Quality quality = Quality::normal;  // of an implicit scene's auto_substeps
};

// What the rest shape is: hung by gravity already, so that only gravity's change in the bones' frames acts
// (f_i = m_i (g - R_i g)), or shaped without gravity, which then acts in full.
enum class Rest { sculpted, weightless };
constexpr auto names_of(Rest) {
  return std::array{"sculpted", "weightless"};
}

// What a clip's linear keys are where they lie closer than a tenth of a second: samples of a smooth motion
// (smooth_clip.h), or corners between straight lines, as glTF has it.
enum class KeyInterpolation { smooth, as_authored };
constexpr auto names_of(KeyInterpolation) {
  return std::array{"smooth", "as-authored"};
}

// How time runs around the clip. The frames that are written show the clip from `start` to `end`, `loop`
// times, and then its last pose for `hold` seconds; what comes before frame 0 is stepped and not written.
struct Motion {
  Rest rest = Rest::weightless;                                    // characters: sculpted
  KeyInterpolation interpolation = KeyInterpolation::as_authored;  // characters from files: smooth
  double preroll = 0.0;                // s: from the bind pose, at the first pose's place, to the first pose
  double settle = 0.0;                 // s at most: the first pose held until the flesh is still
  std::uint32_t loop = 1;              // cycles, at least 1
  bool seamless = false;               // cycles before frame 0, until one ends as it began; one is written
  double seamless_tolerance = 1e-3;    // of the body's extent: how near is "as it began"
  std::uint32_t seamless_cycles = 10;  // before frame 0, at most
  double hold = 0.0;                   // s
  std::uint64_t handles = 0;           // frames before and after the range; start, end and hold have them
  std::optional<double>
      acceleration_limit;              // m/s^2: the flesh feels no more of the skeleton's; absent: by size
  std::vector<double> cuts;            // s of the clip: the motion jumps in the substep that holds it
  std::optional<double> cut_distance;  // m: a root that goes further in a frame has jumped; absent: the
                                       // body's extent
};

// Flesh slower than this (root mean square over the free vertices, m/s) is still.
inline constexpr double still_speed = 1e-3;

struct Scene {
  std::string name;    // file stem or built-in name
  std::string source;  // path as given, or "builtin:NAME"
  std::string text;    // scene file's text as parsed (after --set), for the manifest; a bare mesh has one too
  std::vector<std::pair<std::string, std::string>>
      input_hashes;  // file, xxh3-64 hex: everything that was read

  // The program fascicle-convert for the character's file, which is read again when it is baked; empty: found
  // beside this program or on PATH.
  std::filesystem::path converter;

  Geometry geometry = Bar{};
  std::vector<PlacedCharacter> characters;  // of [character.NAME], which `geometry` joins; else empty
  double scale = 1.0;                       // metres per unit of the mesh file
  std::optional<double> resolution;         // surfaces: wanted edge length of tetrahedra, metres
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
  double start = 0.0;  // s of the clip where frame 0 stands
  double end = 2.0;    // s of the clip; a cycle has round((end - start) fps) frames
  std::string clip;    // name or index; empty: the first
  std::string paint;   // file with what is painted on the only character; empty: none
};

// Frames of one cycle of the clip.
std::uint64_t cycle_frames(const Scene& scene);
// Frames after frame 0: all cycles and the hold.
std::uint64_t frame_count(const Scene& scene);
// The number of the character that the scene's joint belongs to; 0 where there are not several.
std::size_t character_of_joint(const Scene& scene, std::size_t joint);
// Whether a character's file is a still mesh: one joint carries it, and it has no looks.
bool is_still_mesh(const PlacedCharacter& character);
// Whether a character is rigid and has no clip, a still mesh among them.
bool is_still_prop(const PlacedCharacter& character);
// From the world, or the bearer's space, to where a character stands alone: the inverse of its place.
Eigen::Matrix4d back_from(const PlacedCharacter& character);
// PlacedCharacter::first_joint of each of the scene's characters.
std::vector<std::uint32_t> first_joints(const Scene& scene);
// Joins the scene's characters into its geometry, beside each other in the bind pose. Throws SceneError.
void join_characters(Scene& scene);
// The name of the clip that the scene plays; empty where it plays none.
std::string clip_name(const Scene& scene);
// Substeps of a frame. Throws std::invalid_argument where the scene leaves them to build::choose_steps.
std::uint32_t stated_substeps(const Scene& scene);

// Changes to a scene before it is checked, and what reads it.
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
  std::optional<std::string> quality = {};  // and "auto" for substeps and iterations
  std::vector<std::string> only = {};       // joints
  std::filesystem::path converter = {};     // Scene::converter; changes nothing in the scene
};

bool has_overrides(const SceneOverrides& overrides);

// `name` is a scene file (.toml), a mesh (.mesh .node .ele .msh .vtu .off .obj .ply .stl), a character (.glb
// .gltf .vrm) or a built-in scene. Throws SceneError.
Scene load_scene(const std::string& name, const SceneOverrides& overrides = {});

// The scene's text with every key that it leaves at its default, as comments, and what each key means: a file
// to edit. Reads as the scene itself does. Lines of the text's own comments are lost.
std::string documented_text(const Scene& scene);

// The built-in scenes, in the order `fascicle scenes` lists them.
struct BuiltinScene {
  std::string name;
  std::string description;
  std::string text;  // TOML, what `fascicle scenes NAME` prints
};
const std::vector<BuiltinScene>& builtin_scenes();
inline constexpr const char* default_scene = "jump";

// JSON Schema (2020-12) of the scene file, made from the same table that load_scene checks against; the same
// in Markdown, to be read.
std::string scene_schema();
std::string scene_reference();

}  // namespace fascicle::scene
