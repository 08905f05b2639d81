// What fascicle-mesher returns: taken as it writes it, and refused in one message otherwise.
#include "host/build/mesher_replies.h"

#include <string>

#include <gtest/gtest.h>

namespace fascicle::tests {
namespace {

using mesh::SurfaceMesh;
using mesh::TetMesh;

template <class Call>
std::string refusal_of(Call call) {
  try {
    call();
  } catch (const scene::SceneError& error) {
    return error.what();
  }
  return "accepted";
}

// A report in which the line of `name` is another; empty: left out.
std::string report_with(const std::string& name, const std::string& line) {
  std::string text;
  for (const std::string one :
       {"parts 1 0", "loose_vertices 0", "flat_triangles 0", "open_edges 5 0 1 1 2", "non_manifold_edges 0",
        "non_manifold_vertices 0", "turned_edges 0", "inverted_parts 0", "intersections 0", "genus -1"})
    if (!one.starts_with(name + ' '))
      text += one + '\n';
    else if (!line.empty())
      text += line + '\n';
  return text + "end\n";
}

std::string refusal_of_findings(const std::string& text) {
  return refusal_of([&] { build::parse_findings(text, 4); });
}

TEST(MesherReplies, FindingsAreCountsAndVertices) {
  const build::SurfaceFindings found = build::parse_findings(report_with("parts", "parts 2 0 3"), 4);
  EXPECT_EQ(found.parts.count, 2U);
  EXPECT_EQ(found.parts.vertices, (std::vector<std::uint32_t>{0, 3}));
  EXPECT_EQ(found.open_edges.count, 5U);
  EXPECT_EQ(found.open_edges.vertices, (std::vector<std::uint32_t>{0, 1, 1, 2}));
  EXPECT_EQ(found.intersections.count, 0U);
  EXPECT_EQ(found.genus, -1);
}

TEST(MesherReplies, FindingsThatCannotBeAreRefused) {
  std::vector<std::string> texts{"", "end\n", "parts 1 0\n", report_with("parts", "")};
  for (const char* line :
       {"parts", "parts -1", "parts 1 zero", "parts 1 0 x", "parts 1 -", "parts 1 0 99999999999999999999",
        "parts 99999999999999999999", "parts 1 0\nparts 1 0", "holes 1"})
    texts.push_back(report_with("parts", line));
  for (const char* line : {"genus", "genus two", "genus 1.5", "genus 1 x", "genus 1 2"})
    texts.push_back(report_with("genus", line));
  for (const std::string& text : texts)
    EXPECT_NE(refusal_of_findings(text).find("its report ends early or cannot be read"), std::string::npos)
        << text << ": " << refusal_of_findings(text);
  for (const char* line : {"parts 1 4", "parts 1 -1", "parts 1 4294967296"})
    EXPECT_NE(refusal_of_findings(report_with("parts", line)).find("a vertex that does not exist"),
              std::string::npos)
        << line << ": " << refusal_of_findings(report_with("parts", line));
}

TEST(MesherReplies, LengthsOfAWrapArePositive) {
  const build::WrapLengths used = build::parse_wrap_lengths("alpha 0.02 offset 1e-3");
  EXPECT_EQ(used.alpha, 0.02);
  EXPECT_EQ(used.offset, 1e-3);
  for (const char* line : {"", "alpha 0.02", "alpha 0 offset 1", "alpha 1 offset -1", "alpha nan offset 1",
                           "alpha 1e999 offset 1", "offset 1 alpha 1"})
    EXPECT_NE(refusal_of([&] { build::parse_wrap_lengths(line); }).find("does not say its alpha and offset"),
              std::string::npos)
        << line;
}

const SurfaceMesh tetrahedron{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                              {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};

TEST(MesherReplies, AFillingIsTurnedAndLosesUnusedVertices) {
  TetMesh mesh{tetrahedron.vertices, {{0, 1, 3, 2}}};
  mesh.vertices.emplace_back(5, 5, 5);
  build::check_filling(mesh, tetrahedron);
  EXPECT_EQ(mesh.vertices, tetrahedron.vertices);
  EXPECT_EQ(mesh.tetrahedra, (std::vector<std::array<std::uint32_t, 4>>{{0, 1, 2, 3}}));
}

TEST(MesherReplies, AFillingOfAnotherSurfaceIsRefused) {
  const auto refusal = [](TetMesh mesh) {
    return refusal_of([&] { build::check_filling(mesh, tetrahedron); });
  };
  TetMesh moved{tetrahedron.vertices, {{0, 1, 2, 3}}};
  moved.vertices[2].x() = 1e-300;
  EXPECT_NE(refusal(moved).find("vertex 2 of the surface was moved"), std::string::npos) << refusal(moved);
  const TetMesh few{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}};
  EXPECT_NE(refusal(few).find("lacks vertices"), std::string::npos) << refusal(few);
  const TetMesh none{tetrahedron.vertices, {}};
  EXPECT_NE(refusal(none).find("is in no tetrahedron"), std::string::npos) << refusal(none);
  TetMesh larger{tetrahedron.vertices, {{0, 1, 2, 3}, {1, 2, 3, 4}}};
  larger.vertices.emplace_back(1, 1, 1);
  EXPECT_NE(refusal(larger).find("its outside is not the surface"), std::string::npos) << refusal(larger);
  const TetMesh flat{tetrahedron.vertices, {{0, 1, 2, 3}, {0, 1, 2, 2}}};
  EXPECT_NE(refusal(flat).find("tetrahedron 1 is flat"), std::string::npos) << refusal(flat);
}

}  // namespace
}  // namespace fascicle::tests
