#include "host/scene/material.h"

#include <algorithm>

namespace fascicle::scene {

namespace {

// Densities: ICRP Publication 23, Reference Man (1975): adipose tissue 920, skeletal muscle 1040, skin 1100.
const std::vector<Material>& materials() {
  static const std::vector<Material> all{
      // Samani, Zubovits, Plewes, Phys. Med. Biol. 52 (2007): normal fat of the breast, 3.25 +- 0.91 kPa.
      {"fat", 3250.0, 920.0},
      // Levinson, Shinagawa, Sato, J. Biomech. 28 (1995): quadriceps in vivo, along the fibres, at 30 Hz: 7
      // +- 3 kPa unloaded, 57 +- 37 kPa with 15 kg.
      {"relaxed-muscle", 7000.0, 1040.0},
      {"flexed-muscle", 57000.0, 1040.0},
      // Pailler-Mattei, Bec, Zahouani, Med. Eng. Phys. 30 (2008): dermis of the forearm, indented, 35 kPa.
      {"skin", 35000.0, 1100.0}};
  return all;
}

}  // namespace

const Material* find_material(std::string_view name) {
  const auto& all = materials();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Material& m) { return m.name == name; });
  return found == all.end() ? nullptr : &*found;
}

std::vector<std::string> material_names() {
  std::vector<std::string> names;
  for (const Material& material : materials()) names.push_back(material.name);
  return names;
}

}  // namespace fascicle::scene
