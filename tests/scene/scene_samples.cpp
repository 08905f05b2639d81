#include "tests/scene/scene_samples.h"

#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "host/made/made_character.h"
#include "host/scene/paint_file.h"

namespace fascicle::tests {

using namespace scene;

std::string bar_sample() {
  return R"(# Every key of a bar's scene.
[scene]
description = "all keys"
gravity = [0.0, -1.5, 0.25]
fps = 24
start = 0.5
end = 2.5

[bar]
size = [0.5, 0.25, 0.125]
vertices = [5, 4, 3]
count = 2
gap = 0.0625
jitter = 0.125
seed = 7

[bones.thigh]
from = [0.0, 0.1, 0.1]
to = [0.4, 0.1, 0.1]

[contact]
self = true
unless_torn = true
distance = 0.0625
friction = 0.75
ignore = [["skin", "fat"], ["bone"]]
attribute = ""

[layers.skin]
alpha = 0.25
contact = false

[layers.fat]
alpha = 0.5
alpha_outer = 0.25
alpha_attribute = ""
beta = 0.75
damping = 3.5
density = 900.0
fibre = [0.0, 3.0, 4.0]
fibre_field = false
kinematic = false

[layers.fat.where.bone_distance]
minimum = 0.01
maximum = 0.05

[layers.bone]
kinematic = true

[layers.bone.where.capsule]
from = [0.0, 0.1, 0.1]
to = [0.4, 0.1, 0.1]
radius = 0.01

[fibres.biceps]
points = [[0.0, 0.1, 0.0], [0.2, 0.15, 0.0], [0.4, 0.1, 0.0]]
radius = 0.05

[solver]
integrator = "explicit"
rotation = "mueller2016"
weights = "kaneda2017"
substeps = 5

[pin.box.where.box]
minimum = [0.0, 0.0, 0.0]
maximum = [0.1, 0.1, 0.1]

[pin.plane.where.below]
axis = "x"
value = 0.01

[probe.all.where]
everywhere = true

[probe.ball.where.sphere]
center = [0.2, 0.1, 0.0]
radius = 0.1

[probe.core.where.volume_share]
minimum = 0.125
maximum = 0.5
by = "distance"

[probe.deep.where.depth]
minimum = 0.125
maximum = 0.5

[probe.tip.where.above]
axis = "z"
fraction = 0.9

[force.breeze]
kind = "wind"
vector = [0.0, 0.0, 10.0]

[force.push]
kind = "point"
vector = [1.0, 0.0, 0.0]
start = 0.25
end = 0.75

[force.push.where.above]
axis = "x"
fraction = 1.0

[collider.ball]
shape = "sphere"
center = [0.25, -0.125, 0.0625]
radius = 0.0625
thickness = 0.001
friction = 0.25

[collider.chair]
shape = "box"
size = [0.5, 0.25, 0.5]
rotation = [0.0, 30.0, 0.0]
radius = 0.015625
times = [0.5, 1.0, 1.5]
offsets = [[0.0, 0.0, 0.0], [0.0, 0.125, 0.0], [0.0, 0.125, 0.5]]
turns = [[0.0, 0.0, 0.0], [0.0, 90.0, 0.0], [0.0, 180.0, 0.0]]

[collider.floor]
shape = "plane"
normal = [0.0, 1.0, 0.125]

[collider.rod]
shape = "capsule"
from = [0.0, -0.25, 0.0]
to = [0.5, -0.25, 0.0]
radius = 0.03125
)";
}

std::string mesh_sample() {
  return R"(# Every key of a mesh.
[mesh]
file = "tetrahedron.off"
scale = 0.5
resolution = 0.25

[body]
cage = "wrap"
cage_detail = 50.0
resolution = "400"

[layers.body]
alpha = 0.5
)";
}

std::string character_sample() {
  return R"(# Every key of a character.
[character]
file = "CesiumMan.glb"
clip = "0"
resolution = 0.05

[skeleton]
bones = ["leg_joint_L_1"]
not_bones = ["leg_joint_L_5", "leg_joint_R_5"]
kinematic = ["Skeleton_neck_joint_1"]
simulated = ["Skeleton_neck_joint_2"]
rigid = ["Skeleton_arm_joint_R__3_"]
only = ["leg_joint_L_1"]
least_share = 0.02
connect = false

[flesh]
softness = 1.25
exaggerate = 1.5

[layers.body]
alpha = 0.5
inertia_scale = 0.5
volume = 0.75
sliding = true

[motion]
rest = "sculpted"
interpolation = "as-authored"
preroll = 0.25
settle = 0.5
loop = 1
seamless = false
seamless_tolerance = 0.01
seamless_cycles = 5
hold = 0.125
handles = 3
cuts = [0.5, 0.25]
acceleration_limit = 500.0
cut_distance = 4.0

[collider.knee]
shape = "sphere"
radius = 0.05
joint = "leg_joint_L_1"

[probe.head.where.joints]
names = ["Skeleton_neck_joint_1"]
share = 0.75
below = false

[probe.jacket.where.material]
names = ["jacket"]

[probe.hat.where.object]
names = ["hat"]

[probe.near.where.bone_distance]
maximum = 0.02
per_bone = { leg_joint_L_1 = 0.03, "leg joint.R" = 0.01 }

[probe.deep.where.depth]
maximum = 0.3
per_bone = { leg_joint_L_1 = 0.25 }

[probe.paint.where.painted]
attribute = "_LAYER"
minimum = 0.5
maximum = 1.5
)";
}

std::string made_surface_sample() {
  return R"(# What a surface made in code has instead of a file.
[mesh]
made = "bunny"

[layers.body]
alpha = 0.5
)";
}

std::string made_sample() {
  return R"(# What a character made in code has instead of a file.
[character]
made = "arm"
paint = "arm.paint.json"

[layers.body]
alpha = 0.5

[muscle.biceps]
joint = "forearm"
parent = "upper_arm"
child = "hand"
bone = "forearm"
layer = "body"
gain = 0.75
axis = "plane-normal"
activation = "sine"
contraction = [[0.0, 0.25], [1.0, 0.5]]
twist = 0.5
twist_joint = "hand"

[muscle.biceps.where.sphere]
center = [0.3, 0.0, 0.0]
radius = 0.2

[muscle.other]
joint = "hand"
curve = [[0.0, 0.0], [90.0, 1.0]]
contraction_channel = "hand.scale.x"
)";
}

std::string characters_sample() {
  return R"(# What one of several characters has.
[character.left]
made = "arm"
paint = "arm.paint.json"
clip = "curl"
joint = "right"
at = [-0.5, 0.25, 0.125]
turn = [0.0, 45.0, 0.0]
start = 0.25
rigid = true
thickness = 0.03125
resolution = 0.0625

[character.right]
file = "CesiumMan.glb"

[layers.body]
alpha = 0.5
)";
}

std::string implicit_sample() {
  return R"(# What the implicit integrator has instead of alpha and damping.
[bar]
size = [0.5, 0.25, 0.25]

[layers.fat]
youngs_modulus = 3000.0
damping_ratio = 0.25
least_volume = 0.5

[layers.deep]
frequency = 3.5

[layers.deep.where.below]
axis = "x"
fraction = 0.5

[layers.skin]
material = "skin"

[layers.skin.where.above]
axis = "x"
fraction = 0.9

[solver]
integrator = "implicit"
substeps = "auto"
iterations = 12
quality = "draft"
viscosity = 0.003
)";
}

void write_tetrahedron_off(const std::filesystem::path& path) {
  write_file(path, "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
}

void write_arm_paint(const std::filesystem::path& path) {
  rig::Paint paint;
  const rig::Character arm = made::make_character("arm");
  paint.surface = rig::surface_hash(arm.surface);
  paint.vertices = arm.surface.vertices.size();
  paint.attributes = {{"_RIGID", {3}, {1.0f}}};
  write_file(path, paint_text(paint));
}

namespace {

class Description {
 public:
  Description() { out_ << std::hexfloat; }
  std::string text() const { return out_.str(); }

  template <class... Values>
  void line(const char* name, const Values&... values) {
    out_ << name;
    ((out_ << ' ', add(values)), ...);
    out_ << '\n';
  }

 private:
  template <class Value>
  void add(const Value& value) {
    if constexpr (base::Named<Value>)
      out_ << name_of(value);
    else
      out_ << value;
  }
  void add(const Vector3d& v) { out_ << v.x() << ' ' << v.y() << ' ' << v.z(); }
  template <class Value>
  void add(const std::optional<Value>& value) {
    if (value) add(*value);
  }
  void add(const Where& where) {
    for (const Shape& shape : where) std::visit([&](const auto& s) { add_shape(s); }, shape);
  }
  void add_shape(const Box& s) { out_ << "box ", add(s.minimum), out_ << ' ', add(s.maximum); }
  void add_shape(const Sphere& s) { out_ << "sphere ", add(s.center), out_ << ' ' << s.radius; }
  void add_shape(const Capsule& s) {
    out_ << "capsule ", add(s.from), out_ << ' ', add(s.to), out_ << ' ' << s.radius;
  }
  void add_shape(const HalfSpace& s) {
    out_ << "half_space " << static_cast<int>(s.axis) << s.below << s.is_fraction << ' ' << s.value;
  }
  void add(const std::vector<std::string>& texts) {
    for (const std::string& text : texts) out_ << text << ' ';
  }
  void add_range(double minimum, double maximum, const PerBone& per_bone) {
    out_ << minimum << ' ' << maximum;
    for (const auto& [name, value] : per_bone) out_ << ' ' << name << ' ' << value;
  }
  void add_shape(const BoneDistance& s) {
    out_ << "bone_distance ", add_range(s.minimum, s.maximum, s.per_bone);
  }
  void add_shape(const Depth& s) { out_ << "depth ", add_range(s.minimum, s.maximum, s.per_bone); }
  void add_shape(const VolumeShare& s) {
    out_ << "volume_share " << s.minimum << ' ' << s.maximum << ' ' << s.by_distance;
  }
  void add_shape(const JointSet& s) { out_ << "joints " << s.share << s.below << ' ', add(s.names); }
  void add_shape(const PartSet& s) { out_ << "parts " << s.by_object << ' ', add(s.names); }
  void add_shape(const Painted& s) {
    out_ << "painted " << s.attribute << ' ' << s.minimum << ' ' << s.maximum;
  }
  void add_shape(const Everywhere&) { out_ << "everywhere"; }

  std::ostringstream out_;
};

}  // namespace

std::string describe(const Scene& scene) {
  Description d;
  d.line("name", scene.name, scene.source);
  d.line("geometry", scene.geometry.index(), scene.scale, scene.resolution);
  d.line("body", scene.body.cage, scene.body.cage_detail,
         scene.body.vertices ? std::to_string(*scene.body.vertices) : "");
  if (const auto* bar = std::get_if<Bar>(&scene.geometry)) {
    d.line("bar", bar->size, bar->vertices[0], bar->vertices[1], bar->vertices[2], bar->count, bar->gap,
           bar->jitter, bar->seed);
  } else if (const auto* surface = std::get_if<mesh::SurfaceMesh>(&scene.geometry)) {
    for (const Vector3d& p : surface->vertices) d.line("vertex", p);
    for (const auto& t : surface->triangles) d.line("triangle", t[0], t[1], t[2]);
  } else if (const auto* character = std::get_if<rig::Character>(&scene.geometry)) {
    for (const Vector3d& p : character->surface.vertices) d.line("vertex", p);
  }
  for (const PlacedCharacter& c : scene.characters)
    d.line("character", c.settings.name, c.settings.file, c.settings.made, c.settings.paint, c.settings.clip,
           c.settings.joint, c.settings.at, c.settings.turn, c.settings.start, c.settings.rigid,
           c.settings.thickness, c.settings.resolution, c.bind_offset, c.first_joint);
  for (const BoneSegment& bone : scene.bones) d.line("bone", bone.name, bone.from, bone.to);
  d.line("skeleton", scene.skeleton.bones, scene.skeleton.not_bones, scene.skeleton.kinematic,
         scene.skeleton.simulated, scene.skeleton.rigid, scene.skeleton.only, scene.skeleton.least_share,
         scene.skeleton.connect);
  d.line("flesh", scene.flesh.softness, scene.flesh.exaggerate);
  d.line("contact", scene.contact.self, scene.contact.unless_torn, scene.contact.distance.value_or(-1.0),
         scene.contact.friction, scene.contact.attribute);
  for (const std::vector<std::string>& names : scene.contact.ignore) d.line("ignore", names);
  for (const FibreCurve& curve : scene.fibres) {
    d.line("fibres", curve.name, curve.radius);
    for (const Vector3d& point : curve.points) d.line("point", point);
  }
  for (const Layer& l : scene.layers) {
    d.line("layer", l.name, l.alpha, l.alpha_outer, l.alpha_attribute, l.beta, l.damping, l.density, l.fibre,
           l.fibre_field, l.kinematic, l.inertia_scale, l.volume, l.sliding, l.least_volume, l.where);
    d.line("stiffness", l.youngs_modulus, l.frequency, l.material, l.damping_ratio);
    d.line("contact", l.contact);
  }
  for (const Muscle& m : scene.muscles) {
    d.line("muscle", m.name, m.joint, m.parent, m.child, m.bone, m.layer, m.where, m.gain, m.axis,
           m.activation, m.contraction_channel, m.twist, m.twist_joint);
    for (const auto& [x, value] : m.curve) d.line("curve", x, value);
    for (const auto& [x, value] : m.contraction) d.line("contraction", x, value);
  }
  for (const Pin& pin : scene.pins) d.line("pin", pin.name, pin.where);
  for (const ProbeSet& probe : scene.probes) d.line("probe", probe.name, probe.where);
  for (const Force& f : scene.forces) {
    d.line("force", f.name, f.kind, f.vector, f.where, f.start, f.end);
  }
  for (const Collider& c : scene.colliders) {
    d.line("collider", c.name, c.shape, c.center, c.normal, c.from, c.to, c.size, c.rotation, c.radius,
           c.thickness, c.friction, c.joint);
    for (const double time : c.times) d.line("time of key", time);
    for (const Vector3d& offset : c.offsets) d.line("offset", offset);
    for (const Vector3d& turn : c.turns) d.line("turned", turn);
  }
  d.line("gravity", scene.gravity);
  d.line("solver", scene.solver.integrator, scene.solver.rotation, scene.solver.weights,
         scene.solver.substeps, scene.solver.auto_substeps, scene.solver.iterations, scene.solver.quality,
         scene.solver.viscosity, scene.solver.has_stated_viscosity);
  d.line("time", scene.fps, scene.start, scene.end, scene.clip, scene.paint);
  const Motion& m = scene.motion;
  d.line("motion", m.rest, m.interpolation, m.preroll, m.settle, m.loop, m.seamless, m.seamless_tolerance,
         m.seamless_cycles, m.hold, m.handles, m.acceleration_limit, m.cut_distance);
  for (const double cut : m.cuts) d.line("cut", cut);
  return d.text();
}

void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  ASSERT_TRUE(out.good()) << path;
}

}  // namespace fascicle::tests
