// surface.mdd: LightWave's Motion Designer Data, read by Blender's mesh cache, Modo, Houdini and Maya
// plug-ins. Big-endian int32 frames, int32 points, float32 time of each frame (s), then float32 x y z of each
// point of each frame.
#include <bit>
#include <optional>

#include "host/base/part_file.h"
#include "host/formats/formats.h"
#include "host/formats/point_cache.h"
#include "host/formats/surface.h"

namespace fascicle::formats {

namespace {

void append_big_endian(std::string& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>((value >> shift) & 255u);
}

void append_big_endian(std::string& out, float value) {
  append_big_endian(out, std::bit_cast<std::uint32_t>(value));
}

class MddSink final : public FrameSink {
 public:
  std::string name() const override { return "mdd"; }
  model::Read needs() const override { return {.surface = true}; }
  void begin(const BakeInfo& info) override {
    unit_ = info.model->unit;
    file_.emplace(open_point_cache(info, "mdd", [&](std::int32_t points, std::int32_t samples) {
      std::string header;
      append_big_endian(header, static_cast<std::uint32_t>(samples));
      append_big_endian(header, static_cast<std::uint32_t>(points));
      for (std::int32_t k = 0; k < samples; ++k)
        append_big_endian(header, static_cast<float>(static_cast<double>(k) / info.fps));
      return header;
    }));
  }
  void write(const model::Frame& frame) override {
    std::string bytes;
    bytes.reserve(frame.surface.size() * sizeof(float));
    for (const float value : world_positions(frame.surface, unit_, frame.origin))
      append_big_endian(bytes, value);
    file_->write(bytes);
  }
  void sync() override { file_->sync(); }
  void finish() override { file_->finish(); }

 private:
  double unit_ = 1.0;
  std::optional<base::PartFile> file_;
};

std::uint64_t mdd_bytes(const model::Model& model, std::uint64_t frames) {
  return 8 + frames * (1 + std::uint64_t{3} * model.surface_count()) * sizeof(float);
}

}  // namespace

Format mdd_format() {
  return {.name = "mdd", .file = "surface.mdd", .make = make_sink<MddSink>, .bytes = mdd_bytes};
}

}  // namespace fascicle::formats
