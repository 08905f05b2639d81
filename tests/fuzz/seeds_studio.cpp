#include <memory>
#include <string>
#include <vector>

#include "host/studio/session_file.h"
#include "tests/fuzz/seeds.h"

namespace fascicle::fuzz {

void add_studio_seeds(std::vector<Seed>& seeds) {
  const std::vector<std::string> messages{
      R"({"type":"set","id":1,"changes":{"layers.fat.beta":0.5,"scene.gravity":[0,-9,0]},"label":"x","gesture":3})",
      R"({"type":"hand","action":"grab","vertex":5,"place":[1,2,3],"of":"vertices","radius":0.1})",
      R"({"type":"bake","folder":"mine","formats":["glb","pc2"],"overwrite":true})",
      R"({"type":"paint","attribute":"_FIBER","radius":0.1,"places":[[1,2,3],[4,5,6]],"stroke":7,"mirror":true})",
      R"({"type":"show","blocks":["surface","ghost"]})",
      R"({"type":"seek","frame":12})"};
  for (std::size_t k = 0; k < messages.size(); ++k)
    seeds.push_back({"message", std::to_string(k), messages[k]});
  const std::string bar = "[bar]\nsize = [0.4, 0.1, 0.1]\nvertices = [9, 3, 3]\n";
  studio::SessionRecord record{.source = "man.toml",
                               .base_hash = "0123456789abcdef",
                               .steps = {{"", bar}, {"faster", bar + "[scene]\nfps = 30\nend = 1.0 # s\n"}},
                               .at = 1};
  const studio::Paints paints{
      {"character.paint", std::make_shared<const std::string>("{\"fascicle_paint\": 1}")}};
  record.steps.push_back({"paint", bar + "[layers]\nfat = { alpha = 0.5 }\nskin.beta = 0.5\n", paints});
  seeds.push_back({"session", "three", studio::session_text(record)});
}

}  // namespace fascicle::fuzz
