#include "host/rig/paint.h"
#include "host/scene/builtin_scenes.h"
#include "host/scene/paint_file.h"
#include "tests/fuzz/painted_surface.h"
#include "tests/fuzz/seeds.h"

namespace fascicle::fuzz {
namespace {

// Together these use most keys. There are no generated characters, which would take longer than all the rest.
const std::string bar_scene = R"([scene]
description = "a bar"
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
friction = 0.75
ignore = [["skin", "fat"], ["bone"]]
[layers.skin]
alpha = 0.25
contact = false
[layers.fat]
alpha = 0.5
alpha_outer = 0.25
beta = 0.75
density = 900.0
fibre = [0.0, 3.0, 4.0]
where = { bone_distance = { maximum = 0.1 } }
[fibres.a]
points = [[0, 0, 0], [0, 0, 1]]
[pin.end]
where = { below = { axis = "x", value = 0.01 } }
[force.push]
kind = "point"
vector = [0, 1, 0]
where = { sphere = { center = [0, 0, 0], radius = 0.1 } }
[collider.floor]
shape = "plane"
[solver]
substeps = 8
)";

const std::string implicit_scene = R"([mesh]
file = "tetrahedron.off"
scale = 0.5
resolution = 0.25
[body]
cage = "wrap"
resolution = "400"
[layers.fat]
material = "fat"
[layers."deep"]
youngs_modulus = 2e4 # Pa
damping_ratio = 0.5
where = { below = { axis = "x", fraction = 0.5 } }
[solver]
integrator = "implicit"
substeps = "auto"
quality = 'draft'
iterations = 4
)";

const std::string character_scene = R"([character]
file = "column.glb"
clip = "bend"
resolution = 0.05
[skeleton]
bones = ["lower"]
kinematic = ["upper"]
least_share = 0.02
[flesh]
softness = 1.25
[layers.body]
alpha = 0.5
sliding = true
[layers.bone]
kinematic = true
where = { bone_distance = { maximum = 0.02, per_bone = { lower = 0.03 } } }
[muscle.a]
joint = "upper"
curve = [[0.0, 0.0], [90.0, 1.0]]
[motion]
preroll = 0.25
loop = 2
cuts = [0.5, 0.25]
[probe.top.where.joints]
names = ["upper"]
share = 0.75
[collider.ball]
shape = "sphere"
radius = 0.05
joint = "upper"
)";

const std::string jobs_text = R"(output = "out/walks"
format = ["pc2"]
keep_frames = false
[job.fat-man]
scene = "arm"
clips = ["walk", "jump"]
set = ["solver.substeps=16"]
format = ["glb", "abc"]
[job.fat-man.vary]
"layers.fat.alpha" = [0.1, 0.3]
"layers.fat" = [{ alpha = 1 }]
[job.bar]
scene = "bar-hang-none"
)";

std::string sample_paint() {
  rig::Paint paint;
  paint.surface = rig::surface_hash(painted_surface());
  paint.vertices = 4;
  paint.attributes = {{"_LAYER", {0, 3}, {3, 2}}, {"_FIBER", {1}, {0, 1, 0}}};
  return fascicle::scene::paint_text(paint);
}

}  // namespace

void add_scene_seeds(std::vector<Seed>& seeds) {
  seeds.push_back({"scene", "bar", bar_scene});
  seeds.push_back({"scene", "implicit", implicit_scene});
  seeds.push_back({"scene", "character", character_scene});
  for (const fascicle::scene::EmbeddedScene& builtin : fascicle::scene::embedded_scenes())
    if (builtin.text.find("made = ") == std::string::npos)
      seeds.push_back({"scene", std::string(builtin.name), std::string(builtin.text)});
  seeds.push_back({"set", "number", "layers.fat.alpha=0.25"});
  seeds.push_back({"set", "list", "bar.vertices=[3, 3, 3]"});
  seeds.push_back({"set", "table", "probe.new={ where = { everywhere = true } }"});
  seeds.push_back({"set", "text", "scene.description=text"});
  seeds.push_back({"jobs", "two", jobs_text});
  seeds.push_back({"paint", "two", sample_paint()});
}

}  // namespace fascicle::fuzz
