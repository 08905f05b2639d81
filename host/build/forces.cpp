#include "host/build/forces.h"

#include "host/build/mass.h"
#include "host/build/message.h"

namespace fascicle::build {

namespace {

// One force's coefficient for each vertex, 0 for vertices that take none.
std::vector<double> coefficients(const scene::Scene& scene, const scene::Force& force, WhereTest& test,
                                 const std::vector<double>& area, const std::vector<double>& mass,
                                 const std::vector<char>& kinematic) {
  const std::size_t n = mass.size();
  std::vector<double> result(n, 0.0);
  if (force.kind == scene::ForceKind::wind) {
    for (std::size_t i = 0; i < n; ++i)
      if (!kinematic[i]) result[i] = area[i] / mass[i];
    return result;
  }
  const std::string key = "force." + force.name;
  const std::vector<char> inside = test.contains(force.where, key, scene.source);
  double total = 0.0;
  for (std::size_t i = 0; i < n; ++i)
    if (inside[i] && !kinematic[i]) total += mass[i];
  if (!(total > 0.0))
    fail(scene.source,
         key + ": acts on no vertex that is free to move; widen its shapes, or move them off the pins");
  for (std::size_t i = 0; i < n; ++i)
    if (inside[i] && !kinematic[i]) result[i] = 1.0 / total;
  return result;
}

}  // namespace

ForceTable make_forces(const scene::Scene& scene, const Body& body, WhereTest& test,
                       const std::vector<std::array<std::uint32_t, 3>>& boundary,
                       const std::vector<double>& mass, const std::vector<char>& kinematic) {
  ForceTable table;
  if (scene.forces.empty()) return table;
  const std::vector<double> area = lumped_areas(body.mesh, boundary);
  std::vector<std::vector<double>> by_force;
  for (const scene::Force& force : scene.forces)
    by_force.push_back(coefficients(scene, force, test, area, mass, kinematic));

  table.offset.push_back(0);
  for (std::size_t i = 0; i < mass.size(); ++i) {
    for (std::uint32_t f = 0; f < by_force.size(); ++f)
      if (by_force[f][i] > 0.0) {
        table.index.push_back(f);
        table.coefficient.push_back(static_cast<float>(by_force[f][i]));
      }
    table.offset.push_back(static_cast<std::uint32_t>(table.index.size()));
  }
  return table;
}

}  // namespace fascicle::build
