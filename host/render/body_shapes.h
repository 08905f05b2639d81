// From a model and its vertex positions to shapes to draw.
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

// shaded: skin; layers: a colour per layer; fibres: short lines along d_r; lag: distance to the skinned pose;
// contact: how deep flesh lies in other flesh.
enum class Mode { shaded, layers, fibres, lag, contact };

struct DrawingOptions {
  Mode mode = Mode::shaded;
  bool tetrahedra = false;  // instead of the render mesh; fibres and a clip always draw them
  std::optional<Clip> clip;
  double lag_scale = 0.0;  // m; the lag or depth that gets the last colour of the scale
  // For the render mesh in Mode::shaded without tetrahedra; none: skin. Must outlive the drawing.
  const Looks* looks = nullptr;
};

// Everything about a drawing that does not change from frame to frame. The model must outlive it.
class BodyDrawing {
 public:
  // Throws std::invalid_argument, with a message for users, if nothing is left to draw.
  BodyDrawing(const model::Model& model, const DrawingOptions& options);

  // `positions`: of the model's vertices, 3 per vertex, m. `lag`: m, one per vertex, for Mode::lag; for
  // Mode::contact the depth, negative where there is none. `eye`: the camera's position; fibres and marks
  // face it. `placed`: of the render mesh's vertices, 3 per vertex, m, if they do not follow the model's
  // vertices.
  std::vector<Shape> shapes(std::span<const float> positions, std::span<const float> lag, const Vector3f& eye,
                            std::span<const float> placed = {}) const;

  // What the colours mean; empty for Mode::shaded.
  Legend legend() const;
  bool draws_tetrahedra() const { return draws_tetrahedra_; }
  // Whether any drawn vertex has a fibre.
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
  std::vector<char> is_beside_;  // per vertex of creased_: of the surroundings
  std::vector<std::uint32_t> surface_layer_;
  std::vector<std::uint32_t> fibre_vertices_;                 // vertices on the faces that have a fibre
  std::vector<std::vector<std::uint32_t>> fibre_tetrahedra_;  // around each of those vertices
  double edge_ = 0.0;                                         // mean edge length of the faces at rest, m
};

}  // namespace fascicle::render
