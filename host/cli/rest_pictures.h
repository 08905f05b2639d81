// The rest shape before and after it became a body: the skin as it came, the tetrahedra, and these cut open.
#pragma once

#include <cstdint>
#include <vector>

#include "host/model/model.h"
#include "host/render/annotate.h"
#include "host/render/image.h"
#include "host/render/looks.h"

namespace fascicle::cli {

// Of a mesh of triangles whose equal places are one.
struct ShellCounts {
  std::uint64_t vertices = 0, triangles = 0;
  std::uint64_t open_edges = 0;  // sides of one triangle alone
  std::uint64_t parts = 0;       // that no triangle connects
};

struct RestPictures {
  ShellCounts skin, body;            // the render mesh; the surface of the tetrahedra
  render::Image before, after, cut;  // the skin's open edges are red
  render::Legend layers;             // of `cut`
};

// Needs a render mesh. `looks`: of the skin, or null. `height`: pixels.
RestPictures draw_rest(const model::Model& model, const render::Looks* looks, unsigned height,
                       unsigned threads);

// The render mesh at rest, or the surface of the tetrahedra: three numbers a triangle, and 3 floats a vertex.
ShellCounts count_shell(const std::vector<float>& positions, const std::vector<std::uint32_t>& triangles);

}  // namespace fascicle::cli
