// What assimp does not pass on, read from the file's bytes, which may be of any kind.
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "host/convert/character.h"

namespace fascicle::convert {
namespace {

// The longest property of interest. The rest of the file is not searched at each name, which may be there a
// million times.
constexpr std::size_t longest = 200;

// `at`: after the name of an FBX property that is a time. 0 if there is none.
std::int64_t ticks_at(std::string_view bytes, std::size_t at) {
  bytes = bytes.substr(0, at + longest);
  std::int64_t ticks = 0;
  if (at < bytes.size() && bytes[at] == '"') {  // text: "LocalStop", "KTime", "Time", "",46186158000
    for (int comma = 0; comma < 4 && at != bytes.npos; ++comma) at = bytes.find(',', at + 1);
    if (at != bytes.npos) at = bytes.find_first_not_of(" \t\r\n", at + 1);
    if (at == bytes.npos) return 0;
    std::from_chars(bytes.data() + at, bytes.data() + bytes.size(), ticks);
    return ticks;
  }
  // Binary: three texts, each with its length, and the number.
  for (int text = 0; text < 3; ++text) {
    std::uint32_t length = 0;
    if (at + 5 > bytes.size() || bytes[at] != 'S') return 0;
    std::memcpy(&length, bytes.data() + at + 1, sizeof length);
    at += 5 + std::size_t{length};
  }
  if (at + 9 > bytes.size() || bytes[at] != 'L') return 0;
  std::memcpy(&ticks, bytes.data() + at + 1, sizeof ticks);
  return ticks;
}

bool states_time(const std::string& bytes, const std::string& name) {
  for (std::size_t at = bytes.find(name); at != std::string::npos; at = bytes.find(name, at + name.size()))
    if (ticks_at(bytes, at + name.size()) != 0) return true;
  return false;
}

}  // namespace

Source source_of(const std::string& bytes, bool is_fbx) {
  Source source;
  source.is_fbx = is_fbx;
  source.has_spans = is_fbx && (states_time(bytes, "LocalStart") || states_time(bytes, "LocalStop"));
  const std::string clip = "<animation_clip";
  source.has_several_clips = !is_fbx && bytes.find(clip) != bytes.rfind(clip);
  return source;
}

}  // namespace fascicle::convert
