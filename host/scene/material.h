// Tissues by name, for the implicit integrator. Published moduli vary severalfold with the person, the site
// and the method of measurement; each value here is one published mean, cited next to it.
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

// Null if there is no such material.
const Material* find_material(std::string_view name);
std::vector<std::string> material_names();

}  // namespace fascicle::scene
