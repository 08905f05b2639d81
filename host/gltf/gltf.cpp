#include "host/gltf/gltf.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include <Eigen/LU>

#include "host/base/nearest_name.h"
#include "host/gltf/gltf_attributes.h"
#include "host/gltf/gltf_check.h"
#include "host/gltf/gltf_decode.h"
#include "host/gltf/gltf_library.h"
#include "host/gltf/gltf_parts.h"
#include "host/gltf/gltf_shapes.h"
#include "host/gltf/gltf_skeleton.h"
#include "host/gltf/gltf_triangles.h"
#include "host/gltf/gltf_weights.h"
#include "host/gltf/weightless.h"
#include "host/rig/paint.h"
#include "host/rig/pose.h"
#include "host/rig/rig_math.h"

namespace fascicle::gltf {
namespace {

constexpr std::size_t most_painted = 16;

// Components per vertex of an attribute that can be painted; 0 for any other.
std::uint32_t painted_width(const std::string& name, int type) {
  if (!name.starts_with("_") && !name.starts_with("COLOR_")) return 0;
  switch (type) {
    case TINYGLTF_TYPE_SCALAR:
      return 1;
    case TINYGLTF_TYPE_VEC2:
      return 2;
    case TINYGLTF_TYPE_VEC3:
      return 3;
    case TINYGLTF_TYPE_VEC4:
      return 4;
    default:
      return 0;
  }
}

class Reader {
 public:
  // `looks` is the file's own document: the decoder's copy has no looks.
  Reader(const std::filesystem::path& path, const nlohmann::json& looks, const tinygltf::Model& model)
      : path_(path), looks_(looks), model_(model), shape_limits_(model) {}

  rig::Character run(Still still) {
    const GltfParts found = find_parts(path_, model_, looks_, still);
    if (found.parts.empty() && still == Still::carried)
      fail("/nodes", "the file's scene has no mesh of triangles; export the prop with its mesh");
    if (found.parts.empty()) {
      fail("/nodes",
           "the file's scene has no mesh that a skeleton or a clip moves; export the character with its "
           "armature, name a still prop under [character.NAME] with rigid = true, or a still body as .ply or "
           ".obj under [mesh]");
    }
    character_.notes = found.notes;
    joint_of_ = read_skeleton(path_, model_, found, character_);
    bind_ = rig::joint_transforms_at(character_, nullptr, 0.0);
    is_bound_.assign(bind_.size(), false);
    // In the order in which the parts first use them, because skins may share joints.
    std::map<int, Skin> skins;
    for (const GltfPart& part : found.parts)
      if (part.skin >= 0 && !skins.contains(part.skin)) skins.emplace(part.skin, read_skin(part.skin));
    bind_carriers(found);
    for (const GltfPart& source : found.parts) {
      rig::SurfacePart part = begun_part(source);
      read_primitive(
          model_.meshes[source.mesh].primitives[source.primitive],
          source.skin >= 0 ? skins.at(source.skin) : carried(source), source,
          "/meshes/" + std::to_string(source.mesh) + "/primitives/" + std::to_string(source.primitive));
      part.vertex_count = static_cast<std::uint32_t>(character_.surface.vertices.size()) - part.first_vertex;
      part.triangle_count =
          static_cast<std::uint32_t>(character_.surface.triangles.size()) - part.first_triangle;
      character_.parts.push_back(std::move(part));
    }
    if (character_.surface.triangles.empty()) fail("/meshes", "the character's meshes have no triangles");
    note(normalised_, "had weights that do not sum to 1; they were normalised");
    note(weightless_, "followed no joint; they have the weights of what they are connected to");
    note(cut_, "followed more than 8 joints; the 8 of largest weight were kept");
    note_unused_paint();
    return std::move(character_);
  }

 private:
  struct Skin {
    std::vector<std::uint32_t> joints;         // indices into the skeleton
    std::vector<Eigen::Matrix4d> raw_to_bind;  // per joint: raw position to bind pose at weight 1
  };
  struct Influence {
    std::uint32_t joint;  // index into the skin
    double weight;
  };

  [[noreturn]] void fail(const std::string& pointer, const std::string& what) const {
    gltf_error(path_, pointer, what);
  }

  void note(std::size_t vertices, const std::string& what) {
    if (vertices > 0)
      character_.notes.push_back("skin weights: " + std::to_string(vertices) + " of " +
                                 std::to_string(character_.surface.vertices.size()) + " vertices " + what);
  }

  // The inverse bind matrices give the joints' bind poses relative to each other, but not their absolute
  // position and scale. The skin's topmost joint therefore keeps its node's transform, or the one from a skin
  // read earlier. A skin without matrices is bound at its nodes' transforms.
  Skin read_skin(int number) {
    const tinygltf::Skin& source = model_.skins[static_cast<std::size_t>(number)];
    Skin skin;
    for (const int node : source.joints)
      skin.joints.push_back(static_cast<std::uint32_t>(joint_of_[static_cast<std::size_t>(node)]));
    if (source.inverseBindMatrices < 0) {
      for (const std::uint32_t joint : skin.joints) {
        is_bound_[joint] = true;
        skin.raw_to_bind.push_back(bind_[joint]);
      }
      return skin;
    }
    const std::vector<Eigen::Matrix4d> inverse_binds =
        read_inverse_binds(source.inverseBindMatrices, skin.joints.size());
    const auto is_before = [&](std::size_t a, std::size_t b) {
      const std::uint32_t ja = skin.joints[a], jb = skin.joints[b];
      return is_bound_[ja] != is_bound_[jb] ? is_bound_[ja] : ja < jb;
    };
    std::size_t top = 0;
    for (std::size_t k = 1; k < skin.joints.size(); ++k)
      if (is_before(k, top)) top = k;
    const Eigen::Matrix4d raw_to_bind = bind_[skin.joints[top]] * inverse_binds[top];
    for (std::size_t k = 0; k < skin.joints.size(); ++k) {
      const std::uint32_t joint = skin.joints[k];
      if (!is_bound_[joint]) bind_[joint] = raw_to_bind * rig::affine_inverse(inverse_binds[k]);
      is_bound_[joint] = true;
      character_.skeleton[joint].inverse_bind = rig::affine_inverse(bind_[joint]);
      // The same for all joints, unless two skins bind the same joints in different poses.
      skin.raw_to_bind.push_back(bind_[joint] * inverse_binds[k]);
    }
    return skin;
  }

  std::vector<Eigen::Matrix4d> read_inverse_binds(int accessor, std::size_t count) const {
    const std::vector<double> matrices = accessor_numbers(path_, model_, accessor);
    const auto refuse = [&](std::size_t k, const std::string& what) {
      fail("/accessors/" + std::to_string(accessor), "matrix " + std::to_string(k) + ": " + what);
    };
    std::vector<Eigen::Matrix4d> inverse_binds;
    for (std::size_t k = 0; k < count; ++k) {
      Eigen::Matrix4d m = Eigen::Map<const Eigen::Matrix4d>(matrices.data() + 16 * k);
      // Exporters invert in single precision, so the last row may be off by some rounding.
      if ((m.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > 1e-5)
        refuse(k, "its last row must be 0 0 0 1");
      m.row(3) = Eigen::RowVector4d(0, 0, 0, 1);
      if (!rig::affine_inverse(m).allFinite()) refuse(k, "it has no inverse");
      inverse_binds.push_back(m);
    }
    return inverse_binds;
  }

  // A joint that carries unskinned meshes takes its parent's bind pose times its own rest transform, unless a
  // skin has set its pose.
  void bind_carriers(const GltfParts& found) {
    std::vector<bool> is_carrier(bind_.size(), false);
    for (const int n : found.carriers)
      is_carrier[static_cast<std::size_t>(joint_of_[static_cast<std::size_t>(n)])] = true;
    std::vector<bool> is_rebound = is_bound_;
    for (std::size_t j = 0; j < bind_.size(); ++j) {
      rig::Joint& joint = character_.skeleton[j];
      const auto parent = static_cast<std::size_t>(std::max(joint.parent, 0));
      if (is_bound_[j] || joint.parent < 0 || !is_rebound[parent]) continue;
      bind_[j] = bind_[parent] * joint.rest_local;
      is_rebound[j] = true;
      if (is_carrier[j]) joint.inverse_bind = rig::affine_inverse(bind_[j]);
    }
  }

  // An unskinned part follows one joint with weight 1.
  Skin carried(const GltfPart& part) const {
    const auto joint = static_cast<std::uint32_t>(joint_of_[static_cast<std::size_t>(part.carrier)]);
    return {{joint}, {bind_[joint] * part.to_carrier}};
  }

  // Starts a part: its names, and where its vertices and triangles begin.
  rig::SurfacePart begun_part(const GltfPart& source) const {
    rig::SurfacePart part;
    part.object = name_of("nodes", source.node);
    if (part.object.empty()) part.object = name_of("meshes", source.mesh);
    if (part.object.empty()) part.object = "mesh " + std::to_string(source.mesh);
    part.node = static_cast<std::uint32_t>(source.node);
    part.first_vertex = static_cast<std::uint32_t>(character_.surface.vertices.size());
    part.first_triangle = static_cast<std::uint32_t>(character_.surface.triangles.size());
    const auto& shown = looks_["meshes"][source.mesh]["primitives"][source.primitive];
    const auto number = shown.find("material");
    if (number != shown.end() && number->is_number_unsigned())
      part.material = name_of("materials", number->get<std::size_t>());
    return part;
  }

  // The name of an entry in one of the document's lists; empty if there is none.
  std::string name_of(const char* list, std::size_t number) const {
    const auto entries = looks_.find(list);
    if (entries == looks_.end() || !entries->is_array() || number >= entries->size()) return {};
    const nlohmann::json& entry = (*entries)[number];
    if (!entry.is_object()) return {};
    const auto name = entry.find("name");
    return name != entry.end() && name->is_string() ? name->get<std::string>() : std::string();
  }

  std::vector<double> numbers(const std::string& pointer, int accessor, int type, bool is_allowed,
                              std::size_t count) const {
    return attribute_numbers(path_, model_, pointer, accessor, type, is_allowed, count);
  }

  // For each vertex, all joints with nonzero weight, duplicates merged.
  std::vector<std::vector<Influence>> read_influences(const tinygltf::Primitive& primitive, const Skin& skin,
                                                      const std::string& pointer, std::size_t count) {
    std::vector<std::vector<Influence>> influences(count);
    for (int set = 0;; ++set) {
      const std::optional<InfluenceSet> read =
          read_influence_set(path_, model_, primitive, pointer, set, count, skin.joints.size());
      if (!read) break;
      for (std::size_t i = 0; i < 4 * count; ++i) {
        if (read->weights[i] == 0.0) continue;
        const auto joint = static_cast<std::uint32_t>(read->joints[i]);
        std::vector<Influence>& all = influences[i / 4];
        const auto known =
            std::find_if(all.begin(), all.end(), [&](const Influence& x) { return x.joint == joint; });
        if (known != all.end()) {
          known->weight += read->weights[i];
        } else {
          all.push_back({joint, read->weights[i]});
        }
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      std::vector<Influence>& all = influences[i];
      if (all.empty()) continue;  // see give_weights
      std::sort(all.begin(), all.end(), [](const Influence& a, const Influence& b) {
        return a.weight != b.weight ? a.weight > b.weight : a.joint < b.joint;
      });
      double sum = 0.0;
      for (const Influence& x : all) sum += x.weight;
      if (std::abs(sum - 1.0) > weight_sum_tolerance) ++normalised_;
      if (all.size() > 8) {
        ++cut_;
        all.resize(8);
        sum = 0.0;
        for (const Influence& x : all) sum += x.weight;
      }
      for (Influence& x : all) x.weight /= sum;
    }
    return influences;
  }

  // Exporters leave some vertices of a skinned mesh without weights. Those take the weights of the vertices
  // they are connected to.
  void give_weights(std::vector<std::vector<Influence>>& influences,
                    std::span<const std::array<std::uint32_t, 3>> triangles, const std::string& pointer) {
    std::vector<bool> has_weights;
    for (const std::vector<Influence>& all : influences) has_weights.push_back(!all.empty());
    const std::vector<std::uint32_t> source = weighted_neighbours(has_weights, triangles);
    if (const auto lost = std::count(source.begin(), source.end(), no_vertex); lost > 0)
      fail(pointer + "/attributes/WEIGHTS_0",
           "vertex " + std::to_string(std::find(source.begin(), source.end(), no_vertex) - source.begin()) +
               (lost > 1 ? " and " + std::to_string(lost - 1) + " more follow" : " follows") +
               " no joint, nor does anything connected with " + (lost > 1 ? "them" : "it") + "; give " +
               (lost > 1 ? "them weights" : "it a weight"));
    for (std::size_t i = 0; i < influences.size(); ++i) {
      if (has_weights[i]) continue;
      influences[i] = influences[source[i]];
      ++weightless_;
    }
  }

  // Painted attributes that look like one that acts by itself, and do not act. A scene file may name any.
  void note_unused_paint() {
    if (!unread_paint_.empty())
      character_.notes.push_back("the attribute `" + *unread_paint_.begin() + "`" +
                                 (unread_paint_.size() == 1
                                      ? " is"
                                      : " and " + std::to_string(unread_paint_.size() - 1) + " more are") +
                                 " not read: a character has at most " + std::to_string(most_painted) +
                                 " besides those that act by themselves");
    std::vector<std::string> names;
    for (const rig::PaintKind& kind : rig::paint_kinds()) names.emplace_back(kind.name);
    for (const rig::PaintedAttribute& attribute : character_.painted) {
      const rig::PaintKind* kind = rig::find_paint_kind(attribute.name);
      if (kind != nullptr && kind->width != attribute.width)
        character_.notes.push_back("the attribute `" + attribute.name + "` has " +
                                   std::to_string(attribute.width) + " numbers a vertex instead of " +
                                   std::to_string(kind->width) + ", and is not used");
      std::string upper = attribute.name;
      for (char& c : upper) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
      const std::string hint =
          kind == nullptr && upper.starts_with("_") ? base::nearest_name_hint(upper, names) : std::string();
      if (!hint.empty())
        character_.notes.push_back("the attribute `" + attribute.name +
                                   "` is not used unless a scene file names it" + hint);
    }
  }

  // Finds or adds the attribute of this name; null, and a note at the end, for one too many. The kinds that
  // act by themselves are never too many, and have the same width everywhere.
  rig::PaintedAttribute* painted_attribute(const std::string& name, std::uint32_t width,
                                           const std::string& pointer) {
    const bool acts = rig::find_paint_kind(name) != nullptr;
    std::size_t others = 0;
    for (rig::PaintedAttribute& attribute : character_.painted) {
      if (rig::find_paint_kind(attribute.name) == nullptr) ++others;
      if (attribute.name != name) continue;
      if (acts && attribute.width != width)
        fail(pointer, "has " + std::to_string(width) + " numbers a vertex, and " +
                          std::to_string(attribute.width) + " on another primitive");
      return &attribute;
    }
    if (others >= most_painted && !acts) {
      unread_paint_.insert(name);
      return nullptr;
    }
    character_.painted.push_back({name, width, {}});
    return &character_.painted.back();
  }

  // Call after adding the primitive's vertices to the surface.
  void read_painted(const tinygltf::Primitive& primitive, const std::string& pointer, const Skin& skin,
                    const std::vector<std::vector<Influence>>& influences) {
    const std::size_t all = character_.surface.vertices.size(), count = influences.size();
    for (const auto& [name, accessor] : primitive.attributes) {
      const int type = model_.accessors[static_cast<std::size_t>(accessor)].type;
      const std::uint32_t width = painted_width(name, type);
      if (width == 0) continue;
      const std::string here = pointer + "/attributes/" + name;
      rig::PaintedAttribute* attribute = painted_attribute(name, width, here);
      if (attribute == nullptr) continue;
      rig::PaintedAttribute own{name, width, numbers(here, accessor, type, true, count)};
      for (std::size_t i = 0; name == "_FIBER" && width == 3 && i < count; ++i) {
        Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
        for (const Influence& x : influences[i])
          turn += x.weight * skin.raw_to_bind[x.joint].topLeftCorner<3, 3>();
        double* value = own.values.data() + 3 * i;
        const Vector3d raw(value[0], value[1], value[2]);
        // The direction rotates with the skin. Its length, the painter's confidence, is kept.
        const Vector3d turned = turn * raw;
        const double length = turned.norm();
        for (int axis = 0; axis < 3; ++axis)
          value[axis] = length > 0.0 ? turned[axis] * (raw.norm() / length) : 0.0;
      }
      widen(*attribute, width);
      // Vertices of earlier primitives without it.
      attribute->values.resize(attribute->width * (all - count), rig::value_elsewhere(name));
      widen(own, attribute->width);
      attribute->values.insert(attribute->values.end(), own.values.begin(), own.values.end());
    }
    for (rig::PaintedAttribute& attribute : character_.painted)
      attribute.values.resize(attribute.width * all, rig::value_elsewhere(attribute.name));
  }

  void read_primitive(const tinygltf::Primitive& primitive, const Skin& skin, const GltfPart& source,
                      const std::string& pointer) {
    if (primitive.mode != TINYGLTF_MODE_TRIANGLES && primitive.mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
        primitive.mode != TINYGLTF_MODE_TRIANGLE_FAN) {
      fail(pointer + "/mode",
           std::to_string(primitive.mode) + "; a skinned mesh must be of triangles, a strip or a fan");
    }
    const std::string position_pointer = pointer + "/attributes/POSITION";
    const int position = attribute_accessor(primitive, "POSITION");
    if (position < 0) fail(position_pointer, "is missing");
    const tinygltf::Accessor& a = model_.accessors[static_cast<std::size_t>(position)];
    mesh::SurfaceMesh& surface = character_.surface;
    const std::vector<double> raw = read_positions(path_, model_, primitive, pointer);
    const auto triangles = read_triangles(path_, model_, primitive, pointer, a.count);
    std::vector<std::vector<Influence>> influences =
        source.skin >= 0 ? read_influences(primitive, skin, pointer, a.count)
                         : std::vector<std::vector<Influence>>(a.count, {{.joint = 0, .weight = 1.0}});
    give_weights(influences, triangles, pointer);

    std::vector<Vector3d> points;
    for (std::size_t i = 0; i < a.count; ++i) points.emplace_back(raw[3 * i], raw[3 * i + 1], raw[3 * i + 2]);
    const std::vector<rig::BlendShape> shapes =
        read_shapes(path_, model_, primitive, pointer, a.count, shape_limits_);
    add_shapes(shapes, rest_weights(looks_, source.node, source.mesh, shapes.size()), points);

    const auto first = static_cast<std::uint32_t>(surface.vertices.size());
    std::vector<bool> is_mirrored(a.count);
    for (std::size_t i = 0; i < a.count; ++i) {
      Eigen::Matrix4d blend = Eigen::Matrix4d::Zero();
      std::array<std::uint32_t, 8> joints{};
      std::array<double, 8> weights{};
      for (std::size_t k = 0; k < influences[i].size(); ++k) {
        const Influence& x = influences[i][k];
        blend += x.weight * skin.raw_to_bind[x.joint];
        joints[k] = skin.joints[x.joint];
        weights[k] = x.weight;
      }
      const Vector3d& p = points[i];
      const Vector3d bound = blend.topLeftCorner<3, 3>() * p + blend.topRightCorner<3, 1>();
      if (!bound.allFinite())
        fail(position_pointer,
             "vertex " + std::to_string(i) + " is skinned to a position that is not finite");
      is_mirrored[i] = blend.topLeftCorner<3, 3>().determinant() < 0.0;
      surface.vertices.push_back(bound);
      character_.joints.push_back(joints);
      character_.weights.push_back(weights);
    }

    read_painted(primitive, pointer, skin, influences);

    for (std::array<std::uint32_t, 3> t : triangles) {
      // A mirroring transform turns triangles inside out.
      if (is_mirrored[t[0]]) std::swap(t[1], t[2]);
      surface.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
  }

  const std::filesystem::path& path_;
  const nlohmann::json& looks_;
  const tinygltf::Model& model_;
  rig::Character character_;
  std::vector<std::int32_t> joint_of_;  // per node
  std::vector<Eigen::Matrix4d> bind_;   // per joint: joint space to bind pose, metres
  ShapeLimits shape_limits_;
  std::set<std::string> unread_paint_;  // names
  std::size_t normalised_ = 0, cut_ = 0,
              weightless_ = 0;  // vertices whose weights were changed
  std::vector<bool> is_bound_;  // per joint: whether a skin has set its bind pose
};

}  // namespace

rig::Character read_gltf(const std::filesystem::path& path, std::vector<std::filesystem::path>* files_read,
                         const std::filesystem::path& converter, Still still) {
  GltfFile file = read_gltf_file(path, converter);
  const std::vector<std::string> notes = file.notes;
  const CheckedGltf checked = check_gltf(std::move(file));
  const auto model = decode_gltf(checked);
  rig::Character character = Reader(path, checked.plain, *model).run(still);
  character.notes.insert(character.notes.end(), notes.begin(), notes.end());
  if (files_read != nullptr) {
    files_read->insert(files_read->end(), checked.files_read.begin(), checked.files_read.end());
  }
  return character;
}

}  // namespace fascicle::gltf
