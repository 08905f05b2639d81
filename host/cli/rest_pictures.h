// The rest shape before and after it became a body: the original skin, the tetrahedra, and a section of
// these.
#pragma once

#include <cstdint>
#include <vector>

#include "host/model/model.h"
#include "host/render/annotate.h"
#include "host/render/image.h"
#include "host/render/looks.h"

namespace fascicle::cli {

// Counts of a triangle mesh after merging coincident vertices.
struct ShellCounts {
  std::uint64_t vertices = 0, triangles = 0;
  std::uint64_t open_edges = 0;  // edges of a single triangle
  std::uint64_t parts = 0;       // connected components
};

struct RestPictures {
  ShellCounts skin, body;            // the render mesh; the surface of the tetrahedra
  render::Image before, after, cut;  // the skin's open edges are red
  render::Legend layers;             // of `cut`
};

// Needs a render mesh. `looks`: materials of the skin, or null. `height`: pixels.
RestPictures draw_rest(const model::Model& model, const render::Looks* looks, unsigned height,
                       unsigned threads);

// For the render mesh at rest, or the surface of the tetrahedra: 3 indices per triangle, 3 floats per vertex.
ShellCounts count_shell(const std::vector<float>& positions, const std::vector<std::uint32_t>& triangles);

}  // namespace fascicle::cli
