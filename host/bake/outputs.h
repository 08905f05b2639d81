// All files that grow with a bake: its own record, which is the frame cache and the metrics, and the formats
// of other programs.
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

// Frame cache, metrics, and those with a name.
const std::vector<formats::Format>& all_formats();

// Names accepted in BakeOptions::formats.
const std::vector<std::string>& format_names();

// Bytes a bake will write.
std::uint64_t output_bytes(const scene::Scene& scene, const model::Model& model,
                           const std::vector<std::string>& formats, const formats::GlbOptions& glb = {});

// frames.fascicle; see read_frame_cache.h.
std::unique_ptr<formats::FrameSink> make_cache_sink();
std::uint64_t cache_bytes(const model::Model& model, std::uint64_t frames);

// metrics.csv: one line a frame, SI units, the world's axes.
//   frame, time               s of the clip
//   kinetic_energy            J, of all vertices
//   volume, volume_ratio      m^3 of all tetrahedra (an inverted one counts negative), and over that of the
//                             rest shape
//   largest_displacement      m: of the vertex furthest from its place in frame 0
//   inverted                  tetrahedra that are flat or turned inside out
//   inverted_skinned          those that skinning alone leaves so; with a skeleton only, and so are
//   lag_NAME                  m: the root mean square distance of a layer's free vertices to their skinned
//                             places; 0 where it has none
//   contact_vertices          of the surface that lie in flesh far from them at rest, deeper than their rest
//                             shape does (model/overlap.h); with contact only, and so are
//   contact_deepest           m: of these, how much deeper below the surface of that flesh
//   contact_volume            m^3 that lie in other flesh beyond what the rest shape does; and the same three
//                             as skinning alone leaves them, with a skeleton: contact_vertices_skinned, ...
//   volume_NAME               m^3: a layer's, of each tetrahedron the quarters of the layer's vertices; and
//   volume_ratio_NAME         over that of the rest shape
//   NAME_x, NAME_y, NAME_z    m: mean position of each probe's vertices
//   look                      how the frame looks beside skinning: the largest of the look_ columns. 1 is the
//                             limit, above is red; look.h has the measures. With a skeleton and a render mesh
//                             only, and so are
//   worst_joint               where: the joint whose skin it is; empty where the score is 0
//   look_stretch, look_crossing, look_distance, look_rigid, look_jump, look_inverted
// `body`: look_body_of, where somebody has made it; it outlives the sink.
std::unique_ptr<formats::FrameSink> make_metrics_sink(const LookBody* body = nullptr);
inline constexpr const char* metrics_name = "metrics.csv";
inline constexpr const char* lag_column = "lag_";
inline constexpr const char* look_column = "look";
inline constexpr const char* look_joint_column = "worst_joint";
inline constexpr const char* volume_column = "volume_";
inline constexpr const char* volume_ratio_column = "volume_ratio_";

// The largest lag of each layer that ever lags, from a bake's metrics.csv; nothing without a skeleton.
struct PeakLag {
  std::string layer;
  double lag = 0.0;  // m
  std::uint64_t frame = 0;
};
std::vector<PeakLag> peak_lags(const std::filesystem::path& folder, const model::Model& model);

std::uint64_t metrics_bytes(const model::Model& model, std::uint64_t frames);

}  // namespace fascicle::bake
