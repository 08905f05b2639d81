// The frame cache's writer: records appended one by one under the final name.
#include <optional>
#include <system_error>

#include "host/bake/bake.h"
#include "host/bake/outputs.h"
#include "host/bake/read_frame_cache.h"
#include "host/base/text.h"
#include "host/formats/formats.h"

namespace fascicle::bake {

namespace {

class CacheSink final : public formats::FrameSink {
 public:
  std::string name() const override { return "cache"; }
  model::Read needs() const override { return {.positions = true}; }
  void begin(const formats::BakeInfo& info) override {
    const std::filesystem::path path = info.folder / cache_name;
    header_ = cache_header(*info.model, info.fps, info.start, info.frames);
    if (info.first == 0) {
      file_.emplace(path, base::FileMode::replace);
      file_->write(encode_cache_header(header_));
      return;
    }
    const FrameCacheReader reader = frames_to_resume(path, header_, info.first);
    file_.emplace(path, base::FileMode::modify);
    if (reader.header() != header_) file_->write_at(0, encode_cache_header(header_));
    file_->truncate(cache_header_bytes + info.first * cache_record_bytes(header_.vertex_count));
  }
  void write(const model::Frame& frame) override {
    const std::uint64_t end = file_->size();
    try {
      file_->write(encode_cache_record(header_, frame));
    } catch (const std::system_error&) {
      // Disk full: drop the partial record. If this fails too, readers ignore it because of its length.
      try {
        file_->truncate(end);
      } catch (const std::system_error&) {
      }
      throw;
    }
  }
  void sync() override { file_->sync(); }
  void finish() override {
    file_->sync();
    file_->close();
  }

 private:
  CacheHeader header_;
  std::optional<base::File> file_;
};

}  // namespace

std::unique_ptr<formats::FrameSink> make_cache_sink() {
  return std::make_unique<CacheSink>();
}

std::uint64_t cache_bytes(const model::Model& model, std::uint64_t frames) {
  return cache_header_bytes + frames * cache_record_bytes(model.vertex_count);
}

}  // namespace fascicle::bake
