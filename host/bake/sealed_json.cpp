#include "host/bake/sealed_json.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "host/base/text.h"

namespace fascicle::bake {

using scene::Json;

namespace {

constexpr const char* checksum_key = "checksum";

std::string checksum_of(const Json& object) {
  const std::string text = scene::dump(object);
  return base::hash_text(XXH3_64bits(text.data(), text.size()));
}

}  // namespace

std::string sealed_text(Json object, int indent) {
  object.erase(checksum_key);
  object[checksum_key] = checksum_of(object);
  return scene::dump(object, indent);
}

bool is_damaged(const Json& object) {
  const auto checksum = object.find(checksum_key);
  if (checksum == object.end()) return object.value("version", Json()) == sealed_json_version;
  Json rest = object;
  rest.erase(checksum_key);
  return *checksum != checksum_of(rest);
}

}  // namespace fascicle::bake
