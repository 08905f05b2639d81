// What glTF 2.0 says a viewer shows, worked out from the document alone: nothing of the program's reader.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

namespace fascicle::tests {

// Of documents with one buffer: accessors of floats or of integers, normalised or not, sparse ones too;
// clips of steps and of linear keys.
class GltfViewer {
 public:
  explicit GltfViewer(const std::filesystem::path& glb);
  GltfViewer(nlohmann::json document, std::vector<unsigned char> binary);
  // Of a GltfBuilder.
  template <class Builder>
  requires requires(const Builder& b) { b.document, b.bytes; }
  explicit GltfViewer(const Builder& builder) : GltfViewer(builder.document, builder.bytes) {}

  // The vertices of every primitive of every node that shows a mesh, in the order of the nodes, at `time` of
  // the clip with this number; a negative one: as the nodes rest.
  std::vector<Eigen::Vector3d> shown(int clip, double time) const;

  // Their normals before skins and nodes turn them, as long as they come out.
  std::vector<Eigen::Vector3d> raw_normals(int clip, double time) const;

  nlohmann::json document;

 private:
  // An attribute of three values with the primitive's targets.
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
