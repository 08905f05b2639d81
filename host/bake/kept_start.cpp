#include "host/bake/kept_start.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "host/bake/checkpoint.h"
#include "host/base/content_hash.h"
#include "host/base/part_file.h"

namespace fascicle::bake {

namespace {

// The summary before the checkpoint. Absent numbers are NaN.
struct Head {
  std::uint64_t preroll_frames, settle_frames, cycles;
  double settled_speed, jump;
};
constexpr double absent = std::bit_cast<double>(std::uint64_t{0x7ff8000000000000});

std::optional<double> present(double value) {
  return value == value ? std::optional<double>(value) : std::nullopt;
}

// Also without options that only formats use: none of them affects a bit of the motion.
Identity without_formats(Identity identity) {
  std::erase_if(identity, [](const auto& entry) { return entry.first.starts_with("--"); });
  return identity;
}

}  // namespace

std::string start_key(const Identity& identity) {
  base::ContentHash hash;
  for (const auto& [name, value] : without_formats(identity)) {
    hash.add(std::string_view(name));
    hash.add(std::string_view(value));
  }
  return hash.text();
}

std::string start_bytes(const drive::LeadIn& start, const Identity& identity) {
  const drive::LeadInSummary& led = start.summary;
  std::string bytes;
  base::append_bytes(bytes, Head{led.preroll_frames, led.settle_frames, led.cycles,
                                 led.settled_speed.value_or(absent), led.jump.value_or(absent)});
  return bytes + checkpoint_text({without_formats(identity), start.state});
}

std::optional<drive::LeadIn> read_start(std::string_view bytes, const Identity& identity) {
  Head head{};
  if (bytes.size() < sizeof head) return std::nullopt;
  std::memcpy(&head, bytes.data(), sizeof head);
  try {
    Checkpoint found = parse_checkpoint(bytes.substr(sizeof head), "the kept start");
    if (found.identity != without_formats(identity)) return std::nullopt;
    drive::LeadIn start;
    start.summary = {.preroll_frames = head.preroll_frames,
                     .settle_frames = head.settle_frames,
                     .settled_speed = present(head.settled_speed),
                     .cycles = head.cycles,
                     .jump = present(head.jump)};
    start.state = std::move(found.state);
    return start;
  } catch (const BakeError&) {
    return std::nullopt;
  }
}

}  // namespace fascicle::bake
