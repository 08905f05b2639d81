#include "host/scene/scene_file.h"

#include <cmath>

#include "host/scene/input_files.h"
#include "host/scene/made_character.h"
#include "host/scene/overrides.h"
#include "host/scene/pose.h"
#include "host/scene/scene_check.h"

namespace fascicle::scene {
namespace {

// The read functions take the value if the key is there and else leave what stands. check_scene has seen the
// types.

double number_of(const toml::node& node) {
  const auto* integer = node.as_integer();
  return integer != nullptr ? static_cast<double>(integer->get()) : node.as_floating_point()->get();
}

Vector3d vector_of(const toml::node& node) {
  const toml::array& array = *node.as_array();
  return {number_of(array[0]), number_of(array[1]), number_of(array[2])};
}

void read(const toml::table& table, const char* key, double& out) {
  if (const toml::node* node = table.get(key)) out = number_of(*node);
}

void read(const toml::table& table, const char* key, std::optional<double>& out) {
  if (const toml::node* node = table.get(key)) out = number_of(*node);
}

void read(const toml::table& table, const char* key, std::uint32_t& out) {
  if (const toml::node* node = table.get(key)) out = static_cast<std::uint32_t>(node->as_integer()->get());
}

void read(const toml::table& table, const char* key, std::uint64_t& out) {
  if (const toml::node* node = table.get(key)) out = static_cast<std::uint64_t>(node->as_integer()->get());
}

void read(const toml::table& table, const char* key, bool& out) {
  if (const toml::node* node = table.get(key)) out = node->as_boolean()->get();
}

void read(const toml::table& table, const char* key, std::string& out) {
  if (const toml::node* node = table.get(key)) out = node->as_string()->get();
}

void read(const toml::table& table, const char* key, Vector3d& out) {
  if (const toml::node* node = table.get(key)) out = vector_of(*node);
}

const toml::table& table_at(const toml::table& table, const char* key) {
  static const toml::table empty;
  const toml::node* node = table.get(key);
  return node != nullptr ? *node->as_table() : empty;
}

// Calls use(name, table, path) for each table of a named_tables key, in the file's order.
template <class Use>
void for_each_named(const toml::table& root, const char* key, const Use& use) {
  for (const auto& [name, node] : in_order(table_at(root, key))) {
    use(std::string(name->str()), *node->as_table(), join_path(key, name->str()));
  }
}

// What shapes may refer to.
struct Surroundings {
  bool has_bones = false;
};

HalfSpace read_half_space(const toml::table& table, bool below) {
  HalfSpace half_space;
  half_space.below = below;
  std::string axis = "y";
  read(table, "axis", axis);
  half_space.axis = axis == "x" ? Axis::x : axis == "y" ? Axis::y : Axis::z;
  half_space.is_fraction = table.contains("fraction");
  read(table, half_space.is_fraction ? "fraction" : "value", half_space.value);
  return half_space;
}

Shape read_shape(const toml::table& table, const Surroundings& surroundings, const std::string& path) {
  const std::string kind(table.begin()->first.str());
  if (kind == "everywhere") {
    bool everywhere = false;
    read(table, "everywhere", everywhere);
    if (!everywhere) fail(table.source(), join_path(path, kind), "is false; leave it out, or say true");
    return Everywhere{};
  }
  const toml::table& inner = *table.begin()->second.as_table();
  const std::string inner_path = join_path(path, kind);
  if (kind == "box") {
    Box box;
    read(inner, "minimum", box.minimum);
    read(inner, "maximum", box.maximum);
    if ((box.minimum.array() > box.maximum.array()).any()) {
      fail(inner.source(), inner_path, "minimum is above maximum; swap them");
    }
    return box;
  }
  if (kind == "sphere") {
    Sphere sphere{Vector3d::Zero(), 0.0};
    read(inner, "center", sphere.center);
    read(inner, "radius", sphere.radius);
    return sphere;
  }
  if (kind == "capsule") {
    Capsule capsule{Vector3d::Zero(), Vector3d::Zero(), 0.0};
    read(inner, "from", capsule.from);
    read(inner, "to", capsule.to);
    read(inner, "radius", capsule.radius);
    return capsule;
  }
  if (kind == "bone_distance") {
    BoneDistance distance;
    read(inner, "minimum", distance.minimum);
    read(inner, "maximum", distance.maximum);
    if (distance.minimum > distance.maximum)
      fail(inner.source(), inner_path, "minimum is above maximum; swap them");
    if (!surroundings.has_bones) {
      fail(inner.source(), inner_path,
           "the scene has no bones; add [bones.NAME] with from and to, or use a [character]");
    }
    return distance;
  }
  return read_half_space(inner, kind == "below");
}

Where read_where(const toml::table& owner, const Surroundings& surroundings, const std::string& path) {
  Where where;
  const toml::node* node = owner.get("where");
  if (node == nullptr) return where;
  const std::string where_path = join_path(path, "where");
  if (const toml::table* table = node->as_table()) {
    where.push_back(read_shape(*table, surroundings, where_path));
    return where;
  }
  const toml::array& array = *node->as_array();
  for (std::size_t i = 0; i < array.size(); ++i) {
    where.push_back(
        read_shape(*array[i].as_table(), surroundings, where_path + "[" + std::to_string(i) + "]"));
  }
  return where;
}

void read_layers(const toml::table& root, const Surroundings& surroundings, Scene& scene) {
  std::string rest_of_body;
  for_each_named(root, "layers",
                 [&](const std::string& name, const toml::table& table, const std::string& path) {
                   Layer layer;
                   layer.name = name;
                   read(table, "alpha", layer.alpha);
                   read(table, "beta", layer.beta);
                   read(table, "damping", layer.damping);
                   read(table, "density", layer.density);
                   read(table, "kinematic", layer.kinematic);
                   if (const toml::node* node = table.get("fibre")) {
                     const Vector3d fibre = vector_of(*node);
                     // Scaled first: a square of the smallest doubles is 0.
                     const double largest = fibre.cwiseAbs().maxCoeff();
                     if (largest == 0.0)
                       fail(node->source(), join_path(path, "fibre"),
                            "has no length; give a direction, or leave it out");
                     layer.fibre = (fibre / largest).normalized();
                   }
                   layer.where = read_where(table, surroundings, path);
                   if (layer.where.empty()) {
                     if (!rest_of_body.empty()) {
                       fail(table.source(), join_path(path, "where"),
                            "is missing, and layers." + rest_of_body +
                                " has none either; only one layer can be the rest of the body");
                     }
                     rest_of_body = name;
                   }
                   scene.layers.push_back(std::move(layer));
                 });
}

void read_forces(const toml::table& root, const Surroundings& surroundings, Scene& scene) {
  for_each_named(
      root, "force", [&](const std::string& name, const toml::table& table, const std::string& path) {
        Force force;
        force.name = name;
        std::string kind;
        read(table, "kind", kind);
        force.kind = kind == "wind" ? ForceKind::wind : ForceKind::point;
        read(table, "vector", force.vector);
        read(table, "start", force.start);
        read(table, "end", force.end);
        force.where = read_where(table, surroundings, path);
        if (force.kind == ForceKind::wind && !force.where.empty()) {
          fail(table.get("where")->source(), join_path(path, "where"),
               "wind blows on the whole surface; leave where out");
        }
        if (force.kind == ForceKind::point && force.where.empty()) {
          fail(table.source(), join_path(path, "where"), "is missing; say on which vertices the force acts");
        }
        if (!(force.end > force.start))
          fail(table.source(), join_path(path, "end"), "is not after start; the force would never act");
        scene.forces.push_back(std::move(force));
      });
}

void read_bones(const toml::table& root, Scene& scene) {
  for_each_named(root, "bones",
                 [&](const std::string& name, const toml::table& table, const std::string& path) {
                   BoneSegment bone{name, Vector3d::Zero(), Vector3d::Zero()};
                   read(table, "from", bone.from);
                   read(table, "to", bone.to);
                   if (bone.from == bone.to)
                     fail(table.source(), path, "from and to are the same point; a bone needs a length");
                   scene.bones.push_back(std::move(bone));
                 });
}

void read_bar(const toml::table& table, Scene& scene) {
  Bar bar;
  read(table, "size", bar.size);
  if (const toml::node* node = table.get("vertices")) {
    double product = 1.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bar.vertices[axis] = static_cast<std::uint32_t>((*node->as_array())[axis].as_integer()->get());
      product *= bar.vertices[axis];
    }
    constexpr double most_vertices = 1e8;
    if (product > most_vertices)
      fail(node->source(), "bar.vertices", "asks for more than 100 million vertices; make it coarser");
  }
  read(table, "jitter", bar.jitter);
  read(table, "seed", bar.seed);
  scene.geometry = bar;
}

void read_mesh(const toml::table& table, const std::filesystem::path& folder, Scene& scene) {
  std::string file;
  read(table, "file", file);
  read(table, "scale", scene.scale);
  read(table, "resolution", scene.resolution);
  try {
    load_mesh(folder / file, scene);
  } catch (const InputFileError& error) {
    fail(table.get("file")->source(), "mesh.file", error.what());
  }
}

void read_character(const toml::table& table, const std::filesystem::path& folder, Scene& scene) {
  read(table, "clip", scene.clip);
  read(table, "resolution", scene.resolution);
  if (table.contains("made")) {
    std::string name;
    read(table, "made", name);
    scene.geometry = make_character(name);
    return;
  }
  std::string file;
  read(table, "file", file);
  try {
    load_character(folder / file, scene);
  } catch (const InputFileError& error) {
    fail(table.get("file")->source(), "character.file", error.what());
  }
}

const Clip* clip_of(const toml::table& root, const Scene& scene) {
  const auto* character = std::get_if<Character>(&scene.geometry);
  if (character == nullptr) return nullptr;
  try {
    return find_clip(*character, scene.clip);
  } catch (const SceneError& error) {
    const toml::table& table = table_at(root, "character");
    const toml::node* node = table.get("clip");
    fail(node != nullptr ? node->source() : table.source(), "character.clip", error.what());
  }
}

void read_time(const toml::table& root, Scene& scene) {
  const toml::table& table = table_at(root, "scene");
  read(table, "fps", scene.fps);
  read(table, "start", scene.start);
  const Clip* clip = clip_of(root, scene);
  const toml::node* end = table.get("end");
  if (end != nullptr) {
    read(table, "end", scene.end);
  } else if (clip != nullptr) {
    scene.end = clip->duration;
  } else {
    scene.end = scene.start + Scene{}.end;
  }
  // Where the end follows from the clip, the start is what can be wrong.
  const toml::node* start = table.get("start");
  const toml::source_region& blame = end != nullptr     ? end->source()
                                     : start != nullptr ? start->source()
                                                        : root.source();
  const double frames = (scene.end - scene.start) * scene.fps;
  if (!(frames >= 0.5)) {
    fail(blame, "scene.end", "lies less than a frame after scene.start; nothing would be baked");
  }
  if (frames > most_frames)
    fail(blame, "scene.end", "asks for more than 10 million frames; end earlier or lower fps");
}

toml::table parse_toml(const SceneText& input) {
  try {
    return toml::parse(input.text, input.source);
  } catch (const toml::parse_error& error) {
    fail(error.source(), "TOML", error.description());
  }
}

}  // namespace

Scene parse_scene(const SceneText& input, const SceneOverrides& overrides) {
  toml::table root = parse_toml(input);
  apply_overrides(root, overrides);
  check_scene(root);

  Scene scene;
  scene.name = input.name;
  scene.source = input.source;
  const bool changed =
      !overrides.set.empty() || overrides.fps || overrides.start || overrides.end || overrides.clip;
  scene.text = changed ? write_scene(root) : input.text;

  const toml::table& solver = table_at(root, "solver");
  read(solver, "integrator", scene.solver.integrator);
  read(solver, "rotation", scene.solver.rotation);
  read(solver, "weights", scene.solver.weights);
  read(solver, "substeps", scene.solver.substeps);
  read(table_at(root, "scene"), "gravity", scene.gravity);

  read_bones(root, scene);
  const Surroundings surroundings{!scene.bones.empty() || root.contains("character")};
  read_layers(root, surroundings, scene);
  for_each_named(root, "pin",
                 [&](const std::string& name, const toml::table& table, const std::string& path) {
                   scene.pins.push_back({name, read_where(table, surroundings, path)});
                 });
  for_each_named(root, "probe",
                 [&](const std::string& name, const toml::table& table, const std::string& path) {
                   scene.probes.push_back({name, read_where(table, surroundings, path)});
                 });
  read_forces(root, surroundings, scene);

  // Meshes last: they can be large, and a slip in the scene file should be told at once.
  if (root.contains("bar")) {
    read_bar(table_at(root, "bar"), scene);
  } else if (root.contains("mesh")) {
    read_mesh(table_at(root, "mesh"), input.folder, scene);
  } else {
    read_character(table_at(root, "character"), input.folder, scene);
  }
  read_time(root, scene);
  return scene;
}

}  // namespace fascicle::scene
