// The sinks there are. A new format is one file with its sink, a line here and a line in formats.cpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/bake/sink.h"
#include "host/model/model.h"

namespace fascicle::bake {

struct Format {
  std::string name;  // of --format; empty: always written
  std::string file;  // in the folder; ends in / for a folder of files
  std::unique_ptr<FrameSink> (*make)();
  // Bytes of `frames` frames.
  std::uint64_t (*bytes)(const model::Model& model, std::uint64_t frames);
};

// frame cache, metrics, pc2, vtu.
const std::vector<Format>& all_formats();

// frames.fascicle; see read_frame_cache.h.
std::unique_ptr<FrameSink> make_cache_sink();
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
//   NAME_x, NAME_y, NAME_z    m: mean position of each probe's vertices
std::unique_ptr<FrameSink> make_metrics_sink();
inline constexpr const char* metrics_name = "metrics.csv";
inline constexpr const char* lag_column = "lag_";

// The largest lag of each layer that ever lags, from a bake's metrics.csv; nothing without a skeleton.
struct PeakLag {
  std::string layer;
  double lag = 0.0;  // m
  std::uint64_t frame = 0;
};
std::vector<PeakLag> peak_lags(const std::filesystem::path& folder, const model::Model& model);

std::uint64_t metrics_bytes(const model::Model& model, std::uint64_t frames);

// surface.pc2: Point Cache 2 of the render mesh in its vertex order, metres, Y up; rest.obj is the mesh it
// rides on.
//   char[12] "POINTCACHE2\0", int32 version 1, int32 points, float32 first frame 0, float32 frames a sample
//   1, int32 samples, then float32 x y z of each point of each sample; little-endian.
std::unique_ptr<FrameSink> make_pc2_sink();
std::uint64_t pc2_bytes(const model::Model& model, std::uint64_t frames);

// vtu/frame_NNNNNN.vtu and vtu/series.pvd for ParaView: the tetrahedra in metres with displacement from frame
// 0 (m), velocity (m/s), layer, kinematic, and source_vertex, the vertex's number in the input's tetrahedral
// mesh.
std::unique_ptr<FrameSink> make_vtu_sink();
std::uint64_t vtu_bytes(const model::Model& model, std::uint64_t frames);
inline constexpr const char* vtu_folder = "vtu";
inline constexpr const char* vtu_series = "series.pvd";
std::string vtu_frame_name(std::uint64_t frame);
bool is_vtu_frame_name(const std::string& name);

}  // namespace fascicle::bake
