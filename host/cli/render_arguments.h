// Arguments of `fascicle render`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host/cli/command.h"
#include "host/render/body_shapes.h"

namespace fascicle::cli {

struct RenderArguments {
  SceneArguments input;
  std::string output;
  std::optional<std::uint64_t> frame, worst;
  render::Mode mode = render::Mode::shaded;
  bool tetrahedra = false, plain = false, compare = false;
  std::string clip, size, sheet, view = "three-quarter";
  double turn = 0.0, zoom = 1.0;
  std::optional<double> tilt, lag_scale;
  std::optional<bool> follow;  // nullopt: if the body would be too small otherwise
  bool overwrite = false;
  unsigned threads = 0;
};

}  // namespace fascicle::cli
