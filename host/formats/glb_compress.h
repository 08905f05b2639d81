// A smaller surface.glb: positions and normals as integers (KHR_mesh_quantization), everything compressed
// (EXT_meshopt_compression).
//
// The vertices of all meshes of a skin share one grid, and the skin's inverse bind matrices convert its steps
// to the file's units. Without a skin, the node's transform does, provided that nothing else depends on it. A
// target moves by whole steps from the quantised vertex, so the two rounding errors do not add up. Without a
// grid (because something outside the rig uses the same mesh) vertices are not quantised, and targets move by
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
  // `stretch`: per part, the largest factor by which the clip's joints lengthen a vector. `bound`: m, the
  // largest allowed displacement of a vertex. Throws BakeError if 16 bits per coordinate are too coarse for
  // it.
  GlbCompression(const gltf::Rig& rig, const nlohmann::json& document, const std::vector<double>& stretch,
                 double bound);

  // The next target's bytes. The caller writes them to the stream, target after target.
  std::string target(const GlbFrame& frame);

  // m: the largest displacement of a vertex in any target so far.
  double error() const { return error_; }

  // Quantises the vertices of the document before it gets the targets. `mesh`: per part.
  void quantise(gltf::GltfDocument& document, const std::vector<std::size_t>& mesh);
  // A part's targets, if the targets' accessors start at index `first_accessor`; and the JSON of all those
  // accessors, each preceded by a comma, if their views start at `first_view`.
  nlohmann::json targets_of(std::size_t part, std::size_t first_accessor) const;
  std::string accessors(std::size_t first_view) const;
  // Compresses the document's present contents and adds the targets' views; their stream follows it.
  void pack(gltf::GltfDocument& document, std::uint64_t stream_bytes);

 private:
  // Quantisation grid of vertices that share a dequantising transform.
  struct Grid {
    bool has_steps = false;  // else vertices are not quantised
    double step = 0.0;       // in raw space
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  };
  enum class Kind : std::uint8_t { none, bytes, shorts, floats };
  // A part's share of a target: where its values begin in the view of their element size.
  struct Piece {
    Kind moves = Kind::none, turns = Kind::none;
    std::uint32_t moves_at = 0, turns_at = 0;
    std::array<double, 3> least{}, greatest{};
  };
  // Bytes per element: 4, 8 and 12.
  static constexpr std::array<std::size_t, 3> strides{4, 8, 12};
  struct Target {
    std::array<PackedView, 3> views{};  // offsets in the stream; count 0: none
  };

  using Steps = std::array<double, 3>;  // whole numbers
  struct PartSteps {
    std::vector<Steps> moves, turns;  // of one target; turns in 1/127
  };
  static std::size_t view_of(Kind kind);  // index among a target's views
  static int type_of(Kind kind);          // glTF component type
  static double largest(const std::vector<Steps>& values);
  void choose_grids(const nlohmann::json& document, const std::vector<double>& stretch, double bound);
  Steps steps_at(std::size_t part, const Eigen::Vector3d& place) const;
  PartSteps steps_of(const GlbFrame& frame, std::size_t part, std::size_t first);
  // Normal offsets too large for 8 bits, as floats: from the quantised normal, so that rounding errors do not
  // add up.
  std::vector<Steps> grains_of(const GlbFrame& frame, std::size_t part, std::size_t first) const;
  void note_error(const GlbFrame& frame, std::size_t part, std::size_t vertex, const Eigen::Vector3d& off);
  std::size_t add_positions(gltf::GltfDocument& document, std::size_t part) const;

  const gltf::Rig& rig_;
  std::vector<Grid> grids_;           // per part
  std::vector<double> stretch_;       // per part
  std::vector<std::int64_t> groups_;  // per part: equal numbers share a grid
  std::vector<Piece> pieces_;         // for all parts, target by target
  std::vector<Target> targets_;
  std::vector<std::size_t> still_;  // per part: accessor of a target that moves nothing
  std::set<std::size_t> perhaps_unused_;
  std::uint64_t stream_bytes_ = 0;
  double error_ = 0.0;
};

}  // namespace fascicle::formats
