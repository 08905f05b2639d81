// What a viewer shows according to glTF 2.0, computed from the document without the program's reader.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

namespace fascicle::tests {

// For documents with one buffer: accessors of floats or integers, normalised or not, also sparse; clips with
// step and linear keys.
class GltfViewer {
 public:
  explicit GltfViewer(const std::filesystem::path& glb);
  GltfViewer(nlohmann::json document, std::vector<unsigned char> binary);
  // From a GltfBuilder.
  template <class Builder>
  requires requires(const Builder& b) { b.document, b.bytes; }
  explicit GltfViewer(const Builder& builder) : GltfViewer(builder.document, builder.bytes) {}

  // The vertices of every primitive of every node with a mesh, in the order of nodes, at `time` of the clip
  // with this index; negative: the rest pose.
  std::vector<Eigen::Vector3d> shown(int clip, double time) const;

  // Their morphed normals before skins and nodes rotate them, not normalised.
  std::vector<Eigen::Vector3d> raw_normals(int clip, double time) const;

  // The same as viewers shade with them: rotated by the blend of the joints' transforms itself, not by its
  // inverse transpose, and normalised. For skinned meshes of one set of joints.
  std::vector<Eigen::Vector3d> normals(int clip, double time) const;

  nlohmann::json document;

 private:
  // Of a node's joints, or of the node itself if it has no skin.
  std::vector<Eigen::Matrix4d> maps(int clip, double time, std::size_t node) const;
  // An attribute of three values with the primitive's morph targets applied.
  std::vector<double> morphed(const nlohmann::json& primitive, const std::string& attribute,
                              const std::vector<double>& weights) const;
  std::vector<double> weights(int clip, double time, std::size_t node) const;
  std::vector<double> numbers(const nlohmann::json& accessor) const;
  std::vector<double> value(int clip, double time, std::size_t node, const std::string& path,
                            std::vector<double> fallback) const;
  Eigen::Matrix4d global(int clip, double time, std::size_t node) const;
  void find_parents();

  std::vector<unsigned char> binary_;
  std::vector<int> parents_;
};

}  // namespace fascicle::tests
