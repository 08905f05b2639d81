// A scene from assimp, normalised: one node for each of the file's, metres and Y up, keys in seconds, and the
// bind pose at rest.
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

// What a file says and assimp's scene does not.
struct Source {
  bool is_fbx = false;     // it has an FBX file's axes, unit and chains
  bool has_spans = false;  // FBX: a stack states its start or its stop
  // Collada: names more than one clip. Assimp 5.2 does not read which animations they have.
  bool has_several_clips = false;
};

Source source_of(const std::string& bytes, bool is_fbx);

struct Parts {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
};

Matrix matrix_of(const aiMatrix4x4& m);
Matrix matrix_of(const Parts& parts);
// The nearest decomposition: shear is lost.
Parts parts_of(const Matrix& matrix);

// One factor of a node's transform in an FBX file. Assimp makes each a node.
struct Link {
  std::string name;       // the name used by clips
  std::string component;  // "Translation", "PreRotation", ...
  Matrix matrix = Matrix::Identity();
};

struct Node {
  std::string name;
  int parent = -1;  // parents come before their children
  Matrix local = Matrix::Identity();
  std::vector<Link> chain;               // factors of `local`; empty: it is a single transform
  Matrix geometry = Matrix::Identity();  // places the meshes, but not the child nodes
  Matrix mended = Matrix::Identity();    // correction of the bones' offset matrices, multiplied on the right
  std::vector<const aiMesh*> meshes;
};

// Values at times, s, linearly interpolated.
struct Track {
  std::size_t node = 0;
  std::vector<double> times;
  std::vector<Parts> values;
};

struct ShapeTrack {
  std::size_t node = 0;
  std::vector<double> times;
  std::vector<std::vector<double>> weights;  // per time: the weight of each shape
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
  std::vector<std::string> notes;  // what was lost in the conversion
};

Character character_of(const aiScene& scene, const Source& source);

// Maps the space of the node's meshes to that of a bone, in the bind pose.
Matrix bind_offset(const Node& node, const aiBone& bone);

// The node that clips and skins refer to by this name, or nodes.size().
std::size_t find_node(const Character& character, const std::string& name);

std::vector<Matrix> global_transforms(const std::vector<Node>& nodes);

// The steps of character_of after the nodes are read.
void add_clips(Character& character, const Source& source);
// If the nodes are not in the bind pose, moves them there. Clips without a track for a moved node get its
// original pose as a key.
void rest_in_bind_pose(Character& character);

}  // namespace fascicle::convert
