#include "host/bake/read_frame_cache.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>
#include <system_error>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "host/bake/bake.h"
#include "host/bake/finite.h"
#include "host/bake/identity.h"
#include "host/bake/sealed_file.h"
#include "host/base/text.h"
#include "host/model/reach.h"
#include "host/scene/scene_file.h"

namespace fascicle::bake {

namespace {

constexpr std::string_view cache_magic = "FASCICLE";
constexpr std::uint32_t cache_version = 1;

template <class T>
T value_at(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

// Whether the last eight bytes are the checksum of those before.
bool is_sealed(std::string_view bytes) {
  const std::size_t length = bytes.size() - sizeof(std::uint64_t);
  return XXH3_64bits(bytes.data(), length) == value_at<std::uint64_t>(bytes, length);
}

void seal(std::string& bytes) {
  const std::uint64_t checksum = XXH3_64bits(bytes.data(), bytes.size());
  base::append_bytes(bytes, checksum);
}

}  // namespace

CacheHeader cache_header(const model::Model& model, double fps, double start, std::uint64_t frames) {
  return {.vertex_count = model.vertex_count,
          .unit = model.unit,
          .fps = fps,
          .start = start,
          .frames = frames,
          .model_hash = model_hash(model),
          .rest_origin = model.rest_origin};
}

std::uint64_t cache_record_bytes(std::uint32_t vertex_count) {
  const std::uint64_t positions = std::uint64_t{12} * vertex_count;
  return 32 + (positions + 7) / 8 * 8 + 8;
}

std::string encode_cache_header(const CacheHeader& header) {
  std::string bytes(cache_magic);
  base::append_bytes(bytes, cache_version);
  base::append_bytes(bytes, static_cast<std::uint32_t>(cache_header_bytes));
  base::append_bytes(bytes, header.vertex_count);
  base::append_bytes(bytes, std::uint32_t{0});
  base::append_bytes(bytes, header.unit);
  base::append_bytes(bytes, header.fps);
  base::append_bytes(bytes, header.start);
  base::append_bytes(bytes, header.frames);
  base::append_bytes(bytes, header.model_hash);
  base::append_bytes(bytes, header.rest_origin);
  base::append_bytes(bytes, cache_record_bytes(header.vertex_count));
  seal(bytes);
  return bytes;
}

std::string encode_cache_record(const CacheHeader& header, const model::Frame& frame) {
  const std::uint64_t size = cache_record_bytes(header.vertex_count);
  std::string bytes;
  bytes.reserve(size);
  base::append_bytes(bytes, frame.index);
  base::append_bytes(bytes, frame.origin);
  base::append_array(bytes, std::span<const float>(frame.positions));
  bytes.resize(size - sizeof(std::uint64_t), '\0');
  seal(bytes);
  return bytes;
}

namespace {

constexpr std::uint64_t most_unchecked_bytes = std::uint64_t{64} << 20;

base::File opened(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path))
    throw BakeError(
        path.string() +
        ": does not exist; the bake has no frames yet, or lost them: wait for them, or bake again "
        "with --overwrite");
  return {path, base::FileMode::read};
}

// Rejects numbers that no bake writes, whatever the checksum says.
bool is_sound(const CacheHeader& header) {
  // Bounds of the keys scene.fps and scene.start.
  constexpr double least_fps = 1e-3, most_fps = 1e5;
  return header.vertex_count > 0 && header.unit > 0.0 && header.unit <= model::farthest &&
         header.fps >= least_fps && header.fps <= most_fps && std::isfinite(header.start) &&
         model::is_in_reach(header.rest_origin) && static_cast<double>(header.frames) <= scene::most_frames;
}

}  // namespace

FrameCacheReader::FrameCacheReader(const std::filesystem::path& path) : file_(opened(path)) {
  std::string bytes(cache_header_bytes, '\0');
  if (!file_.read_at(0, bytes) || !bytes.starts_with(cache_magic))
    throw BakeError(path.string() + ": not a frame cache of fascicle");
  if (const auto found = value_at<std::uint32_t>(bytes, 8); found != cache_version)
    throw BakeError(path.string() + ": a frame cache of version " + base::number_text(found) +
                    ", and this program reads " + base::number_text(cache_version) + "; bake again");
  if (!is_sealed(bytes)) throw BakeError(path.string() + ": the header is damaged; bake again");
  header_.vertex_count = value_at<std::uint32_t>(bytes, 16);
  header_.unit = value_at<double>(bytes, 24);
  header_.fps = value_at<double>(bytes, 32);
  header_.start = value_at<double>(bytes, 40);
  header_.frames = value_at<std::uint64_t>(bytes, 48);
  header_.model_hash = value_at<std::uint64_t>(bytes, 56);
  header_.rest_origin = value_at<std::array<double, 3>>(bytes, 64);
  if (!is_sound(header_))
    throw BakeError(path.string() + ": the header has an impossible frame rate, start or size; bake again");
  record_bytes_ = cache_record_bytes(header_.vertex_count);
  // No more than the header says: a sparse file of any length takes no space.
  frame_count_ = std::min((file_.size() - cache_header_bytes) / record_bytes_, header_.frames + 1);
  // After a power cut the end may have the right length without ever having reached the disk.
  std::string record;
  while (frame_count_ > 0 && !read_record(frame_count_ - 1, record)) --frame_count_;
}

bool FrameCacheReader::read_record(std::uint64_t k, std::string& bytes) const {
  const std::uint64_t begin = cache_header_bytes + k * record_bytes_;
  // The number first: many whole records may be missing.
  bytes.resize(sizeof(std::uint64_t));
  if (!file_.read_at(begin, bytes) || value_at<std::uint64_t>(bytes, 0) != k) return false;
  // A long record takes no memory before its checksum is known to be right: a sparse file of any length takes
  // no space.
  if (record_bytes_ > most_unchecked_bytes && !is_sealed_part(file_, begin, record_bytes_)) return false;
  bytes.resize(record_bytes_);
  return file_.read_at(begin, bytes) && is_sealed(bytes);
}

model::Frame FrameCacheReader::read(std::uint64_t k) const {
  std::string bytes;
  if (k >= frame_count_)
    throw BakeError(file_.path().string() + ": has no frame " + base::number_text(k) +
                    "; it has frames 0 to " + base::number_text(frame_count_) + " (exclusive)");
  if (!read_record(k, bytes))
    throw BakeError(file_.path().string() + ": frame " + base::number_text(k) + " is damaged; bake again");
  model::Frame frame;
  frame.index = k;
  frame.origin = value_at<std::array<double, 3>>(bytes, 8);
  frame.positions.resize(std::size_t{3} * header_.vertex_count);
  std::memcpy(frame.positions.data(), bytes.data() + 32, frame.positions.size() * sizeof(float));
  if (!is_in_reach(frame, header_.unit))
    throw BakeError(file_.path().string() + ": frame " + base::number_text(k) +
                    " has positions that are not finite numbers, or absurdly far away; bake again");
  return frame;
}

FrameCacheReader frames_to_resume(const std::filesystem::path& path, const CacheHeader& header,
                                  std::uint64_t count) {
  FrameCacheReader reader(path);
  CacheHeader before = reader.header();
  before.frames = header.frames;
  if (before != header)
    throw BakeError(path.string() + ": belongs to another bake; start again with --overwrite");
  if (reader.frame_count() < count)
    throw BakeError(path.string() + ": has " + base::number_text(reader.frame_count()) +
                    " complete frames, but the checkpoint has " + base::number_text(count) +
                    "; start again with --overwrite");
  return reader;
}

bool is_frame_cache(const std::filesystem::path& path) {
  try {
    std::array<char, 8> bytes{};
    return base::File(path, base::FileMode::read).read_at(0, bytes) &&
           std::string_view(bytes.data(), bytes.size()) == cache_magic;
  } catch (const base::InputError&) {
    return false;
  } catch (const std::system_error&) {
    return false;
  }
}

}  // namespace fascicle::bake
