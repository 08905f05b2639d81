#include "host/rig/paint.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "host/base/content_hash.h"
#include "host/base/errors.h"

namespace fascicle::rig {

std::span<const PaintKind> paint_kinds() {
  static constexpr std::array<PaintKind, 4> kinds{
      PaintKind{.name = "_RIGID", .most = 1.0}, PaintKind{.name = "_LAYER", .most = 255.0, .is_whole = true},
      // By default flesh is as stiff as its layer.
      PaintKind{.name = "_STIFFNESS", .most = 10.0, .elsewhere = 1.0},
      PaintKind{.name = "_FIBER", .width = 3, .least = -1.0, .most = 1.0, .is_direction = true}};
  return kinds;
}

const PaintKind* find_paint_kind(std::string_view name) {
  for (const PaintKind& kind : paint_kinds())
    if (name == kind.name) return &kind;
  return nullptr;
}

double value_elsewhere(std::string_view attribute) {
  const PaintKind* kind = find_paint_kind(attribute);
  return kind != nullptr ? kind->elsewhere : 0.0;
}

std::string surface_hash(const mesh::SurfaceMesh& surface) {
  base::ContentHash hash;
  hash.add(std::uint64_t{surface.vertices.size()});
  for (const Vector3d& p : surface.vertices)
    for (int axis = 0; axis < 3; ++axis) hash.add(p[axis]);
  hash.add(std::uint64_t{surface.triangles.size()});
  for (const auto& t : surface.triangles)
    for (const std::uint32_t corner : t) hash.add(corner);
  return hash.text();
}

void widen(PaintedAttribute& attribute, std::uint32_t width) {
  const std::uint32_t before = attribute.width;
  if (width <= before) return;
  std::vector<double> values;
  values.reserve(attribute.values.size() / before * width);
  for (std::size_t i = 0; i < attribute.values.size(); ++i) {
    values.push_back(attribute.values[i]);
    if ((i + 1) % before != 0) continue;
    for (std::uint32_t c = before; c < width; ++c)
      values.push_back(c == 3 && attribute.name.starts_with("COLOR_") ? 1.0 : 0.0);
  }
  attribute.width = width;
  attribute.values = std::move(values);
}

void lay_over(const Paint& paint, Character& character) {
  for (const PaintedVertices& of_paint : paint.attributes) {
    const PaintKind& kind = *find_paint_kind(of_paint.name);
    auto found = std::find_if(character.painted.begin(), character.painted.end(),
                              [&](const PaintedAttribute& a) { return a.name == of_paint.name; });
    if (found == character.painted.end())
      found = character.painted.insert(
          character.painted.end(),
          PaintedAttribute{
              of_paint.name, kind.width,
              std::vector<double>(kind.width * character.surface.vertices.size(), kind.elsewhere)});
    if (found->width != kind.width)
      throw base::SceneError(of_paint.name + " has " + std::to_string(found->width) +
                             " numbers per vertex in the character's file, but " +
                             std::to_string(kind.width) + " in the paint; rename one of them");
    for (std::size_t k = 0; k < of_paint.vertex.size(); ++k)
      for (std::size_t c = 0; c < kind.width; ++c)
        found->values.at(kind.width * of_paint.vertex[k] + c) = double{of_paint.value[kind.width * k + c]};
  }
}

}  // namespace fascicle::rig
