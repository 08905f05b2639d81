#include "host/convert/meshes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <unordered_map>

namespace fascicle::convert {
namespace {

using nlohmann::json;

constexpr std::size_t most_influences = 32;  // per vertex

struct Influence {
  std::uint16_t slot;
  float weight;
};

// A skin of glTF names a node once. For further bind matrices of a joint, a child of it that stays where it
// is. Skins share them.
std::size_t stand_in(const Character& character, std::size_t joint, std::size_t number, Document& document) {
  json& nodes = document.json["nodes"];
  const auto [known, is_new] = document.stand_ins.try_emplace({joint, number}, nodes.size());
  if (is_new) {
    nodes.push_back({{"name", character.nodes[joint].name + " bind " + std::to_string(number)}});
    nodes[joint]["children"].push_back(known->second);
  }
  return known->second;
}

// The joints of one node's skin, and their inverse bind matrices.
class Skin {
 public:
  Skin(const Character& character, std::size_t node) : character_(character), node_(node) {}

  // A slot per bone and bind matrix: a bone with different offsets in two meshes gets two slots. Joints of
  // one name cannot be told apart here, and are one, with the bind matrix of the first bone. With its own,
  // the other's skin would move to the first joint.
  std::optional<std::uint16_t> slot_of(const aiBone& bone) {
    const std::size_t joint = find_node(character_, bone.mName.C_Str());
    if (joint == character_.nodes.size()) return std::nullopt;
    const std::vector<std::size_t>& named = character_.by_name.at(bone.mName.C_Str());
    if (std::count_if(named.begin(), named.end(),
                      [&](std::size_t n) { return character_.nodes[n].meshes.empty(); }) > 1) {
      const auto same = std::find(joints_.begin(), joints_.end(), joint);
      if (same != joints_.end()) return static_cast<std::uint16_t>(same - joints_.begin());
    }
    return slot(joint, bind_offset(character_.nodes[node_], bone) * character_.nodes[node_].geometry);
  }
  std::optional<std::uint16_t> own_slot() { return slot(node_, character_.nodes[node_].geometry); }

  std::size_t add_to(Document& document) const {
    std::vector<std::size_t> joints;
    std::map<std::size_t, std::size_t> count;
    for (const std::size_t joint : joints_) {
      const std::size_t number = ++count[joint];
      joints.push_back(number == 1 ? joint : stand_in(character_, joint, number, document));
    }
    std::vector<float> matrices;
    for (const Matrix& matrix : inverse_bind_)
      for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) matrices.push_back(static_cast<float>(matrix(r, c)));
    document.json["skins"].push_back(
        {{"joints", joints},
         {"inverseBindMatrices", add_accessor(document, std::span<const float>(matrices), 16)}});
    return document.json["skins"].size() - 1;
  }
  bool is_empty() const { return joints_.empty(); }

 private:
  std::optional<std::uint16_t> slot(std::size_t joint, const Matrix& inverse_bind) {
    for (std::size_t i = 0; i < joints_.size(); ++i)
      if (joints_[i] == joint && inverse_bind_[i] == inverse_bind) return static_cast<std::uint16_t>(i);
    if (joints_.size() > 65535) return std::nullopt;
    joints_.push_back(joint);
    inverse_bind_.push_back(inverse_bind);
    return static_cast<std::uint16_t>(joints_.size() - 1);
  }

  const Character& character_;
  std::size_t node_;
  std::vector<std::size_t> joints_;
  std::vector<Matrix> inverse_bind_;
};

// glTF wants each joint of a vertex once.
void add_influence(const Influence& added, std::vector<Influence>& of_vertex) {
  for (Influence& influence : of_vertex)
    if (influence.slot == added.slot) {
      influence.weight += added.weight;
      return;
    }
  of_vertex.push_back(added);
}

std::vector<std::vector<Influence>> influences_of(const aiMesh& mesh, Skin& skin, std::string& lost) {
  std::vector<std::vector<Influence>> result(mesh.mNumVertices);
  for (unsigned b = 0; b < mesh.mNumBones; ++b) {
    const aiBone& bone = *mesh.mBones[b];
    const auto slot = skin.slot_of(bone);
    if (!slot) lost = bone.mName.C_Str();
    for (unsigned w = 0; slot && w < bone.mNumWeights; ++w)
      if (bone.mWeights[w].mVertexId < mesh.mNumVertices && bone.mWeights[w].mWeight > 0.0f)
        add_influence({*slot, bone.mWeights[w].mWeight}, result[bone.mWeights[w].mVertexId]);
  }
  for (std::vector<Influence>& of_vertex : result) {
    std::stable_sort(of_vertex.begin(), of_vertex.end(),
                     [](const Influence& a, const Influence& b) { return a.weight > b.weight; });
    if (of_vertex.size() > most_influences) of_vertex.resize(most_influences);
    double sum = 0.0;
    for (const Influence& influence : of_vertex) sum += double{influence.weight};
    for (Influence& influence : of_vertex)
      influence.weight = static_cast<float>(double{influence.weight} / sum);
    if (of_vertex.empty())
      if (const auto slot = skin.own_slot()) of_vertex.push_back({*slot, 1.0f});
  }
  return result;
}

template <typename T>
void append_bytes(std::string& key, const T& value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  key.append(bytes, sizeof(T));
}

// Merges corners that are identical in every attribute into one vertex: assimp has a vertex per corner.
struct Corners {
  std::vector<unsigned> first;         // per vertex: its first corner
  std::vector<std::uint32_t> indices;  // of triangles
};

Corners join_corners(const aiMesh& mesh, const std::vector<std::vector<Influence>>& influences) {
  Corners corners;
  std::unordered_map<std::string, std::uint32_t> vertex_of;
  std::string key;
  const auto vertex = [&](unsigned corner) {
    key.clear();
    append_bytes(key, mesh.mVertices[corner]);
    if (mesh.HasNormals()) append_bytes(key, mesh.mNormals[corner]);
    for (unsigned set = 0; mesh.HasTextureCoords(set); ++set)
      append_bytes(key, mesh.mTextureCoords[set][corner]);
    for (unsigned set = 0; mesh.HasVertexColors(set); ++set) append_bytes(key, mesh.mColors[set][corner]);
    for (unsigned s = 0; s < mesh.mNumAnimMeshes; ++s)
      if (mesh.mAnimMeshes[s]->HasPositions() && corner < mesh.mAnimMeshes[s]->mNumVertices)
        append_bytes(key, mesh.mAnimMeshes[s]->mVertices[corner]);
    if (!influences.empty())
      for (const Influence& influence : influences[corner]) {
        append_bytes(key, influence.slot);
        append_bytes(key, influence.weight);
      }
    const auto [at, is_new] = vertex_of.emplace(key, static_cast<std::uint32_t>(corners.first.size()));
    if (is_new) corners.first.push_back(corner);
    return at->second;
  };
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    // Polygons are already triangulated; anything else is a point or a line.
    if (face.mNumIndices != 3 ||
        !std::all_of(face.mIndices, face.mIndices + 3, [&](unsigned i) { return i < mesh.mNumVertices; })) {
      continue;
    }
    for (int c = 0; c < 3; ++c) corners.indices.push_back(vertex(face.mIndices[c]));
  }
  return corners;
}

std::vector<float> positions_of(const aiVector3D* of_corner, const Corners& corners) {
  std::vector<float> result;
  for (const unsigned corner : corners.first)
    result.insert(result.end(), {of_corner[corner].x, of_corner[corner].y, of_corner[corner].z});
  return result;
}

void add_weights(const std::vector<std::vector<Influence>>& influences, const Corners& corners,
                 json& attributes, Document& document) {
  std::size_t most = 1;
  for (const unsigned corner : corners.first) most = std::max(most, influences[corner].size());
  for (std::size_t set = 0; 4 * set < most; ++set) {
    std::vector<std::uint16_t> joints;
    std::vector<float> weights;
    for (const unsigned corner : corners.first)
      for (std::size_t k = 4 * set; k < 4 * set + 4; ++k) {
        const bool is_there = k < influences[corner].size();
        joints.push_back(is_there ? influences[corner][k].slot : std::uint16_t{0});
        weights.push_back(is_there ? influences[corner][k].weight : 0.0f);
      }
    const std::string number = std::to_string(set);
    attributes["JOINTS_" + number] = add_accessor(document, std::span<const std::uint16_t>(joints), 4);
    attributes["WEIGHTS_" + number] = add_accessor(document, std::span<const float>(weights), 4);
  }
}

void add_looks(const aiMesh& mesh, const Corners& corners, json& attributes, Document& document) {
  if (mesh.HasNormals()) {
    std::vector<float> normals;
    for (const unsigned corner : corners.first) {
      aiVector3D n = mesh.mNormals[corner];
      n.NormalizeSafe();
      if (!(n.SquareLength() > 0.5f)) n = {0.0f, 1.0f, 0.0f};
      normals.insert(normals.end(), {n.x, n.y, n.z});
    }
    attributes["NORMAL"] = add_accessor(document, std::span<const float>(normals), 3);
  }
  for (unsigned set = 0; mesh.HasTextureCoords(set); ++set) {
    std::vector<float> uvs;
    for (const unsigned corner : corners.first) {
      const aiVector3D& uv = mesh.mTextureCoords[set][corner];
      uvs.insert(uvs.end(), {uv.x, 1.0f - uv.y});
    }
    attributes["TEXCOORD_" + std::to_string(set)] = add_accessor(document, std::span<const float>(uvs), 2);
  }
  for (unsigned set = 0; mesh.HasVertexColors(set); ++set) {
    std::vector<float> colours;
    for (const unsigned corner : corners.first) {
      const aiColor4D& c = mesh.mColors[set][corner];
      colours.insert(colours.end(), {c.r, c.g, c.b, c.a});
    }
    attributes["COLOR_" + std::to_string(set)] = add_accessor(document, std::span<const float>(colours), 4);
  }
}

// `count` is the largest number of shapes among the node's meshes: glTF requires the same number in all.
json targets_of(const aiMesh& mesh, unsigned count, const Corners& corners, Document& document) {
  json targets = json::array();
  for (unsigned s = 0; s < count; ++s) {
    std::vector<float> offsets(3 * corners.first.size(), 0.0f);
    if (s < mesh.mNumAnimMeshes && mesh.mAnimMeshes[s]->HasPositions() &&
        mesh.mAnimMeshes[s]->mNumVertices == mesh.mNumVertices) {
      const std::vector<float> moved = positions_of(mesh.mAnimMeshes[s]->mVertices, corners);
      const std::vector<float> still = positions_of(mesh.mVertices, corners);
      for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] = moved[i] - still[i];
    }
    targets.push_back({{"POSITION", add_accessor(document, std::span<const float>(offsets), 3, true)}});
  }
  return targets;
}

}  // namespace

std::optional<PlacedMesh> add_mesh(Character& character, std::size_t node, Document& document) {
  const Node& shown = character.nodes[node];
  const bool is_skinned = std::any_of(shown.meshes.begin(), shown.meshes.end(),
                                      [](const aiMesh* mesh) { return mesh->mNumBones > 0; });
  unsigned shapes = 0;
  const aiMesh* richest = nullptr;
  for (const aiMesh* mesh : shown.meshes)
    if (mesh->mNumAnimMeshes > shapes) {
      shapes = mesh->mNumAnimMeshes;
      richest = mesh;
    }
  Skin skin(character, node);
  json primitives = json::array();
  std::string lost;
  for (const aiMesh* mesh : shown.meshes) {
    if (!mesh->HasPositions()) continue;
    std::vector<std::vector<Influence>> influences;
    if (is_skinned) influences = influences_of(*mesh, skin, lost);
    const Corners corners = join_corners(*mesh, influences);
    if (corners.indices.empty()) continue;
    const std::vector<float> positions = positions_of(mesh->mVertices, corners);
    json attributes = {{"POSITION", add_accessor(document, std::span<const float>(positions), 3, true)}};
    add_looks(*mesh, corners, attributes, document);
    if (is_skinned) add_weights(influences, corners, attributes, document);
    json primitive = {{"attributes", attributes},
                      {"indices", add_indices(document, std::span<const std::uint32_t>(corners.indices))}};
    if (mesh->mMaterialIndex < character.scene->mNumMaterials) primitive["material"] = mesh->mMaterialIndex;
    if (shapes > 0) primitive["targets"] = targets_of(*mesh, shapes, corners, document);
    primitives.push_back(std::move(primitive));
  }
  if (!lost.empty())
    character.notes.push_back("the skin of `" + shown.name + "` names a bone `" + lost +
                              "`, which is not a node; its weights are left out");
  if (primitives.empty()) return std::nullopt;
  json mesh = {{"name", shown.name}, {"primitives", primitives}};
  if (shapes > 0) {
    json names = json::array();
    for (unsigned s = 0; s < shapes; ++s) names.push_back(richest->mAnimMeshes[s]->mName.C_Str());
    mesh["weights"] = std::vector<double>(shapes, 0.0);
    mesh["extras"] = {{"targetNames", names}};
  }
  document.json["meshes"].push_back(std::move(mesh));
  PlacedMesh placed{.mesh = document.json["meshes"].size() - 1, .skin = {}};
  if (is_skinned && !skin.is_empty()) placed.skin = skin.add_to(document);
  return placed;
}

}  // namespace fascicle::convert
