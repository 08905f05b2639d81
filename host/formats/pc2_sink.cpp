// surface.pc2: Point Cache 2, read by Blender's mesh cache, 3ds Max and Maya. It animates the mesh rest.obj.
//   char[12] "POINTCACHE2\0", int32 version 1, int32 points, float32 first frame, float32 frames per sample
//   (1), int32 samples, then float32 x y z of each point of each sample; little-endian.
#include <optional>

#include "host/base/part_file.h"
#include "host/formats/formats.h"
#include "host/formats/point_cache.h"
#include "host/formats/surface.h"

namespace fascicle::formats {

namespace {

constexpr std::uint64_t pc2_header_bytes = 32;

class Pc2Sink final : public FrameSink {
 public:
  std::string name() const override { return "pc2"; }
  model::Read needs() const override { return {.surface = true}; }
  void begin(const BakeInfo& info) override {
    unit_ = info.model->unit;
    file_.emplace(open_point_cache(info, "pc2", [&](std::int32_t points, std::int32_t samples) {
      std::string header("POINTCACHE2", 12);
      base::append_bytes(header, std::int32_t{1});
      base::append_bytes(header, points);
      base::append_bytes(header, static_cast<float>(info.first_number));
      base::append_bytes(header, 1.0f);
      base::append_bytes(header, samples);
      return header;
    }));
  }
  void write(const model::Frame& frame) override {
    const std::vector<float> world = world_positions(frame.surface, unit_, frame.origin);
    file_->write({reinterpret_cast<const char*>(world.data()), world.size() * sizeof(float)});
  }
  void sync() override { file_->sync(); }
  void finish() override { file_->finish(); }

 private:
  double unit_ = 1.0;
  std::optional<base::PartFile> file_;
};

std::uint64_t pc2_bytes(const model::Model& model, std::uint64_t frames) {
  return pc2_header_bytes + frames * model.surface_count() * 3 * sizeof(float);
}

}  // namespace

Format pc2_format() {
  return {.name = "pc2", .file = "surface.pc2", .make = make_sink<Pc2Sink>, .bytes = pc2_bytes};
}

}  // namespace fascicle::formats
