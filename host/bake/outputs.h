// All files that grow with a bake: frame cache and metrics, and the formats for other programs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/formats/formats.h"
#include "host/formats/sink.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

struct LookBody;

// Frame cache, metrics, and the named formats.
const std::vector<formats::Format>& all_formats();

// Names accepted in BakeOptions::formats.
const std::vector<std::string>& format_names();

// Bytes that a bake will write.
std::uint64_t output_bytes(const scene::Scene& scene, const model::Model& model,
                           const std::vector<std::string>& formats, const formats::GlbOptions& glb = {});

// frames.fascicle; see read_frame_cache.h.
std::unique_ptr<formats::FrameSink> make_cache_sink();
std::uint64_t cache_bytes(const model::Model& model, std::uint64_t frames);

// metrics.csv: one line per frame, SI units, world axes.
//   frame, time               s of the clip
//   kinetic_energy            J, of all vertices
//   volume, volume_ratio      m^3 of all tetrahedra (an inverted one counts negative), and the ratio to the
//                             rest shape
//   largest_displacement      m: of the vertex furthest from its position in frame 0
//   inverted                  tetrahedra that are flat or inside out
//   inverted_skinned          the same by skinning alone; only with a skeleton, like
//   lag_NAME                  m: root mean square distance of a layer's free vertices from their skinned
//                             positions; 0 if it has none
//   contact_vertices          surface vertices that lie in flesh far from them at rest, deeper than in the
//                             rest shape (model/overlap.h); only with contact, like
//   contact_deepest           m: the largest depth of these below that flesh's surface, beyond that at rest
//   contact_volume            m^3 inside other flesh beyond that of the rest shape; with a skeleton, the same
//                             three by skinning alone: contact_vertices_skinned, ...
//   volume_NAME               m^3 of a layer: a quarter of each tetrahedron for each vertex in the layer; and
//   volume_ratio_NAME         its ratio to the rest shape
//   NAME_x, NAME_y, NAME_z    m: mean position of each probe's vertices
//   look                      how the frame looks compared with skinning: the largest of the look_ columns. 1
//                             is the limit, above is red; look.h has the measures. Only with a skeleton and a
//                             render mesh, like
//   worst_joint               where: the joint of that skin; empty if the score is 0
//   look_stretch, look_crossing, look_distance, look_rigid, look_jump, look_inverted
// `body`: from look_body_of, if the caller has it; must outlive the sink.
std::unique_ptr<formats::FrameSink> make_metrics_sink(const LookBody* body = nullptr);
inline constexpr const char* metrics_name = "metrics.csv";
inline constexpr const char* lag_column = "lag_";
inline constexpr const char* look_column = "look";
inline constexpr const char* deepest_skinned_column = "contact_deepest_skinned";
inline constexpr const char* look_joint_column = "worst_joint";
inline constexpr const char* volume_column = "volume_";
inline constexpr const char* volume_ratio_column = "volume_ratio_";

// The largest lag of each layer that ever lags, from a bake's metrics.csv; empty without a skeleton.
struct PeakLag {
  std::string layer;
  double lag = 0.0;  // m
  std::uint64_t frame = 0;
};
std::vector<PeakLag> peak_lags(const std::filesystem::path& folder, const model::Model& model);

std::uint64_t metrics_bytes(const model::Model& model, std::uint64_t frames);

}  // namespace fascicle::bake
