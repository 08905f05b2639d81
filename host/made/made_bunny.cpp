#include "host/made/made_bunny.h"

#include "host/base/errors.h"
#include "host/made/made_shape.h"

namespace fascicle::made {

namespace {

constexpr double bunny_spacing = 0.011;  // m

Sculpture bunny_sculpture() {
  Sculpture bunny;
  bunny.floor = 0.0;
  const auto cone = [&](double blend, Vector3d from, double from_radius, Vector3d to, double to_radius) {
    bunny.parts.push_back({from, to, from_radius, to_radius, 0, blend});
  };
  const auto pair = [&](double blend, Vector3d from, double from_radius, Vector3d to, double to_radius) {
    cone(blend, from, from_radius, to, to_radius);
    from.x() = -from.x();
    to.x() = -to.x();
    cone(blend, from, from_radius, to, to_radius);
  };
  cone(0.0, {0.0, 0.075, -0.03}, 0.078, {0.0, 0.115, 0.025}, 0.06);       // body
  cone(0.03, {0.0, 0.185, 0.055}, 0.05, {0.0, 0.175, 0.085}, 0.034);      // head
  cone(0.015, {0.0, 0.06, -0.115}, 0.022, {0.0, 0.064, -0.12}, 0.022);    // tail
  pair(0.02, {0.02, 0.225, 0.045}, 0.016, {0.042, 0.32, 0.02}, 0.018);    // ears
  pair(0.025, {0.055, 0.05, -0.02}, 0.045, {0.06, 0.03, 0.03}, 0.03);     // thighs
  pair(0.015, {0.055, 0.012, 0.0}, 0.019, {0.06, 0.012, 0.065}, 0.018);   // hind feet
  pair(0.015, {0.025, 0.09, 0.06}, 0.021, {0.024, 0.014, 0.075}, 0.017);  // forelegs
  return bunny;
}

}  // namespace

std::vector<std::string> made_surface_names() {
  return {"bunny"};
}

mesh::SurfaceMesh make_surface(const std::string& name) {
  if (name == "bunny") return polygonise(bunny_sculpture(), bunny_spacing);
  throw base::SceneError("there is no surface `" + name + "` made in code");
}

}  // namespace fascicle::made
