#include "host/render/light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "host/base/parallel.h"
#include "host/render/cover.h"
#include "host/render/scan.h"

namespace fascicle::render {

namespace {

constexpr float nothing = -std::numeric_limits<float>::infinity();

struct LampPlan {
  Vector3f towards, colour;
  bool shines;
  unsigned map_size;
};

Vector3f any_perpendicular(const Vector3f& v) {
  return v.cross(std::fabs(v.y()) < 0.9f ? Vector3f::UnitY() : Vector3f::UnitX()).normalized();
}

// `count` directions spread evenly by area over the cap of `angle` degrees around `axis`, on a sunflower
// spiral.
std::vector<Vector3f> cap_directions(const Vector3f& axis, double angle, unsigned count) {
  const Vector3f u = any_perpendicular(axis), v = axis.cross(u);
  const double lowest = std::cos(angle * std::numbers::pi / 180.0);
  const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0));
  std::vector<Vector3f> directions;
  for (unsigned k = 0; k < count; ++k) {
    const double z = 1.0 - (1.0 - lowest) * (k + 0.5) / count;
    const double r = std::sqrt(1.0 - z * z);
    directions.push_back(axis * static_cast<float>(z) + u * static_cast<float>(r * std::cos(turn * k)) +
                         v * static_cast<float>(r * std::sin(turn * k)));
  }
  return directions;
}

// right, up, towards the camera; only the camera's azimuth counts, not its elevation.
std::vector<LampPlan> plan_lamps(const Camera& camera) {
  Vector3f front = camera.axes.row(2).cast<float>();
  front.y() = 0.0f;
  front = front.norm() > 1e-3f ? Vector3f(front.normalized()) : Vector3f(Vector3f::UnitZ());
  const Vector3f up = Vector3f::UnitY(), right = up.cross(front);
  std::vector<LampPlan> plan;
  const auto add = [&](const Vector3f& axis, double angle, unsigned count, const Vector3f& colour,
                       bool shines, unsigned map_size) {
    for (const Vector3f& towards : cap_directions(axis.normalized(), angle, count))
      plan.push_back({towards, colour / static_cast<float>(count), shines, map_size});
  };
  add(-0.75f * right + 0.95f * up + 0.75f * front, 9.0, 16, Vector3f::Constant(0.66f), true, 1024);
  add(0.95f * right + 0.25f * up + 0.55f * front, 16.0, 6, Vector3f::Constant(0.15f), false, 512);
  add(0.55f * right + 0.55f * up - 0.85f * front, 8.0, 6, Vector3f::Constant(0.30f), true, 512);
  for (const Vector3f& towards : cap_directions(up, 72.0, 64))  // lower lamps cast long streaks
    plan.push_back({towards, Vector3f::Constant(0.42f / (64.0f * 0.65f)), false, 384});
  return plan;
}

}  // namespace

ShadowMap::ShadowMap(std::span<const Shape> shapes, const Vector3f& towards, const Vector3f& center,
                     float radius, unsigned size)
    : right_(any_perpendicular(towards)),
      up_(towards.cross(right_)),
      towards_(towards),
      center_(center),
      size_(static_cast<int>(size)),
      height_(std::size_t{size} * size, nothing) {
  radius = std::max(radius, 1e-6f);
  scale_ = static_cast<float>(size) / (2.0f * radius);
  texel_ = 1.0f / scale_;
  const float half = 0.5f * static_cast<float>(size);
  std::vector<std::optional<GridPoint>> place;
  std::vector<float> height;
  for (const Shape& shape : shapes) {
    if (!shape.casts_shadow) continue;
    place.clear();
    height.clear();
    for (const Vector3f& p : shape.positions) {
      const Vector3f d = p - center_;
      place.push_back(to_grid(half + scale_ * d.dot(right_), half + scale_ * d.dot(up_)));
      height.push_back(d.dot(towards_));
    }
    for (std::uint32_t number = 0; number < shape.triangles.size(); ++number) {
      const auto& t = shape.triangles[number];
      if (!place[t[0]] || !place[t[1]] || !place[t[2]]) continue;
      const std::array<GridPoint, 3> corners{*place[t[0]], *place[t[1]], *place[t[2]]};
      // The centre of texel k is at k + 1/2. Most triangles are smaller than a texel and contain no centre.
      const auto [x0, x1] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
      const auto [y0, y1] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
      const std::int64_t last = size_ - 1;
      const std::int64_t first_x = std::max<std::int64_t>(0, (x0 + grid / 2 - 1) >> grid_bits);
      const std::int64_t first_y = std::max<std::int64_t>(0, (y0 + grid / 2 - 1) >> grid_bits);
      const std::int64_t last_x = std::min(last, (x1 - grid / 2) >> grid_bits);
      const std::int64_t last_y = std::min(last, (y1 - grid / 2) >> grid_bits);
      if (first_x > last_x || first_y > last_y) continue;
      const auto edges = edges_of(corners);
      if (!edges) continue;
      const float scale = 1.0f / static_cast<float>(edges->area);
      const Cover cover(shape, number, *edges, 1.0f);
      for (std::int64_t y = first_y; y <= last_y; ++y)
        for (std::int64_t x = first_x; x <= last_x; ++x) {
          std::array<std::int64_t, 3> e;
          for (std::size_t k = 0; k < 3; ++k)
            e[k] = edges->value(k, x * grid + grid / 2, y * grid + grid / 2);
          if (!edges->covers(e[0], e[1], e[2])) continue;
          const std::array<float, 3> share{static_cast<float>(e[0]), static_cast<float>(e[1]),
                                           static_cast<float>(e[2])};
          if (cover.has_holes() && cover.is_hole(scale * Vector3f(share[0], share[1], share[2]))) continue;
          const float h =
              (share[0] * height[t[0]] + share[1] * height[t[1]] + share[2] * height[t[2]]) * scale;
          float& nearest = height_[static_cast<std::size_t>(y * size_ + x)];
          nearest = std::max(nearest, h);
        }
    }
  }
  find_blocks();
}

void ShadowMap::find_blocks() {
  constexpr int side = 1 << block_bits;
  const int in_row = (size_ + side - 1) / side;
  blocks_in_row_ = static_cast<std::size_t>(in_row);
  blocks_.assign(blocks_in_row_ * blocks_in_row_, {-nothing, nothing});
  for (int y = 0; y < size_; ++y) {
    const float* row = &height_[static_cast<std::size_t>(y) * static_cast<std::size_t>(size_)];
    const std::size_t first = static_cast<std::size_t>(y / side) * blocks_in_row_;
    for (int b = 0; b < in_row; ++b) {
      const auto ends = std::minmax_element(row + b * side, row + std::min(size_, (b + 1) * side + 1));
      const auto widen = [&](Heights& block) {
        block = {std::min(block.least, *ends.first), std::max(block.most, *ends.second)};
      };
      widen(blocks_[first + static_cast<std::size_t>(b)]);
      if (y % side == 0 && y > 0) widen(blocks_[first - blocks_in_row_ + static_cast<std::size_t>(b)]);
    }
  }
}

ShadowMap::Place ShadowMap::place_of(const Vector3f& point, const Vector3f& normal) const {
  // Offset by a texel and a half, plus the rise of a slope over a texel's width; otherwise a surface would
  // shadow itself.
  const Vector3f d = point + normal * (1.5f * texel_) - center_;
  const float half = 0.5f * static_cast<float>(size_);
  return {half + scale_ * d.dot(right_) - 0.5f, half + scale_ * d.dot(up_) - 0.5f,
          d.dot(towards_) + 1.0f * texel_};
}

float ShadowMap::visibility(const Vector3f& point, const Vector3f& normal) const {
  const Place place = place_of(point, normal);
  const float x = place.x, y = place.y, height = place.height;
  const float limit = static_cast<float>(size_ - 2);
  if (!(x >= 0.0f && y >= 0.0f && x <= limit && y <= limit)) return 1.0f;
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const float u = x - static_cast<float>(column), v = y - static_cast<float>(row);
  const Heights& block = block_of(column, row);
  if (height < block.least) return 0.0f;
  if (height >= block.most) return 1.0f;
  const auto lit = [&](int dx, int dy) { return is_lit(column + dx, row + dy, height) ? 1.0f : 0.0f; };
  return (1.0f - v) * ((1.0f - u) * lit(0, 0) + u * lit(1, 0)) + v * ((1.0f - u) * lit(0, 1) + u * lit(1, 1));
}

ShadowMap::Seen ShadowMap::seen_of_patch(const std::array<Vector3f, 4>& corners,
                                         const Vector3f& normal) const {
  // More than the rounding of places, which is 1e-7 of the distance in texels.
  constexpr float slack = 0.25f;  // texels
  Eigen::AlignedBox3f box;
  for (const Vector3f& corner : corners) {
    if (!corner.allFinite()) return Seen::unknown;
    const Place place = place_of(corner, normal);
    box.extend(Vector3f(place.x, place.y, place.height));
  }
  const Vector3f least = box.min() - Vector3f(slack, slack, slack * texel_);
  const Vector3f most = box.max() + Vector3f(slack, slack, slack * texel_);
  const float limit = static_cast<float>(size_ - 2);
  if (!least.allFinite() || !most.allFinite()) return Seen::unknown;
  if (most.x() < 0.0f || most.y() < 0.0f || least.x() > limit || least.y() > limit) return Seen::whole;
  const auto texel = [&](float at) { return static_cast<int>(std::clamp(at, 0.0f, limit)); };
  float lowest = -nothing, highest = nothing;
  for (int y = texel(least.y()) >> block_bits; y <= texel(most.y()) >> block_bits; ++y)
    for (int x = texel(least.x()) >> block_bits; x <= texel(most.x()) >> block_bits; ++x) {
      const Heights& block = block_of(x << block_bits, y << block_bits);
      lowest = std::min(lowest, block.least);
      highest = std::max(highest, block.most);
      // No further block can change the answer: a patch close to the camera may cover the map.
      if (lowest <= most.z() && highest > least.z()) return Seen::unknown;
    }
  if (least.z() >= highest) return Seen::whole;
  const bool is_inside = least.x() >= 0.0f && least.y() >= 0.0f && most.x() <= limit && most.y() <= limit;
  return is_inside && most.z() < lowest ? Seen::none : Seen::unknown;
}

std::vector<Lamp> studio_lamps(std::span<const Shape> shapes, const Camera& camera, unsigned threads) {
  Eigen::AlignedBox3f box;
  const auto counts = [](const Shape& shape) { return shape.casts_shadow && shape.widens_shadows; };
  const auto each = [&](auto visit) {
    for (const Shape& shape : shapes)
      for (std::size_t k = 0; counts(shape) && k < shape.positions.size(); ++k)
        if (shape.is_beside.empty() || shape.is_beside[k] == 0) visit(shape.positions[k]);
  };
  each([&](const Vector3f& p) { box.extend(p); });
  const Vector3f center = box.isEmpty() ? Vector3f(Vector3f::Zero()) : Vector3f(box.center());
  // Uses the farthest point, not the box's corner, so that no texels are wasted.
  float radius = 0.0f;
  each([&](const Vector3f& p) { radius = std::max(radius, (p - center).norm()); });
  const std::vector<LampPlan> plan = plan_lamps(camera);
  // A shadow needs no more resolution than the picture.
  const double share = std::clamp(camera.height / 960.0, 0.25, 1.5);
  std::vector<std::optional<ShadowMap>> maps(plan.size());
  base::for_each_in_parallel(plan.size(), base::thread_count(threads), [&](std::size_t k, std::size_t) {
    maps[k].emplace(shapes, plan[k].towards, center, 1.02f * radius,
                    static_cast<unsigned>(share * plan[k].map_size));
  });
  std::vector<Lamp> lamps;
  for (std::size_t k = 0; k < plan.size(); ++k)
    lamps.push_back({plan[k].towards, plan[k].colour, plan[k].shines, std::move(*maps[k])});
  return lamps;
}

Vector3f irradiance(std::span<const Lamp> lamps, const Vector3f& point, const Vector3f& normal) {
  Vector3f sum = Vector3f::Zero();
  for (const Lamp& lamp : lamps)
    if (const float cosine = normal.dot(lamp.towards); cosine > 0.0f)
      sum += lamp.colour * (cosine * lamp.shadow.visibility(point, normal));
  return sum;
}

PatchLight light_of_patch(std::span<const Lamp> lamps, const std::array<Vector3f, 4>& corners,
                          const Vector3f& normal) {
  PatchLight patch{Vector3f::Zero(), {}};
  for (std::uint32_t k = 0; k < lamps.size(); ++k) {
    const float cosine = normal.dot(lamps[k].towards);
    if (cosine <= 0.0f) continue;
    const ShadowMap::Seen seen = lamps[k].shadow.seen_of_patch(corners, normal);
    if (seen == ShadowMap::Seen::whole) patch.whole += lamps[k].colour * cosine;
    if (seen == ShadowMap::Seen::unknown) patch.unknown.push_back(k);
  }
  return patch;
}

Vector3f irradiance(std::span<const Lamp> lamps, const PatchLight& patch, const Vector3f& point,
                    const Vector3f& normal) {
  Vector3f sum = patch.whole;
  for (const std::uint32_t k : patch.unknown)
    sum += lamps[k].colour * (normal.dot(lamps[k].towards) * lamps[k].shadow.visibility(point, normal));
  return sum;
}

Vector3f free_irradiance(std::span<const Lamp> lamps, const Vector3f& normal) {
  Vector3f sum = Vector3f::Zero();
  for (const Lamp& lamp : lamps) sum += lamp.colour * std::max(0.0f, normal.dot(lamp.towards));
  return sum;
}

}  // namespace fascicle::render
