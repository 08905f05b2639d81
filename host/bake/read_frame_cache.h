// The native frame cache, frames.fascicle: every vertex of the model in every frame, for export and rendering
// later.
//
// Little-endian. A header of 104 bytes, then records of equal size, one a frame, frame 0 first:
//   header   offset  0  char[8]    "FASCICLE"
//                    8  uint32     version of this format, 1
//                   12  uint32     bytes of the header, 104
//                   16  uint32     vertices n
//                   20  uint32     0
//                   24  float64    unit: metres per working unit
//                   32  float64    fps
//                   40  float64    time of frame 0 (s)
//                   48  uint64     last frame the bake will have
//                   56  uint64     hash of the model (model_hash)
//                   64  float64[3] rest origin (m)
//                   88  uint64     bytes of a record
//                   96  uint64     XXH3-64 of the 96 bytes before
//   record           0  uint64     frame
//                    8  float64[3] origin (m)
//                   32  float32[3n] positions: world position in metres = origin + unit x position
//                       zero bytes up to a multiple of 8
//         last 8 bytes  uint64     XXH3-64 of the record's bytes before
// Vertices are in the model's order. A writer that is stopped leaves at most records at the end that are too
// short or whose checksum is wrong; they do not count.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include "host/base/part_file.h"
#include "host/model/model.h"
#include "host/model/solver.h"

namespace fascicle::bake {

inline constexpr const char* cache_name = "frames.fascicle";
inline constexpr std::uint64_t cache_header_bytes = 104;

struct CacheHeader {
  std::uint32_t vertex_count = 0;
  double unit = 1.0;
  double fps = 60.0;
  double start = 0.0;
  std::uint64_t frames = 0;  // number of the last frame; a finished cache holds frames + 1 records
  std::uint64_t model_hash = 0;
  std::array<double, 3> rest_origin{0, 0, 0};
  bool operator==(const CacheHeader&) const = default;
};

// Of a bake of this model; `fps`, `start` and `frames` as in CacheHeader.
CacheHeader cache_header(const model::Model& model, double fps, double start, std::uint64_t frames);
std::uint64_t cache_record_bytes(std::uint32_t vertex_count);
std::string encode_cache_header(const CacheHeader& header);
std::string encode_cache_record(const CacheHeader& header, const model::Frame& frame);

class FrameCacheReader {
 public:
  // Throws BakeError if the file does not exist or is not a frame cache of a known version, std::system_error
  // if it cannot be read.
  explicit FrameCacheReader(const std::filesystem::path& path);

  const CacheHeader& header() const { return header_; }
  // Number of whole frames, from frame 0.
  std::uint64_t frame_count() const { return frame_count_; }
  // Frame k < frame_count(), with finite positions, without velocities and surface. Throws BakeError if it is
  // damaged.
  model::Frame read(std::uint64_t k) const;

 private:
  bool read_record(std::uint64_t k, std::string& bytes) const;

  base::File file_;
  CacheHeader header_;
  std::uint64_t record_bytes_ = 0;
  std::uint64_t frame_count_ = 0;
};

// The frames of a bake to resume that has written `count` of them. `header`: of this bake, which may have
// another number of frames. Throws BakeError if they belong to another bake, or fewer are complete.
FrameCacheReader frames_to_resume(const std::filesystem::path& path, const CacheHeader& header,
                                  std::uint64_t count);

// Whether the file begins like a frame cache. False if it cannot be read.
bool is_frame_cache(const std::filesystem::path& path);

}  // namespace fascicle::bake
