// From a model and where its vertices are to what is drawn.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/model/model.h"
#include "host/render/annotate.h"
#include "host/render/looks.h"
#include "host/render/model_surface.h"
#include "host/render/shape.h"

namespace fascicle::render {

// shaded: skin; layers: a colour for each layer; fibres: short lines along d_r; lag: distance to the skinned
// pose; contact: how deep flesh lies in other flesh.
enum class Mode { shaded, layers, fibres, lag, contact };

struct DrawingOptions {
  Mode mode = Mode::shaded;
  bool tetrahedra = false;  // instead of the render mesh; fibres and a clip draw them in any case
  std::optional<Clip> clip;
  double lag_scale = 0.0;  // m, of lag or depth, that take the scale's last colour
  // Of the render mesh, for Mode::shaded without tetrahedra; none: skin. Must outlive the drawing.
  const Looks* looks = nullptr;
};

// Everything about a drawing that stays from frame to frame. The model must outlive it.
class BodyDrawing {
 public:
  // Throws std::invalid_argument, for people to read, where nothing is left to draw.
  BodyDrawing(const model::Model& model, const DrawingOptions& options);

  // `positions`: of the model's vertices, 3 a vertex, m. `lag`: m, one a vertex, for Mode::lag, and
  // for Mode::contact the depth, below 0 where there is none. `eye`: the camera's place; fibres and marks are
  // laid out to face it. `placed`: of the render mesh's vertices, 3 a vertex,
  // m, where it is not to stand as the model's vertices carry it.
  std::vector<Shape> shapes(std::span<const float> positions, std::span<const float> lag, const Vector3f& eye,
                            std::span<const float> placed = {}) const;

  // What the colours mean; empty for Mode::shaded.
  Legend legend() const;
  bool draws_tetrahedra() const { return draws_tetrahedra_; }
  // Whether a fibre runs through any vertex that is drawn.
  bool shows_fibres() const;

 private:
  Shape surface(std::span<const float> positions, std::span<const float> lag,
                std::span<const float> placed) const;
  void paint(Shape& shape) const;
  Shape faces(std::span<const float> positions, std::span<const float> lag) const;
  Shape contact_marks(std::span<const float> positions, std::span<const float> depths,
                      const Vector3f& eye) const;
  Shape fibre_lines(std::span<const float> positions, const Vector3f& eye) const;
  Vector3f vertex_colour(std::uint32_t vertex, std::span<const float> lag) const;
  Vector3f lag_colour(float lag) const;

  const model::Model& model_;
  DrawingOptions options_;
  bool draws_tetrahedra_ = false;
  std::vector<OuterFace> faces_;  // of the tetrahedra that are kept
  CreasedSurface creased_;
  std::vector<std::uint32_t> surface_layer_;
  std::vector<std::uint32_t> fibre_vertices_;                 // on the faces, with a fibre
  std::vector<std::vector<std::uint32_t>> fibre_tetrahedra_;  // around each of them
  double edge_ = 0.0;                                         // mean length of the faces' sides at rest, m
};

}  // namespace fascicle::render
