// surface.glb in few bytes: positions and normals in whole numbers (KHR_mesh_quantization), all of it
// compressed (EXT_meshopt_compression).
//
// Vertices of all meshes of a skin lie on one grid, and the skin's inverse bind matrices lead from its steps
// to the file's own lengths; without a skin the node does, where nothing else goes by it. A target moves by
// whole steps from where the quantised vertex is, so that the two roundings do not add up. Where there is no
// grid (something outside the rig shows a mesh too) the vertices stay as they are, and targets move by
// multiples of a step.
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "host/formats/glb_pack.h"
#include "host/formats/glb_targets.h"
#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

class GlbCompression {
 public:
  // `stretch`: of each part, how much longer the clip's joints make a way in it, at most. `bound`: m, how far
  // a vertex may be moved. Throws BakeError where 16 bits a coordinate are too coarse for it.
  GlbCompression(const gltf::Rig& rig, const nlohmann::json& document, const std::vector<double>& stretch,
                 double bound);

  // The next target's bytes; they will lie in the stream, one target's after the other's.
  std::string target(const GlbFrame& frame);

  // m: how far a vertex was moved in a target, at most.
  double error() const { return error_; }

  // Puts quantised vertices into a document that is to have the targets. `mesh`: of each part.
  void quantise(gltf::GltfDocument& document, const std::vector<std::size_t>& mesh);
  // The targets of a part, and the accessors of all, each with a comma before it, if the first of them has
  // this number and their views begin with that one.
  nlohmann::json targets_of(std::size_t part, std::size_t first_accessor) const;
  std::string accessors(std::size_t first_view) const;
  // Compresses what is in the document so far and adds the views of the targets, whose stream follows.
  void pack(gltf::GltfDocument& document, std::uint64_t stream_bytes);

 private:
  // Vertices with one transform to bring them back.
  struct Grid {
    bool has_steps = false;  // else vertices stay as they are
    double step = 0.0;       // in the raw space
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  };
  enum class Kind : std::uint8_t { none, bytes, shorts, floats };
  // A part's piece of a target: where its values begin in the view of their size.
  struct Piece {
    Kind moves = Kind::none, turns = Kind::none;
    std::uint32_t moves_at = 0, turns_at = 0;
    std::array<double, 3> least{}, greatest{};
  };
  // Numbers of 4, 8 and 12 bytes.
  static constexpr std::array<std::size_t, 3> strides{4, 8, 12};
  struct Target {
    std::array<PackedView, 3> views{};  // offsets in the stream; count 0: none
  };

  using Steps = std::array<double, 3>;  // whole numbers
  struct PartSteps {
    std::vector<Steps> moves, turns;  // of a target; of normals in 1/127
  };
  static std::size_t view_of(Kind kind);  // among those of a target
  static int type_of(Kind kind);          // glTF's
  static double largest(const std::vector<Steps>& values);
  void choose_grids(const nlohmann::json& document, const std::vector<double>& stretch, double bound);
  Steps steps_at(std::size_t part, const Eigen::Vector3d& place) const;
  PartSteps steps_of(const GlbFrame& frame, std::size_t part, std::size_t first);
  // Turns too far for bytes, as lengths: from where the quantised normal is, so that roundings do not add up.
  std::vector<Steps> grains_of(const GlbFrame& frame, std::size_t part, std::size_t first) const;
  void note_error(const GlbFrame& frame, std::size_t part, std::size_t vertex, const Eigen::Vector3d& off);
  std::size_t add_positions(gltf::GltfDocument& document, std::size_t part) const;

  const gltf::Rig& rig_;
  std::vector<Grid> grids_;           // of parts
  std::vector<double> stretch_;       // of parts
  std::vector<std::int64_t> groups_;  // of parts: those with equal numbers share a grid
  std::vector<Piece> pieces_;         // of all parts, target by target
  std::vector<Target> targets_;
  std::vector<std::size_t> still_;  // of parts: the accessor of a target that leaves it alone
  std::set<std::size_t> perhaps_unused_;
  std::uint64_t stream_bytes_ = 0;
  double error_ = 0.0;
};

}  // namespace fascicle::formats
