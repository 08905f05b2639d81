// The colour and the holes of a triangle with a material.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "host/render/looks.h"
#include "host/render/scan.h"
#include "host/render/shape.h"

namespace fascicle::render {

// The surface of a triangle: red, green, blue in linear light, and alpha.
class Cover {
 public:
  // `share`: of the triangle, that `edges` enclose.
  Cover(const Shape& shape, std::uint32_t triangle, const Edges& edges, float share)
      : shape_(shape), corners_(shape.triangles[triangle]) {
    if (shape.looks == nullptr) return;
    paint_ = &shape.looks->paints[shape.paints[triangle]];
    if (paint_->texture < 0 || shape.uvs.empty()) return;
    texture_ = &shape.looks->textures[static_cast<std::size_t>(paint_->texture)];
    const Vector2f u = shape.uvs[corners_[1]] - shape.uvs[corners_[0]];
    const Vector2f v = shape.uvs[corners_[2]] - shape.uvs[corners_[0]];
    const float texels = share * std::fabs(u.x() * v.y() - u.y() * v.x()) *
                         static_cast<float>(texture_->width()) * static_cast<float>(texture_->height());
    // Both are twice the area.
    level_ = texture_->level_for(texels / (static_cast<float>(edges.area) / (grid * grid)));
  }

  bool has_holes() const { return paint_ != nullptr && paint_->cutoff > 0.0f; }
  bool is_hole(const Vector3f& weights) const { return has_holes() && at(weights).w() < paint_->cutoff; }
  Vector4f at(const Vector3f& weights) const {
    if (paint_ == nullptr) return Vector4f::Ones();
    Vector4f colour(paint_->colour.x(), paint_->colour.y(), paint_->colour.z(), paint_->alpha);
    if (texture_ != nullptr)
      colour = colour.cwiseProduct(texture_->at(weights[0] * shape_.uvs[corners_[0]] +
                                                    weights[1] * shape_.uvs[corners_[1]] +
                                                    weights[2] * shape_.uvs[corners_[2]],
                                                level_));
    return colour;
  }

 private:
  const Shape& shape_;
  const std::array<std::uint32_t, 3>& corners_;
  const Paint* paint_ = nullptr;
  const Texture* texture_ = nullptr;
  unsigned level_ = 0;
};

}  // namespace fascicle::render
