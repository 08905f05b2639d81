#include "host/scene/builtin_scenes.h"

#include "host/scene/parse_toml.h"
#include "host/scene/scene.h"

namespace fascicle::scene {

const std::vector<BuiltinScene>& builtin_scenes() {
  static const std::vector<BuiltinScene> scenes = [] {
    std::vector<BuiltinScene> list;
    for (const EmbeddedScene& scene : embedded_scenes()) {
      const toml::table root = parse_toml(scene.text, scene.name);
      list.push_back({std::string(scene.name), root["scene"]["description"].value_or(std::string{}),
                      std::string(scene.text)});
    }
    return list;
  }();
  return scenes;
}

}  // namespace fascicle::scene
