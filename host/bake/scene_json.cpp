#include "host/bake/scene_json.h"

namespace fascicle::bake {

std::string dump(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace fascicle::bake
