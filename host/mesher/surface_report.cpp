#include "host/mesher/surface_report.h"

#include <algorithm>
#include <initializer_list>
#include <map>
#include <numeric>
#include <tuple>
#include <vector>

#include "host/mesher/surface_check.h"

namespace fascicle::mesher {
namespace {

constexpr std::size_t most_places = 16;

void note(Finding& finding, std::initializer_list<int> vertices) {
  if (finding.count++ < most_places) finding.vertices.insert(finding.vertices.end(), vertices);
}

// Union-find over numbers.
class Unions {
 public:
  explicit Unions(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  int find(int i) {
    while (parent_[at(i)] != i) i = parent_[at(i)] = parent_[at(parent_[at(i)])];
    return i;
  }
  // The lowest number represents a set.
  void join(int i, int j) {
    const auto [low, high] = std::minmax({find(i), find(j)});
    parent_[at(high)] = low;
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  std::vector<int> parent_;
};

struct EdgeOfTriangle {
  int low, high;
  bool is_forward;
  int triangle;
};

std::vector<EdgeOfTriangle> sorted_half_edges(const Surface& surface) {
  std::vector<EdgeOfTriangle> edges;
  edges.reserve(3 * surface.triangles.size());
  for (std::size_t i = 0; i < surface.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = surface.triangles[i][k];
      const int to = surface.triangles[i][(k + 1) % 3];
      edges.push_back({std::min(from, to), std::max(from, to), from < to, static_cast<int>(i)});
    }
  std::sort(edges.begin(), edges.end(), [](const EdgeOfTriangle& a, const EdgeOfTriangle& b) {
    return std::tuple(a.low, a.high, a.triangle) < std::tuple(b.low, b.high, b.triangle);
  });
  return edges;
}

double six_volumes(const Point& a, const Point& b, const Point& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
         a[2] * (b[0] * c[1] - b[1] * c[0]);
}

// Counts per part, from which genus, closedness and orientation follow.
struct Part {
  long long vertices = 0, edges = 0, triangles = 0;
  double six_volumes = 0.0;
  bool is_closed = true;  // and manifold, and consistently oriented
};

// A fan is a set of triangles around a vertex, connected by edges at it. With more than one fan, parts of the
// surface meet only at the vertex. Corners are numbered 3 x triangle + position.
std::vector<int> pinched_vertices(const Surface& surface, const std::vector<EdgeOfTriangle>& edges) {
  Unions corners(3 * surface.triangles.size());
  const auto corner_at = [&](int triangle, int vertex) {
    const auto& t = surface.triangles[static_cast<std::size_t>(triangle)];
    return 3 * triangle + static_cast<int>(std::find(t.begin(), t.end(), vertex) - t.begin());
  };
  for (std::size_t i = 1; i < edges.size(); ++i) {
    const EdgeOfTriangle &a = edges[i - 1], &b = edges[i];
    if (a.low != b.low || a.high != b.high) continue;
    for (const int v : {a.low, a.high}) corners.join(corner_at(a.triangle, v), corner_at(b.triangle, v));
  }
  std::vector<int> fans(surface.vertices.size(), 0);
  for (std::size_t i = 0; i < surface.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const int corner = static_cast<int>(3 * i + k);
      if (corners.find(corner) == corner) ++fans[static_cast<std::size_t>(surface.triangles[i][k])];
    }
  std::vector<int> pinched;
  for (std::size_t v = 0; v < fans.size(); ++v)
    if (fans[v] > 1) pinched.push_back(static_cast<int>(v));
  return pinched;
}

void add_line(std::string& text, const char* name, const Finding& finding) {
  text += name;
  text += " " + std::to_string(finding.count);
  for (const int v : finding.vertices) text += " " + std::to_string(v);
  text += "\n";
}

}  // namespace

SurfaceReport report_surface(const Surface& surface) {
  SurfaceReport report;
  Unions joined(surface.vertices.size());
  std::vector<char> used(surface.vertices.size(), 0);
  for (const auto& t : surface.triangles) {
    joined.join(t[0], t[1]);
    joined.join(t[1], t[2]);
    for (const int v : t) used[static_cast<std::size_t>(v)] = 1;
    const auto place = [&](std::size_t k) { return surface.vertices[static_cast<std::size_t>(t[k])]; };
    if (!has_area(place(0), place(1), place(2))) note(report.flat_triangles, {t[0], t[1], t[2]});
  }

  std::map<int, Part> parts;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v])
      ++parts[joined.find(static_cast<int>(v))].vertices;
    else
      note(report.loose_vertices, {static_cast<int>(v)});
  }
  for (const auto& t : surface.triangles) {
    Part& part = parts[joined.find(t[0])];
    ++part.triangles;
    // Relative to a corner of the part, so that a part far from the origin keeps its precision.
    const Point& origin = surface.vertices[static_cast<std::size_t>(joined.find(t[0]))];
    std::array<Point, 3> p;
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t a = 0; a < 3; ++a)
        p[k][a] = surface.vertices[static_cast<std::size_t>(t[k])][a] - origin[a];
    part.six_volumes += six_volumes(p[0], p[1], p[2]);
  }

  const std::vector<EdgeOfTriangle> edges = sorted_half_edges(surface);
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
    Part& part = parts[joined.find(edges[i].low)];
    ++part.edges;
    const bool is_turned = end - i == 2 && edges[i].is_forward == edges[i + 1].is_forward;
    if (end - i == 1) note(report.open_edges, {edges[i].low, edges[i].high});
    if (end - i > 2) note(report.non_manifold_edges, {edges[i].low, edges[i].high});
    if (is_turned) note(report.turned_edges, {edges[i].low, edges[i].high});
    if (end - i != 2 || is_turned) part.is_closed = false;
    i = end;
  }
  for (const int v : pinched_vertices(surface, edges)) {
    note(report.non_manifold_vertices, {v});
    parts[joined.find(v)].is_closed = false;
  }

  for (const auto& [first, part] : parts) {
    note(report.parts, {first});
    if (!part.is_closed) continue;
    if (part.six_volumes < 0.0) note(report.inverted_parts, {first});
    report.genus += (2 - (part.vertices - part.edges + part.triangles)) / 2;
  }

  std::size_t count = 0;
  for (const auto& pair : intersecting_triangles(surface, most_places, count))
    for (const int triangle : pair)
      report.intersections.vertices.push_back(surface.triangles[static_cast<std::size_t>(triangle)][0]);
  report.intersections.count = count;
  return report;
}

std::string text_of(const SurfaceReport& report) {
  std::string text;
  add_line(text, "parts", report.parts);
  add_line(text, "loose_vertices", report.loose_vertices);
  add_line(text, "flat_triangles", report.flat_triangles);
  add_line(text, "open_edges", report.open_edges);
  add_line(text, "non_manifold_edges", report.non_manifold_edges);
  add_line(text, "non_manifold_vertices", report.non_manifold_vertices);
  add_line(text, "turned_edges", report.turned_edges);
  add_line(text, "inverted_parts", report.inverted_parts);
  add_line(text, "intersections", report.intersections);
  text += "genus " + std::to_string(report.genus) + "\nend\n";
  return text;
}

}  // namespace fascicle::mesher
