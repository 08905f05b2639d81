// The morph targets of an uncompressed surface.glb: sparse accessors, which store only the vertices that a
// target moves or turns. glb_compress.h has the compressed ones.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/formats/glb_targets.h"
#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

class GlbSparseTargets {
 public:
  // The rig must outlive it, and gets its parts before the first target.
  explicit GlbSparseTargets(const gltf::Rig& rig) : rig_(rig) {}

  // The next target's bytes. The caller writes them to the stream, target after target.
  std::string target(const GlbFrame& frame);

  // A part's targets, if the targets' accessors start at index `first_accessor`: POSITION and NORMAL (if the
  // part has one) for each part, target by target.
  nlohmann::json targets_of(std::size_t part, std::size_t first_accessor) const;
  // Those accessors as JSON text, each preceded by a comma. Adds their views to the document, whose buffer
  // holds the stream from byte `stream_at` on.
  std::string accessors(nlohmann::json& document, std::uint64_t stream_at) const;

 private:
  // A part's share of a target: where its numbers are in the stream.
  struct Piece {
    std::uint32_t count = 0;
    std::uint64_t indices = 0, positions = 0, normals = 0;
    std::array<float, 3> least{}, greatest{};
  };
  Piece append_part(const gltf::RigPart& part, std::size_t first, const GlbFrame& frame,
                    std::string& bytes) const;

  const gltf::Rig& rig_;
  std::vector<Piece> pieces_;  // for all parts, target by target
  std::size_t targets_ = 0;
  std::uint64_t stream_bytes_ = 0;
};

}  // namespace fascicle::formats
