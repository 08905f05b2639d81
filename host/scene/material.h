// Tissues by name, for the implicit integrator. Moduli scatter by a factor of several between people, places
// and ways to measure; each value here is one published mean, named beside it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fascicle::scene {

struct Material {
  std::string name;
  double youngs_modulus;  // Pa
  double density;         // kg/m^3
};

// Null if there is none of that name.
const Material* find_material(std::string_view name);
std::vector<std::string> material_names();

}  // namespace fascicle::scene
