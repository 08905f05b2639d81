#include <cstring>

#include "host/bake/checkpoint.h"
#include "host/bake/kept_start.h"
#include "host/bake/manifest.h"
#include "host/bake/model_file.h"
#include "host/bake/read_frame_cache.h"
#include "host/bake/sealed_json.h"
#include "host/base/errors.h"
#include "host/base/json_text.h"
#include "tests/fuzz/one_file.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/seal.h"
#include "tests/fuzz/taken.h"

namespace fascicle::fuzz {
namespace {

using base::BakeError;

// With correct checksums of the header and the first records. Only a few records: more would test nothing
// new.
std::string sealed_frames(std::string_view bytes) {
  std::string whole(bytes);
  seal(whole, 0, bake::cache_header_bytes - 8);
  std::uint32_t vertices = 0;
  if (whole.size() < bake::cache_header_bytes) return whole;
  std::memcpy(&vertices, whole.data() + 16, sizeof vertices);
  const std::uint64_t record = bake::cache_record_bytes(vertices);
  std::size_t at = bake::cache_header_bytes;
  for (int k = 0; k < 8 && whole.size() - at >= record; ++k, at += record) seal(whole, at, at + record - 8);
  return whole;
}

// The size of a kept start's header, before its checkpoint (host/bake/kept_start.cpp).
constexpr std::size_t start_head_bytes = 40;

bool frames_as_they_are(const OneFile& file, std::string_view bytes) {
  file.write(bytes);
  return is_taken<BakeError>([&] {
    const bake::FrameCacheReader reader(file.path());
    for (std::uint64_t k = 0; k < reader.frame_count() && k < 8; ++k) (void)reader.read(k);
  });
}

bool checkpoint_as_it_is(std::string_view bytes) {
  return is_taken<BakeError>([&] {
    const bake::Checkpoint found = bake::parse_checkpoint(bytes, "checkpoint");
    model::Model of_two;
    of_two.vertex_count = 2;
    bake::check_checkpoint(found, of_two, 100, "checkpoint");
  });
}

}  // namespace

bool frames(std::string_view bytes) {
  static const OneFile file("frames.fascicle");
  const bool is_whole = frames_as_they_are(file, bytes);
  const std::string whole = sealed_frames(bytes);
  return whole == bytes ? is_whole : frames_as_they_are(file, whole);
}

bool model(std::string_view bytes) {
  const bool is_whole = is_taken<BakeError>([&] { bake::decode_model(bytes); });
  const std::string whole = sealed(bytes);
  return whole == bytes ? is_whole : is_taken<BakeError>([&] { bake::decode_model(whole); });
}

bool checkpoint(std::string_view bytes) {
  const bool is_whole = checkpoint_as_it_is(bytes);
  const std::string whole = sealed(bytes);
  return whole == bytes ? is_whole : checkpoint_as_it_is(whole);
}

bool start(std::string_view bytes) {
  const bake::Identity identity{{"scene", "a"}};
  const bool is_whole = bake::read_start(bytes, identity).has_value();
  const std::string whole = sealed(bytes, start_head_bytes);
  return whole == bytes ? is_whole : bake::read_start(whole, identity).has_value();
}

bool manifest(std::string_view bytes) {
  static const OneFile file("manifest.json");
  file.write(bytes);
  const auto is_manifest = [] { return is_taken<BakeError>([] { bake::manifest_of(file.folder()); }); };
  const bool is_whole = is_manifest();
  const scene::Json object = scene::Json::parse(base::shallow_json(bytes), nullptr, false);
  if (!object.is_object() || !bake::is_damaged(object)) return is_whole;
  file.write(bake::sealed_text(object));
  return is_manifest();
}

}  // namespace fascicle::fuzz
