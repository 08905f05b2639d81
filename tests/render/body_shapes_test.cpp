// The shapes drawn for a model, without drawing them.
#include "host/render/body_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "host/render/colour.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3f;
using render::BodyDrawing;
using render::DrawingOptions;
using render::Mode;

// 4 x 2 x 2 cubes of 0.25 m; the two layers meet at x = 0.5.
model::Model two_layers() {
  BodyOptions options;
  options.beta = 1.0f;
  options.fibre = {0, 1, 0};
  model::Model model = make_model(kuhn_bar(4, 2, 2, 0.25), options);
  model.layers[0].name = "muscle";
  model.layers.push_back({"fat", 0.0, 1000.0, false});
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (model.rest[3 * i] > 0.55f) model.tag[i] |= 1u;
  return model;
}

std::vector<float> metres(const model::Model& model) {
  std::vector<float> positions;
  for (std::size_t k = 0; k < model.rest.size(); ++k)
    positions.push_back(static_cast<float>(model.rest_origin[k % 3] + model.unit * double{model.rest[k]}));
  return positions;
}

double area_of(const render::Shape& shape) {
  double area = 0.0;
  for (const auto& t : shape.triangles)
    area += 0.5 * double{(shape.positions[t[1]] - shape.positions[t[0]])
                             .cross(shape.positions[t[2]] - shape.positions[t[0]])
                             .norm()};
  return area;
}

render::Shape draw(const model::Model& model, const DrawingOptions& options,
                   std::span<const float> lag = {}) {
  return BodyDrawing(model, options).shapes(metres(model), lag, {0, 0, 10}).front();
}

TEST(BodyShapes, TetrahedraShowTheirOutsideOnlyAndFaceOutwards) {
  const model::Model model = two_layers();
  const render::Shape shape = draw(model, {Mode::shaded, true, {}, 0.0});
  EXPECT_NEAR(area_of(shape), 2.0 * (1.0 * 0.5 + 1.0 * 0.5 + 0.5 * 0.5), 1e-5);  // float sums
  const Vector3f middle(0.5f, 0.25f, 0.25f);
  for (std::size_t k = 0; k < shape.positions.size(); ++k)
    EXPECT_GT(shape.normals[k].dot(shape.positions[k] - middle), 0.0f);
}

TEST(BodyShapes, ClipDropsWhatLiesWhollyOnOneSideAndShowsTheCut) {
  const model::Model model = two_layers();
  for (const bool below : {true, false}) {
    const render::Shape shape = draw(model, {Mode::shaded, true, render::Clip{0, 0.5, below}, 0.0});
    // The plane runs between cubes: half of the bar remains, with a wall of 0.5 x 0.5 m at the cut.
    EXPECT_NEAR(area_of(shape), 2.0 * (0.5 * 0.5 + 0.5 * 0.5 + 0.5 * 0.5), 1e-5);
    for (const Vector3f& p : shape.positions) EXPECT_TRUE(below ? p.x() <= 0.5f : p.x() >= 0.5f);
  }
  // Through the cubes: cut cubes stay whole.
  const render::Shape through = draw(model, {Mode::shaded, true, render::Clip{0, 0.6, true}, 0.0});
  float farthest = 0.0f;
  for (const Vector3f& p : through.positions) farthest = std::max(farthest, p.x());
  EXPECT_EQ(farthest, 0.75f);
  EXPECT_THROW(BodyDrawing(model, {Mode::shaded, true, render::Clip{0, -0.1, true}, 0.0}),
               std::invalid_argument);
}

TEST(BodyShapes, LayersTakeTheLegendsColoursAndNoOthers) {
  const model::Model model = two_layers();
  for (const bool tetrahedra : {false, true}) {
    const BodyDrawing drawing(model, {Mode::layers, tetrahedra, {}, 0.0});
    const render::Legend legend = drawing.legend();
    ASSERT_EQ(legend.entries.size(), 2u);
    EXPECT_EQ(legend.entries[0].name, "muscle");
    EXPECT_EQ(legend.entries[1].name, "fat");
    const std::vector<render::Shape> shapes = drawing.shapes(metres(model), {}, {0, 0, 10});
    const render::Shape& shape = shapes.front();
    EXPECT_EQ(shape.finish, render::Finish::plain);
    for (std::size_t k = 0; k < shape.colours.size(); ++k) {
      // Between x = 0.5 and 0.75 a cell may be either; elsewhere it is unambiguous.
      if (shape.positions[k].x() < 0.45f) {
        EXPECT_EQ(shape.colours[k], legend.entries[0].colour);
      } else if (shape.positions[k].x() > 0.8f) {
        EXPECT_EQ(shape.colours[k], legend.entries[1].colour);
      } else {
        EXPECT_TRUE(shape.colours[k] == legend.entries[0].colour ||
                    shape.colours[k] == legend.entries[1].colour);
      }
    }
  }
}

TEST(BodyShapes, LagTakesTheScalesColours) {
  const model::Model model = two_layers();
  std::vector<float> lag(model.vertex_count);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) lag[i] = 0.02f * model.rest[3 * i];
  const render::Shape shape = draw(model, {Mode::lag, true, {}, 0.02}, lag);
  for (std::size_t k = 0; k < shape.colours.size(); ++k)
    // The colour is piecewise linear in lag with slopes below 5; lag is known to a few ulp.
    EXPECT_NEAR((shape.colours[k] - render::scale_colour(shape.positions[k].x())).norm(), 0.0f, 1e-5f);
  const BodyDrawing drawing(model, {Mode::lag, true, {}, 0.02});
  EXPECT_EQ(drawing.legend().entries.back().name, "20 mm");
  EXPECT_EQ(drawing.legend().entries.back().colour, render::scale_colour(1.0f));
}

// Flesh inside other flesh has colours of the scale, everything else another colour. Each such vertex also
// has a mark in front of the body, on its line to the eye.
TEST(BodyShapes, ContactShowsDepthThroughTheBody) {
  const model::Model model = two_layers();
  std::vector<float> depth(model.vertex_count, -1.0f);
  std::vector<std::uint32_t> deep;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (model.rest[3 * i] < 0.3f) {
      depth[i] = 0.01f;
      deep.push_back(i);
    }
  ASSERT_GT(deep.size(), 3u);
  ASSERT_LT(deep.size(), model.vertex_count / 2);
  const std::vector<float> positions = metres(model);
  const Vector3f eye(0.5f, 0.25f, 10.0f), half = render::scale_colour(0.5f);
  const BodyDrawing drawing(model, {Mode::contact, true, {}, 0.02});
  EXPECT_EQ(drawing.legend().entries.back().name, "20 mm");
  const std::vector<render::Shape> shapes = drawing.shapes(positions, depth, eye);
  ASSERT_EQ(shapes.size(), 2u);
  std::size_t coloured = 0;
  for (const Vector3f& colour : shapes[0].colours) {
    coloured += (colour - half).norm() < 1e-5f ? 1 : 0;
    EXPECT_TRUE((colour - half).norm() < 1e-5f || (colour - render::colour(0xd2d0cc)).norm() < 1e-5f);
  }
  EXPECT_GT(coloured, 0u);
  EXPECT_LT(coloured, shapes[0].colours.size());

  const render::Shape& marks = shapes[1];
  EXPECT_FALSE(marks.casts_shadow);
  ASSERT_EQ(marks.positions.size() % deep.size(), 0u);
  const std::size_t each = marks.positions.size() / deep.size();
  float nearest = 1e9f;
  for (std::size_t i = 0; i < positions.size(); i += 3)
    nearest = std::min(nearest, (Vector3f(positions[i], positions[i + 1], positions[i + 2]) - eye).norm());
  for (std::size_t k = 0; k < deep.size(); ++k) {
    Vector3f middle = Vector3f::Zero();
    for (std::size_t c = 0; c < each; ++c) {
      middle += marks.positions[k * each + c] / static_cast<float>(each);
      EXPECT_LT((marks.positions[k * each + c] - eye).norm(), nearest);
      EXPECT_LT((marks.colours[k * each + c] - half).norm(), 1e-5f);
    }
    const std::size_t i = 3 * std::size_t{deep[k]};
    const Vector3f to(Vector3f(positions[i], positions[i + 1], positions[i + 2]) - eye);
    // Positions 10 m from the eye are floats: 1e-6 of each.
    EXPECT_LT((middle - eye).normalized().cross(to.normalized()).norm(), 1e-5f);
  }
  for (const render::Shape& shape : drawing.shapes(positions, std::vector<float>(depth.size(), -1.0f), eye))
    for (const Vector3f& colour : shape.colours) EXPECT_EQ(colour, render::colour(0xd2d0cc));
}

// Lines follow the deformed fibres: sheared by x += y, upright fibres tilt by 45 degrees.
TEST(BodyShapes, FibresFollowTheDeformation) {
  const model::Model model = two_layers();
  std::vector<float> positions = metres(model);
  for (std::size_t i = 0; i < positions.size(); i += 3) positions[i] += positions[i + 1];
  const BodyDrawing drawing(model, {Mode::fibres, false, {}, 0.0});
  EXPECT_TRUE(drawing.shows_fibres());
  const std::vector<render::Shape> shapes = drawing.shapes(positions, {}, {0, 0, 100});
  ASSERT_EQ(shapes.size(), 2u);
  const render::Shape& lines = shapes[1];
  ASSERT_FALSE(lines.positions.empty());
  EXPECT_EQ(lines.finish, render::Finish::ink);
  const Vector3f leaning = Vector3f(1, 1, 0).normalized();
  for (std::size_t k = 0; k < lines.positions.size(); k += 4) {
    const Vector3f along = (lines.positions[k + 2] - lines.positions[k]).normalized();
    EXPECT_NEAR(std::fabs(along.dot(leaning)), 1.0f, 1e-4f);  // float positions over lines of 0.2 m
    EXPECT_NEAR((lines.colours[k] - render::direction_colour(leaning)).norm(), 0.0f, 1e-3f);
  }
}

// Each side of a box has one normal; a mesh vertex becomes three where three sides meet.
TEST(BodyShapes, CreasesSplitNormalsAndNothingElse) {
  const model::Model model = two_layers();
  ASSERT_GT(model.surface_count(), 0u);
  const render::Shape shape = draw(model, {});
  EXPECT_EQ(shape.triangles.size(), model.surface_triangle.size() / 3);
  for (const auto& t : shape.triangles) {
    const Vector3f across = (shape.positions[t[1]] - shape.positions[t[0]])
                                .cross(shape.positions[t[2]] - shape.positions[t[0]])
                                .normalized();
    for (const std::uint32_t corner : t)
      // The test's render vertices are slightly inside and bend its sides by up to 10 degrees; a normal
      // shared across an edge would be off by 45.
      EXPECT_GT(across.dot(shape.normals[corner]), 0.98f);
  }
}

}  // namespace
}  // namespace fascicle::tests
