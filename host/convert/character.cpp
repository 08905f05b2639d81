#include "host/convert/character.h"

#include <array>
#include <cmath>
#include <cstdint>

#include <Eigen/LU>
#include <assimp/commonMetaData.h>
#include <assimp/metadata.h>

namespace fascicle::convert {
namespace {

constexpr const char* link_mark = "_$AssimpFbx$_";

bool is_geometric(const std::string& component) {
  return component.rfind("Geometric", 0) == 0;
}

// Nodes between a node and its children that cancel the placement of its mesh.
bool is_taken_back(const std::string& component) {
  constexpr const char* ending = "Inverse";
  return is_geometric(component) && component.size() > 7 &&
         component.compare(component.size() - 7, 7, ending) == 0;
}

class Walker {
 public:
  // `has_links`: names with the mark denote links. In formats other than FBX they are ordinary names.
  Walker(const aiScene& scene, bool has_links, std::vector<Node>& nodes)
      : scene_(scene), has_links_(has_links), nodes_(nodes) {}

  // Uses an explicit stack, because files may nest arbitrarily deep.
  void run() {
    stack_.push_back({scene_.mRootNode, -1, {}});
    while (!stack_.empty()) {
      Step step = std::move(stack_.back());
      stack_.pop_back();
      visit(step);
    }
  }

 private:
  struct Step {
    const aiNode* node;
    int parent;
    std::vector<Link> chain;
  };

  void visit(Step& step) {
    const std::string name = step.node->mName.C_Str();
    const std::size_t mark = has_links_ ? name.find(link_mark) : std::string::npos;
    int parent = step.parent;
    if (mark == std::string::npos) {
      parent = add(step, name);
      step.chain.clear();
    } else if (std::string component = name.substr(mark + std::string(link_mark).size());
               !is_taken_back(component)) {
      step.chain.push_back({name, std::move(component), matrix_of(step.node->mTransformation)});
    }
    for (unsigned i = step.node->mNumChildren; i-- > 0;)
      stack_.push_back({step.node->mChildren[i], parent, step.chain});
  }

  int add(Step& step, const std::string& name) {
    Node node;
    node.name = name;
    node.parent = step.parent;
    for (Link& link : step.chain) {
      Matrix& matrix = is_geometric(link.component) ? node.geometry : node.local;
      matrix = (matrix * link.matrix).eval();
      if (!is_geometric(link.component)) node.chain.push_back(std::move(link));
    }
    node.local = (node.local * matrix_of(step.node->mTransformation)).eval();
    for (unsigned i = 0; i < step.node->mNumMeshes; ++i)
      if (step.node->mMeshes[i] < scene_.mNumMeshes)
        node.meshes.push_back(scene_.mMeshes[step.node->mMeshes[i]]);
    nodes_.push_back(std::move(node));
    return static_cast<int>(nodes_.size()) - 1;
  }

  const aiScene& scene_;
  bool has_links_;
  std::vector<Node>& nodes_;
  std::vector<Step> stack_;
};

// Maps an FBX file's axes and unit to metres, right-handed, Y up. The front axis follows from the other two.
Matrix world_of(const aiScene& scene, std::vector<std::string>& notes) {
  std::int32_t up = 1, right = 0, up_sign = 1, right_sign = 1;
  float unit = 1.0f;  // cm
  if (scene.mMetaData != nullptr) {
    scene.mMetaData->Get("UpAxis", up);
    scene.mMetaData->Get("UpAxisSign", up_sign);
    scene.mMetaData->Get("CoordAxis", right);
    scene.mMetaData->Get("CoordAxisSign", right_sign);
    scene.mMetaData->Get("UnitScaleFactor", unit);
  }
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  if (up >= 0 && up < 3 && right >= 0 && right < 3 && up != right) {
    axes.row(0) = Eigen::Vector3d::Unit(right) * (right_sign < 0 ? -1.0 : 1.0);
    axes.row(1) = Eigen::Vector3d::Unit(up) * (up_sign < 0 ? -1.0 : 1.0);
    axes.row(2) = Eigen::Vector3d(axes.row(0)).cross(Eigen::Vector3d(axes.row(1)));
  } else {
    notes.push_back("its axes are invalid; Y up is assumed");
  }
  if (!std::isfinite(unit) || unit <= 0.0f) {
    notes.push_back("its unit is invalid; centimetres are assumed");
    unit = 1.0f;
  }
  Matrix world = Matrix::Identity();
  world.topLeftCorner<3, 3>() = axes * (0.01 * double{unit});
  return world;
}

// In Blender's Collada files, bones are bound in world space, but a mesh in its parent's space.
void mend_blender(const aiScene& scene, std::vector<Node>& nodes) {
  aiString tool;
  if (scene.mMetaData == nullptr || !scene.mMetaData->Get(AI_METADATA_SOURCE_GENERATOR, tool) ||
      std::string(tool.C_Str()).rfind("Blender", 0) != 0) {
    return;
  }
  // Node 0 converts the file's axes and unit, which the file's own numbers ignore.
  std::vector<Matrix> above{Matrix::Identity()};
  for (std::size_t n = 1; n < nodes.size(); ++n) {
    above.push_back(Matrix::Identity());
    if (nodes[n].parent < 0) continue;
    const auto parent = static_cast<std::size_t>(nodes[n].parent);
    above[n] = above[parent];
    if (parent != 0) above[n] *= nodes[parent].local;
    const Matrix mended = nodes[n].local.inverse() * above[n] * nodes[n].local;
    if (mended.allFinite()) nodes[n].mended = mended;
  }
}

void index_names(Character& character) {
  for (std::size_t n = 0; n < character.nodes.size(); ++n)
    if (!character.nodes[n].name.empty()) character.by_name[character.nodes[n].name].push_back(n);
  for (unsigned m = 0; m < character.scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *character.scene->mMeshes[m];
    for (unsigned b = 0; b < mesh.mNumBones; ++b) {
      const auto found = character.by_name.find(mesh.mBones[b]->mName.C_Str());
      if (found == character.by_name.end() || found->second.size() < 2) continue;
      character.notes.push_back("several nodes are named `" + found->first +
                                "`; skins and clips refer to nodes by name and use the first without a mesh");
      return;
    }
  }
}

}  // namespace

Matrix matrix_of(const aiMatrix4x4& m) {
  Matrix result;
  for (unsigned r = 0; r < 4; ++r)
    for (unsigned c = 0; c < 4; ++c) result(r, c) = double{m[r][c]};
  return result;
}

Matrix matrix_of(const Parts& parts) {
  Matrix result = Matrix::Identity();
  result.topLeftCorner<3, 3>() = parts.rotation.toRotationMatrix() * parts.scale.asDiagonal();
  result.topRightCorner<3, 1>() = parts.translation;
  return result;
}

Parts parts_of(const Matrix& matrix) {
  Parts parts;
  parts.translation = matrix.topRightCorner<3, 1>();
  Eigen::Matrix3d m = matrix.topLeftCorner<3, 3>();
  for (int c = 0; c < 3; ++c) parts.scale[c] = m.col(c).norm();
  if (m.determinant() < 0.0) parts.scale = -parts.scale;
  for (int c = 0; c < 3; ++c) {
    if (parts.scale[c] == 0.0) return parts;
    m.col(c) /= parts.scale[c];
  }
  parts.rotation = Eigen::Quaterniond(m).normalized();
  return parts;
}

Matrix bind_offset(const Node& node, const aiBone& bone) {
  return matrix_of(bone.mOffsetMatrix) * node.mended;
}

std::size_t find_node(const Character& character, const std::string& name) {
  const auto found = character.by_name.find(name);
  if (found == character.by_name.end()) return character.nodes.size();
  for (const std::size_t n : found->second)
    if (character.nodes[n].meshes.empty()) return n;
  return found->second.front();
}

std::vector<Matrix> global_transforms(const std::vector<Node>& nodes) {
  std::vector<Matrix> result;
  for (const Node& node : nodes)
    result.push_back(node.parent < 0 ? node.local
                                     : result[static_cast<std::size_t>(node.parent)] * node.local);
  return result;
}

Character character_of(const aiScene& scene, const Source& source) {
  Character character;
  character.scene = &scene;
  Walker(scene, source.is_fbx, character.nodes).run();
  if (source.is_fbx) {
    // The root node is assimp's own, and the file may have a node of the same name. What assimp does with
    // axes and unit depends on its version.
    character.nodes[0].name.clear();
    character.nodes[0].local = world_of(scene, character.notes);
  }
  if (!source.is_fbx) mend_blender(scene, character.nodes);
  index_names(character);
  add_clips(character, source);
  rest_in_bind_pose(character);
  return character;
}

}  // namespace fascicle::convert
