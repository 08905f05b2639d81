// surface.mdd: LightWave's Motion Designer Data, read by Blender's mesh cache, Modo, Houdini and Maya's
// plug-ins. Big-endian int32 frames, int32 points, float32 time of each frame (s), then float32 x y z of each
// point of each frame.
#include <bit>
#include <limits>
#include <optional>

#include "host/base/errors.h"
#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/formats/formats.h"
#include "host/formats/surface.h"

namespace fascicle::formats {

namespace {

constexpr std::uint64_t most_in_mdd = std::numeric_limits<std::int32_t>::max();

void append_big_endian(std::string& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>((value >> shift) & 255u);
}

void append_big_endian(std::string& out, float value) {
  append_big_endian(out, std::bit_cast<std::uint32_t>(value));
}

std::uint64_t mdd_header_bytes(std::uint64_t samples) {
  return 8 + samples * sizeof(float);
}

class MddSink final : public FrameSink {
 public:
  std::string name() const override { return "mdd"; }
  model::Read needs() const override { return {.surface = true}; }
  void begin(const BakeInfo& info) override {
    unit_ = info.model->unit;
    const std::uint64_t points = info.model->surface_count(), samples = info.frames + 1;
    if (points == 0) throw base::BakeError("mdd: the scene has no surface to write; leave out --format mdd");
    if (points > most_in_mdd || samples > most_in_mdd)
      throw base::BakeError("mdd: the format counts to " + base::number_text(most_in_mdd) +
                            " points and frames, and this bake has " + base::number_text(points) + " and " +
                            base::number_text(samples) + "; leave out --format mdd");
    const std::filesystem::path path = info.folder / "surface.mdd";
    if (info.first > 0) {
      file_.emplace(
          base::PartFile::resume(path, mdd_header_bytes(samples) + info.first * points * 3 * sizeof(float)));
      return;
    }
    std::string header;
    append_big_endian(header, static_cast<std::uint32_t>(samples));
    append_big_endian(header, static_cast<std::uint32_t>(points));
    for (std::uint64_t k = 0; k < samples; ++k)
      append_big_endian(header, static_cast<float>(static_cast<double>(k) / info.fps));
    file_.emplace(base::PartFile::start(path));
    file_->write(header);
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
  return mdd_header_bytes(frames) + frames * model.surface_count() * 3 * sizeof(float);
}

}  // namespace

Format mdd_format() {
  return {.name = "mdd", .file = "surface.mdd", .make = make_sink<MddSink>, .bytes = mdd_bytes};
}

}  // namespace fascicle::formats
