// A scene as assimp gives it, set straight: one node for each of the file's, metres and Y up, keys in
// seconds, the pose that the skins were bound in at rest.
#pragma once

#include <cstddef>
#include <string>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <assimp/scene.h>

namespace fascicle::convert {

using Matrix = Eigen::Matrix4d;

struct Parts {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
};

Matrix matrix_of(const aiMatrix4x4& m);
Matrix matrix_of(const Parts& parts);
// The nearest there is: shear is lost.
Parts parts_of(const Matrix& matrix);

// One factor of a node's transform in an FBX file. Assimp makes a node of each.
struct Link {
  std::string name;       // as clips call it
  std::string component;  // "Translation", "PreRotation", ...
  Matrix matrix = Matrix::Identity();
};

struct Node {
  std::string name;
  int parent = -1;  // parents stand before their children
  Matrix local = Matrix::Identity();
  std::vector<Link> chain;               // whose product `local` is; none: it is one transform
  Matrix geometry = Matrix::Identity();  // places the meshes, but not what stands below
  Matrix mended = Matrix::Identity();    // what the offsets of the meshes' bones lack, at their right
  std::vector<const aiMesh*> meshes;
};

// Values at times, s. Linear in between.
struct Track {
  std::size_t node = 0;
  std::vector<double> times;
  std::vector<Parts> values;
};

struct ShapeTrack {
  std::size_t node = 0;
  std::vector<double> times;
  std::vector<std::vector<double>> weights;  // at a time: of each shape
};

struct Clip {
  std::string name;
  std::vector<Track> tracks;
  std::vector<ShapeTrack> shapes;
};

struct Character {
  const aiScene* scene = nullptr;
  std::vector<Node> nodes;
  std::unordered_map<std::string, std::vector<std::size_t>> by_name;
  std::vector<Clip> clips;
  std::vector<std::string> notes;  // what was lost on the way
};

// `is_fbx`: the scene's axes, unit and chains are those of an FBX file.
Character character_of(const aiScene& scene, bool is_fbx);

// From the space of the node's meshes to that of a bone, when they were bound.
Matrix bind_offset(const Node& node, const aiBone& bone);

// The node that clips and skins call by this name, or nodes.size().
std::size_t find_node(const Character& character, const std::string& name);

std::vector<Matrix> global_transforms(const std::vector<Node>& nodes);

// The steps of character_of after the nodes.
void add_clips(Character& character, bool is_fbx);
// Where the nodes stand in another pose than the skins were bound in, puts them there; clips that do not move
// a node so moved get its place as a key.
void rest_in_bind_pose(Character& character);

}  // namespace fascicle::convert
