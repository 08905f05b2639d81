// surface.pc2: Point Cache 2, read by Blender's mesh cache, 3ds Max and Maya; rest.obj is the mesh it rides
// on.
//   char[12] "POINTCACHE2\0", int32 version 1, int32 points, float32 first frame, float32 frames a sample
//   1, int32 samples, then float32 x y z of each point of each sample; little-endian.
#include <limits>
#include <optional>

#include "host/base/errors.h"
#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/formats/formats.h"
#include "host/formats/surface.h"

namespace fascicle::formats {

namespace {

constexpr std::uint64_t pc2_header_bytes = 32;
constexpr std::uint64_t most_in_pc2 = std::numeric_limits<std::int32_t>::max();

class Pc2Sink final : public FrameSink {
 public:
  std::string name() const override { return "pc2"; }
  model::Read needs() const override { return {.surface = true}; }
  void begin(const BakeInfo& info) override {
    unit_ = info.model->unit;
    const std::uint64_t points = info.model->surface_count(), samples = info.frames + 1;
    if (points == 0) throw base::BakeError("pc2: the scene has no surface to write; leave out --format pc2");
    if (points > most_in_pc2 || samples > most_in_pc2)
      throw base::BakeError("pc2: the format counts to " + base::number_text(most_in_pc2) +
                            " points and frames, and this bake has " + base::number_text(points) + " and " +
                            base::number_text(samples) + "; leave out --format pc2");
    const std::filesystem::path path = info.folder / "surface.pc2";
    if (info.first > 0) {
      file_.emplace(base::PartFile::resume(path, pc2_header_bytes + info.first * points * 3 * sizeof(float)));
      return;
    }
    std::string header("POINTCACHE2", 12);
    base::append_bytes(header, std::int32_t{1});
    base::append_bytes(header, static_cast<std::int32_t>(points));
    base::append_bytes(header, static_cast<float>(info.first_number));
    base::append_bytes(header, 1.0f);
    base::append_bytes(header, static_cast<std::int32_t>(samples));
    file_.emplace(base::PartFile::start(path));
    file_->write(header);
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
