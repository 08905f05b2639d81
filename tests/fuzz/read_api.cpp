#include <cstdint>
#include <cstring>

#include "host/base/content_hash.h"
#include "host/base/errors.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/seal.h"
#include "tests/fuzz/state_owner.h"
#include "tests/fuzz/taken.h"

namespace fascicle::fuzz {
namespace {

// Before the checkpoint (host/api/saved_state.h): magic bytes, hash, and a head that counts the pose's
// numbers.
constexpr std::size_t magic_bytes = 8, hash_digits = 32, hashed_begin = magic_bytes + hash_digits;
constexpr std::size_t head_bytes = 32, pose_numbers_at = hashed_begin + 16;

// With correct checksums of the checkpoint and the whole.
std::string sealed_state(std::string_view bytes) {
  std::string whole(bytes);
  if (whole.size() < hashed_begin + head_bytes) return whole;
  std::uint64_t pose_numbers = 0;
  std::memcpy(&pose_numbers, whole.data() + pose_numbers_at, sizeof pose_numbers);
  const std::size_t after_head = whole.size() - hashed_begin - head_bytes;
  if (pose_numbers <= after_head / sizeof(double))
    whole = sealed(whole, hashed_begin + head_bytes + pose_numbers * sizeof(double));
  base::ContentHash hash;
  hash.add(std::string_view(whole).substr(hashed_begin));
  whole.replace(magic_bytes, hash_digits, hash.text());
  return whole;
}

bool state_as_it_is(std::string_view bytes) {
  static const fascicle::model::Model model = model_of_two();
  return is_taken<base::BakeError>([&] {
    (void)api::parse_saved_state(bytes, {model, true, identity_of_two()});
  });
}

}  // namespace

bool state(std::string_view bytes) {
  const bool is_whole = state_as_it_is(bytes);
  const std::string whole = sealed_state(bytes);
  return whole == bytes ? is_whole : state_as_it_is(whole);
}

}  // namespace fascicle::fuzz
