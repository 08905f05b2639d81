// Bands of pixel rows are drawn one by one, with sixteen samples a pixel: first every sample finds its
// nearest triangle, then each triangle visible in a pixel is shaded once, in the middle of its samples. A
// band's result depends only on the shapes, so threads take bands in any order.
#include "host/render/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "host/base/parallel.h"
#include "host/render/colour.h"
#include "host/render/cover.h"
#include "host/render/facets.h"
#include "host/render/light.h"
#include "host/render/scan.h"

namespace fascicle::render {

namespace {

constexpr unsigned patch_columns = 8;  // of a band: the floor's light is found once for all its pixels

// Positions of a pixel's samples, from its corner.
constexpr std::array<GridPoint, 1> center_point{{{grid / 2, grid / 2}}};
// One in each of 16 columns, 16 rows and 4 x 4 squares: vertical and horizontal edges get as many steps as
// slanted ones.
constexpr std::array<GridPoint, 16> spread_points = [] {
  std::array<GridPoint, 16> points{};
  for (std::int64_t a = 0; a < 4; ++a)
    for (std::int64_t b = 0; b < 4; ++b)
      points[static_cast<std::size_t>(4 * a + b)] = {(4 * a + b) * 16 + 8, (4 * b + a) * 16 + 8};
  return points;
}();

struct Sample {
  float nearness = 0.0f;
  std::uint32_t facet = no_triangle;
};

// The samples of one band, pixel by pixel, in memory that the next band takes again.
class Band {
 public:
  Band(const Facets& facets, unsigned band, unsigned width, unsigned height,
       std::span<const GridPoint> pattern, std::vector<Sample>& samples)
      : facets_(facets),
        pattern_(pattern),
        width_(width),
        first_row_(band * band_rows),
        rows_(std::min(band_rows, height - band * band_rows)),
        samples_(samples) {
    samples_.assign(std::size_t{width} * rows_ * pattern.size(), {});
    for (const std::uint32_t f : facets.of_band[band]) draw(f);
  }

  unsigned first_row() const { return first_row_; }
  unsigned rows() const { return rows_; }
  std::span<const Sample> pixel(unsigned x, unsigned row) const {
    return std::span(samples_).subspan((std::size_t{row} * width_ + x) * pattern_.size(), pattern_.size());
  }

 private:
  void draw(std::uint32_t f) {
    const Facet& facet = facets_.facets[f];
    const auto edges = edges_of(places_of(facet));
    if (!edges) return;
    const auto& [a, b, c] = facet.corners;
    const auto [x0, x1] = std::minmax({a.place.x, b.place.x, c.place.x});
    const auto [y0, y1] = std::minmax({a.place.y, b.place.y, c.place.y});
    const std::int64_t first_x = std::max<std::int64_t>(0, x0 / grid);
    const std::int64_t last_x = std::min<std::int64_t>(std::int64_t{width_} - 1, x1 / grid);
    const std::int64_t first_y = std::max<std::int64_t>(first_row_, y0 / grid);
    const std::int64_t last_y = std::min<std::int64_t>(first_row_ + rows_ - 1, y1 / grid);
    const float scale = 1.0f / static_cast<float>(edges->area);
    const Cover cover(facets_.shapes[facet.shape], facet.triangle, *edges, share_of(facets_, facet));
    const bool has_holes = cover.has_holes();
    for (std::int64_t y = first_y; y <= last_y; ++y)
      for (std::int64_t x = first_x; x <= last_x; ++x) {
        std::array<std::int64_t, 3> corner;
        for (std::size_t k = 0; k < 3; ++k) corner[k] = edges->value(k, x * grid, y * grid);
        Sample* sample =
            &samples_[(static_cast<std::size_t>(y - first_row_) * width_ + static_cast<std::size_t>(x)) *
                      pattern_.size()];
        for (const GridPoint& point : pattern_) {
          std::array<std::int64_t, 3> e;
          for (std::size_t k = 0; k < 3; ++k)
            e[k] = corner[k] + edges->dx[k] * point.x + edges->dy[k] * point.y;
          if (edges->covers(e[0], e[1], e[2])) {
            const float nearness =
                (static_cast<float>(e[0]) * a.nearness + static_cast<float>(e[1]) * b.nearness +
                 static_cast<float>(e[2]) * c.nearness) *
                scale;
            // At equal depth the first one drawn wins.
            if (nearness > sample->nearness &&
                !(has_holes && cover.is_hole(weights_at(facets_, facet, *edges,
                                                        {x * grid + point.x, y * grid + point.y}))))
              *sample = {nearness, f};
          }
          ++sample;
        }
      }
  }

  const Facets& facets_;
  std::span<const GridPoint> pattern_;
  unsigned width_, first_row_, rows_;
  std::vector<Sample>& samples_;
};

// Compresses bright light towards white instead of clipping it; values below 0.7 are unchanged.
float soft_limit(float x) {
  constexpr float knee = 0.7f;
  return x < knee ? x : knee + (1.0f - knee) * (1.0f - std::exp(-(x - knee) / (1.0f - knee)));
}

// How far light reaches past the terminator, as a cosine: light scatters inside skin before it leaves, red
// the farthest.
constexpr std::array<float, 3> skin_reach{0.22f, 0.08f, 0.05f}, paint_reach{0.08f, 0.08f, 0.08f};

class Painter {
 public:
  Painter(std::span<const Shape> shapes, const Camera& camera, const Backdrop& backdrop, unsigned threads)
      : shapes_(shapes),
        camera_(camera),
        backdrop_(backdrop),
        threads_(threads),
        facets_(project(shapes, camera)),
        lamps_(studio_lamps(shapes, camera, threads)),
        free_ground_(free_irradiance(lamps_, Vector3f::UnitY())) {}

  Image paint() const {
    Image image(camera_.width, camera_.height);
    const std::size_t threads = base::thread_count(threads_);
    std::vector<std::vector<Sample>> samples(threads);
    base::for_each_in_parallel(facets_.of_band.size(), threads, [&](std::size_t b, std::size_t worker) {
      const Band band(facets_, static_cast<unsigned>(b), camera_.width, camera_.height, spread_points,
                      samples[worker]);
      // Patch by patch: neighbours read the same parts of the shadow maps.
      for (unsigned column = 0; column < camera_.width; column += patch_columns) {
        std::optional<PatchLight> patch;
        for (unsigned row = 0; row < band.rows(); ++row)
          for (unsigned x = column; x < std::min(camera_.width, column + patch_columns); ++x) {
            const unsigned y = band.first_row() + row;
            const Vector3f light = resolve(band.pixel(x, row), x, y, patch);
            for (int c = 0; c < 3; ++c) image.at(x, y)[c] = byte_of_linear(light[c]);
          }
      }
    });
    return image;
  }

 private:
  // Shades each facet, and the backdrop, once if the samples show it.
  Vector3f resolve(std::span<const Sample> samples, unsigned x, unsigned y,
                   std::optional<PatchLight>& patch) const {
    Vector3f sum = Vector3f::Zero();
    std::array<bool, spread_points.size()> done{};
    for (std::size_t k = 0; k < samples.size(); ++k) {
      if (done[k]) continue;
      std::int64_t gx = 0, gy = 0, count = 0;
      for (std::size_t j = k; j < samples.size(); ++j)
        if (samples[j].facet == samples[k].facet) {
          done[j] = true;
          gx += spread_points[j].x;
          gy += spread_points[j].y;
          ++count;
        }
      const GridPoint middle{std::int64_t{x} * grid + gx / count, std::int64_t{y} * grid + gy / count};
      const Vector3f light =
          samples[k].facet == no_triangle ? shade_backdrop(middle, patch) : shade(samples[k].facet, middle);
      sum += light * static_cast<float>(count);
    }
    return sum / static_cast<float>(samples.size());
  }

  // Where the ray through a point of the picture meets the floor, if it does.
  std::optional<Vector3f> floor_at(double x, double y) const {
    const Vector3d ray = camera_.ray(x, y);
    const double distance = (*backdrop_.ground - camera_.eye.y()) / ray.y();
    if (!(distance > 0.0) || !std::isfinite(distance)) return std::nullopt;
    return Vector3f((camera_.eye + distance * ray).cast<float>());
  }

  // Of the floor behind the patch of a band that holds a pixel.
  PatchLight patch_light(unsigned pixel_x, unsigned pixel_y) const {
    const unsigned x = pixel_x - pixel_x % patch_columns, y = pixel_y - pixel_y % band_rows;
    std::array<Vector3f, 4> corners;
    for (std::size_t k = 0; k < 4; ++k)
      if (const auto place = floor_at(x + (k & 1 ? patch_columns : 0), y + (k & 2 ? band_rows : 0)))
        corners[k] = *place;
      else  // across the horizon
        corners[k].setConstant(std::numeric_limits<float>::quiet_NaN());
    return light_of_patch(lamps_, corners, Vector3f::UnitY());
  }

  // `patch`: computed when it is first needed.
  Vector3f shade_backdrop(const GridPoint& at, std::optional<PatchLight>& patch) const {
    const double x = static_cast<double>(at.x) / grid, y = static_cast<double>(at.y) / grid;
    const float down = static_cast<float>(y / camera_.height);
    const Vector3f colour = (1.0f - down) * backdrop_.top + down * backdrop_.bottom;
    if (!backdrop_.ground) return colour;
    const std::optional<Vector3f> place = floor_at(x, y);
    if (!place) return colour;
    if (!patch) patch = patch_light(static_cast<unsigned>(at.x / grid), static_cast<unsigned>(at.y / grid));
    // The floor has the backdrop's colour, so only shadow makes it visible; light reflected by walls and body
    // keeps the shadow from being black.
    constexpr float thrown_back = 0.12f;
    const Vector3f share = irradiance(lamps_, *patch, *place, Vector3f::UnitY()).cwiseQuotient(free_ground_);
    return colour.cwiseProduct(Vector3f::Constant(thrown_back) + (1.0f - thrown_back) * share);
  }

  Vector3f shade(std::uint32_t f, const GridPoint& at) const {
    const Facet& facet = facets_.facets[f];
    const Shape& shape = shapes_[facet.shape];
    const auto& corner = shape.triangles[facet.triangle];
    const Edges edges = *edges_of(places_of(facet));
    const Vector3f weights = weights_at(facets_, facet, edges, at);
    const auto blend = [&](const std::vector<Vector3f>& values) {
      return Vector3f(weights[0] * values[corner[0]] + weights[1] * values[corner[1]] +
                      weights[2] * values[corner[2]]);
    };
    int nearest = 0;
    weights.maxCoeff(&nearest);
    const Vector3f own =
        shape.blend_colours ? blend(shape.colours) : shape.colours[corner[static_cast<std::size_t>(nearest)]];
    const Vector3f paint =
        own.cwiseProduct(Cover(shape, facet.triangle, edges, share_of(facets_, facet)).at(weights).head<3>());
    if (shape.finish == Finish::ink) return paint;
    const Vector3f position = blend(shape.positions);
    const Vector3f to_eye = (camera_.eye.cast<float>() - position).normalized();
    Vector3f normal = blend(shape.normals).normalized();
    if (normal.dot(to_eye) < 0.0f) {
      // The inside of an open surface is lit like the outside. A smooth normal that only just turns away does
      // not count as inside.
      const Vector3f across = (shape.positions[corner[1]] - shape.positions[corner[0]])
                                  .cross(shape.positions[corner[2]] - shape.positions[corner[0]]);
      if (across.dot(to_eye) * across.dot(normal) < 0.0f) normal = -normal;
    }
    Vector3f light = shape.finish == Finish::plain
                         ? plain(paint, position, normal)
                         : glossy(paint, position, normal, to_eye,
                                  shape.finish == Finish::skin ? skin_reach : paint_reach);
    if (shape.draw_edges) light *= edge_shade(facet, edges, at);
    return light;
  }

  // Reflected from the floor and the walls, without shadow.
  static float bounce(const Vector3f& normal) { return 0.16f - 0.06f * normal.y(); }

  Vector3f plain(const Vector3f& paint, const Vector3f& position, const Vector3f& normal) const {
    const float light = irradiance(lamps_, position, normal).x() + bounce(normal);
    return paint * soft_limit(light);
  }

  Vector3f glossy(const Vector3f& paint, const Vector3f& position, const Vector3f& normal,
                  const Vector3f& to_eye, const std::array<float, 3>& past) const {
    const Vector3f reach(past[0], past[1], past[2]);
    Vector3f diffuse = paint * bounce(normal);
    float sheen = 0.0f;
    for (const Lamp& lamp : lamps_) {
      const float cosine = normal.dot(lamp.towards);
      if (cosine <= -reach.x()) continue;
      const float seen = lamp.shadow.visibility(position, normal);
      if (seen == 0.0f) continue;
      for (int c = 0; c < 3; ++c)
        diffuse[c] +=
            paint[c] * seen * lamp.colour[c] * std::max(0.0f, cosine + reach[c]) / (1.0f + reach[c]);
      if (!lamp.shines || cosine <= 0.0f) continue;
      const Vector3f half = (lamp.towards + to_eye).normalized();
      const float fresnel = 0.035f + 0.5f * std::pow(1.0f - std::max(0.0f, half.dot(to_eye)), 5.0f);
      sheen += lamp.colour.x() * seen * cosine * fresnel * 4.0f *
               std::pow(std::max(0.0f, half.dot(normal)), 22.0f);
    }
    Vector3f light = diffuse + Vector3f::Constant(sheen);
    for (int c = 0; c < 3; ++c) light[c] = soft_limit(light[c]);
    return light;
  }

  // Darker within half a pixel of an edge.
  float edge_shade(const Facet& facet, const Edges& edges, const GridPoint& at) const {
    float nearest = 1e9f;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!is_edge_of_triangle(facets_, facet, k)) continue;
      const float length = std::hypot(static_cast<float>(edges.dx[k]), static_cast<float>(edges.dy[k]));
      nearest = std::min(nearest, static_cast<float>(edges.value(k, at.x, at.y)) / length / grid);
    }
    return 0.62f + 0.38f * std::clamp(nearest - 0.1f, 0.0f, 1.0f);
  }

  std::span<const Shape> shapes_;
  const Camera& camera_;
  const Backdrop& backdrop_;
  unsigned threads_;
  Facets facets_;
  std::vector<Lamp> lamps_;
  Vector3f free_ground_;
};

}  // namespace

Image render(std::span<const Shape> shapes, const Camera& camera, const Backdrop& backdrop,
             unsigned threads) {
  return Painter(shapes, camera, backdrop, threads).paint();
}

DepthImage render_depth(std::span<const Shape> shapes, const Camera& camera, unsigned threads) {
  const Facets facets = project(shapes, camera);
  const std::size_t pixels = std::size_t{camera.width} * camera.height;
  DepthImage image{camera.width, camera.height, std::vector<std::uint32_t>(pixels, no_triangle),
                   std::vector<float>(pixels)};
  const std::size_t workers = base::thread_count(threads);
  std::vector<std::vector<Sample>> samples(workers);
  base::for_each_in_parallel(facets.of_band.size(), workers, [&](std::size_t b, std::size_t worker) {
    const Band band(facets, static_cast<unsigned>(b), camera.width, camera.height, center_point,
                    samples[worker]);
    for (unsigned row = 0; row < band.rows(); ++row)
      for (unsigned x = 0; x < camera.width; ++x) {
        const Sample& sample = band.pixel(x, row)[0];
        if (sample.facet == no_triangle) continue;
        const std::size_t pixel = std::size_t{band.first_row() + row} * camera.width + x;
        image.triangle[pixel] = facets.number[sample.facet];
        image.depth[pixel] = 1.0f / sample.nearness;
      }
  });
  return image;
}

}  // namespace fascicle::render
