#include "host/made/made_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <Eigen/Geometry>

#include "host/made/made_mesh.h"

namespace fascicle::made {
namespace {

double clamp(double x, double low, double high) {
  return x < low ? low : x > high ? high : x;
}

// The distance to a round cone is the minimum over its balls. If the radius changes, the centre of the
// nearest ball is not the foot of the perpendicular.
FieldSample sample_part(const RoundCone& part, const Vector3d& point) {
  const Vector3d axis = part.to - part.from, from = point - part.from;
  const double square = axis.squaredNorm();
  double t = 0.0;
  if (square > 0.0) {
    const double length = std::sqrt(square);
    const double along = from.dot(axis) / length;
    const double slope = clamp((part.to_radius - part.from_radius) / length, -0.99, 0.99);
    const double height = std::sqrt(std::max(from.squaredNorm() - along * along, 0.0));
    t = clamp((along + height * slope / std::sqrt(1.0 - slope * slope)) / length, 0.0, 1.0);
  }
  const Vector3d away = from - t * axis;
  const double distance = std::sqrt(away.squaredNorm());
  const double radius = part.from_radius + t * (part.to_radius - part.from_radius);
  return {distance - radius, distance > 0.0 ? Vector3d(away / distance) : Vector3d(0.0, 1.0, 0.0)};
}

// The polynomial smooth minimum: differs from the minimum only where the two are within `width` of each
// other.
FieldSample smooth_union(const FieldSample& a, const FieldSample& b, double width) {
  if (b.distance - a.distance >= width) return a;
  if (a.distance - b.distance >= width) return b;
  const double share = 0.5 + 0.5 * (b.distance - a.distance) / width;
  return {share * a.distance + (1.0 - share) * b.distance - width * share * (1.0 - share),
          share * a.gradient + (1.0 - share) * b.gradient};
}

constexpr double sole_rounding = 0.02;  // m; rounds the edge where the floor cuts

}  // namespace

FieldSample sample_field(const Sculpture& sculpture, const Vector3d& point) {
  FieldSample field = sample_part(sculpture.parts.front(), point);
  for (std::size_t i = 1; i < sculpture.parts.size(); ++i)
    field = smooth_union(field, sample_part(sculpture.parts[i], point), sculpture.parts[i].blend);
  // An intersection is the complement of the union of the complements.
  const FieldSample above{point.y() - sculpture.floor, Vector3d(0.0, 1.0, 0.0)};
  const FieldSample outside =
      smooth_union({-field.distance, Vector3d(-field.gradient)}, above, sole_rounding);
  return {-outside.distance, Vector3d(-outside.gradient)};
}

std::size_t nearest_part(const Sculpture& sculpture, const Vector3d& point) {
  std::size_t nearest = 0;
  double least = sample_part(sculpture.parts.front(), point).distance;
  for (std::size_t i = 1; i < sculpture.parts.size(); ++i) {
    const double distance = sample_part(sculpture.parts[i], point).distance;
    if (distance < least) {
      least = distance;
      nearest = i;
    }
  }
  return nearest;
}

namespace {

// A grid of points around the body with a margin of two cells, symmetric in x with the middle of a cell at x
// = 0.
struct Grid {
  Vector3d origin;
  std::array<int, 3> points{};
  double spacing = 0.0;

  Vector3d at(int i, int j, int k) const { return origin + spacing * Vector3d(i, j, k); }
  std::size_t index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(points[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(points[0]) +
           static_cast<std::size_t>(i);
  }
  std::size_t size() const { return index(0, 0, points[2]); }
};

Grid grid_around(const Sculpture& sculpture, double spacing) {
  Vector3d low = sculpture.parts.front().from, high = low;
  for (const RoundCone& part : sculpture.parts) {
    for (const auto& [centre, radius] :
         {std::pair(part.from, part.from_radius), std::pair(part.to, part.to_radius)}) {
      // Fillets bulge by a quarter of their width.
      const Vector3d reach = Vector3d::Constant(radius + 0.25 * part.blend);
      low = low.cwiseMin(centre - reach);
      high = high.cwiseMax(centre + reach);
    }
  }
  Grid grid;
  grid.spacing = spacing;
  const double width = std::max(-low.x(), high.x());
  low.x() = -width;
  high.x() = width;
  for (int a = 0; a < 3; ++a) {
    const double middle = (low[a] + high[a]) / 2.0;
    // An even number of points, so that the middle is the middle of a cell.
    const int half = static_cast<int>(std::ceil((high[a] - low[a]) / (2.0 * spacing))) + 2;
    grid.points[static_cast<std::size_t>(a)] = 2 * half;
    grid.origin[a] = middle - (half - 0.5) * spacing;
  }
  return grid;
}

// Field distances at all points of the grid. Blocks that are farther from the surface than their own size are
// filled with the value at their middle, because only its sign is used.
std::vector<double> sample_grid(const Sculpture& sculpture, const Grid& grid) {
  constexpr int block = 4;
  std::vector<double> field(grid.size());
  const double reach = 1.8 * 0.5 * (block + 1) * grid.spacing;  // more than half of the block's diagonal
  for (int k0 = 0; k0 < grid.points[2]; k0 += block)
    for (int j0 = 0; j0 < grid.points[1]; j0 += block)
      for (int i0 = 0; i0 < grid.points[0]; i0 += block) {
        const Vector3d middle = grid.at(i0, j0, k0) + Vector3d::Constant(0.5 * (block - 1) * grid.spacing);
        const double there = sample_field(sculpture, middle).distance;
        const bool far = there > reach || there < -reach;
        for (int k = k0; k < std::min(k0 + block, grid.points[2]); ++k)
          for (int j = j0; j < std::min(j0 + block, grid.points[1]); ++j)
            for (int i = i0; i < std::min(i0 + block, grid.points[0]); ++i)
              field[grid.index(i, j, k)] = far ? there : sample_field(sculpture, grid.at(i, j, k)).distance;
      }
  return field;
}

constexpr std::uint32_t no_part = ~std::uint32_t{0};

// The twelve edges of a cell, by axis and by position along the next two axes; a corner has one bit per axis.
std::size_t cell_edge(std::size_t axis, std::size_t a, std::size_t b) {
  return 4 * axis + a + 2 * b;
}
struct CellEdge {
  std::size_t axis, low, high;  // low and high: corners
};
CellEdge cell_edge(std::size_t edge) {
  const std::size_t axis = edge / 4;
  const std::size_t low = (edge & 1) << (axis + 1) % 3 | (edge >> 1 & 1) << (axis + 2) % 3;
  return {axis, low, low | std::size_t{1} << axis};
}

// For each edge of a cell that the surface crosses, the sheet it belongs to, identified by the lowest edge of
// that sheet. On a face with two crossings they are joined; with four, the two around each inner corner are.
std::array<std::size_t, 12> sheets_of_cell(const std::array<bool, 8>& inside) {
  std::array<std::size_t, 12> sheet{};
  for (std::size_t e = 0; e < 12; ++e) sheet[e] = e;
  const auto crossed = [&](std::size_t e) { return inside[cell_edge(e).low] != inside[cell_edge(e).high]; };
  const auto join = [&](std::size_t e, std::size_t f) {
    const std::size_t low = std::min(sheet[e], sheet[f]), high = std::max(sheet[e], sheet[f]);
    for (std::size_t& s : sheet)
      if (s == high) s = low;
  };
  for (std::size_t n = 0; n < 3; ++n)
    for (std::size_t end = 0; end < 2; ++end) {
      const std::size_t u = (n + 1) % 3, v = (n + 2) % 3;
      const auto along_u = [&](std::size_t at_v) { return cell_edge(u, at_v, end); };
      const auto along_v = [&](std::size_t at_u) { return cell_edge(v, end, at_u); };
      std::vector<std::size_t> crossings;
      for (const std::size_t e : {along_u(0), along_u(1), along_v(0), along_v(1)})
        if (crossed(e)) crossings.push_back(e);
      if (crossings.size() == 2) join(crossings[0], crossings[1]);
      if (crossings.size() == 4)
        for (std::size_t at_u = 0; at_u < 2; ++at_u)
          for (std::size_t at_v = 0; at_v < 2; ++at_v)
            if (inside[end << n | at_u << u | at_v << v]) join(along_u(at_v), along_v(at_u));
    }
  return sheet;
}

// Places one vertex per cell and sheet of the surface, at the mean of the sheet's crossings of the cell's
// edges, and one quadrilateral around each crossed grid edge, split along its shorter diagonal.
mesh::SurfaceMesh surface_nets(const Grid& grid, const std::vector<double>& field) {
  mesh::SurfaceMesh mesh;
  std::vector<std::uint32_t> slot_of_cell(field.size(), no_part);
  std::vector<std::array<std::uint32_t, 12>> vertex_of_edge;  // per slot
  for (int k = 0; k + 1 < grid.points[2]; ++k)
    for (int j = 0; j + 1 < grid.points[1]; ++j)
      for (int i = 0; i + 1 < grid.points[0]; ++i) {
        std::array<double, 8> value{};
        std::array<bool, 8> inside{};
        for (std::size_t c = 0; c < 8; ++c) {
          const auto bit = [&](std::size_t axis) { return static_cast<int>(c >> axis & 1); };
          value[c] = field[grid.index(i + bit(0), j + bit(1), k + bit(2))];
          inside[c] = value[c] < 0.0;
        }
        if (std::all_of(inside.begin(), inside.end(), [&](bool in) { return in == inside[0]; })) continue;
        slot_of_cell[grid.index(i, j, k)] = static_cast<std::uint32_t>(vertex_of_edge.size());
        std::array<std::uint32_t, 12>& vertex = vertex_of_edge.emplace_back();
        vertex.fill(no_part);
        const std::array<std::size_t, 12> sheet = sheets_of_cell(inside);
        for (std::size_t first = 0; first < 12; ++first) {
          Vector3d sum = Vector3d::Zero();
          int crossings = 0;
          for (std::size_t e = first; e < 12; ++e) {
            const CellEdge edge = cell_edge(e);
            if (sheet[e] != first || inside[edge.low] == inside[edge.high]) continue;
            const auto bit = [&](std::size_t axis) { return static_cast<int>(edge.low >> axis & 1); };
            Vector3d place = grid.at(i + bit(0), j + bit(1), k + bit(2));
            place[static_cast<int>(edge.axis)] +=
                grid.spacing * (value[edge.low] / (value[edge.low] - value[edge.high]));
            sum += place;
            ++crossings;
            vertex[e] = static_cast<std::uint32_t>(mesh.vertices.size());
          }
          if (crossings > 0) mesh.vertices.push_back(sum / crossings);
        }
      }
  const auto add_quad = [&](std::array<std::uint32_t, 4> q, bool reversed) {
    if (reversed) std::swap(q[1], q[3]);
    const auto length = [&](std::size_t a, std::size_t b) {
      return (mesh.vertices[q[a]] - mesh.vertices[q[b]]).squaredNorm();
    };
    if (length(0, 2) <= length(1, 3)) {
      mesh.triangles.push_back({q[0], q[1], q[2]});
      mesh.triangles.push_back({q[0], q[2], q[3]});
    } else {
      mesh.triangles.push_back({q[1], q[2], q[3]});
      mesh.triangles.push_back({q[1], q[3], q[0]});
    }
  };
  for (int k = 1; k + 1 < grid.points[2]; ++k)
    for (int j = 1; j + 1 < grid.points[1]; ++j)
      for (int i = 1; i + 1 < grid.points[0]; ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
          std::array<int, 3> next{i, j, k};
          next[axis] += 1;
          const bool inside = field[grid.index(i, j, k)] < 0.0;
          if (inside == (field[grid.index(next[0], next[1], next[2])] < 0.0)) continue;
          // The vertex in the cell that has this edge at (a, b) among its four edges along the axis.
          const auto vertex = [&](std::size_t a, std::size_t b) {
            std::array<int, 3> cell{i, j, k};
            cell[(axis + 1) % 3] -= static_cast<int>(a);
            cell[(axis + 2) % 3] -= static_cast<int>(b);
            return vertex_of_edge[slot_of_cell[grid.index(cell[0], cell[1], cell[2])]][cell_edge(axis, a, b)];
          };
          add_quad({vertex(1, 1), vertex(0, 1), vertex(0, 0), vertex(1, 0)}, !inside);
        }
  return mesh;
}

Vector3d project(const Sculpture& sculpture, const Vector3d& point) {
  const FieldSample field = sample_field(sculpture, point);
  return point - field.gradient * (field.distance / std::max(field.gradient.squaredNorm(), 0.25));
}

}  // namespace

mesh::SurfaceMesh polygonise(const Sculpture& sculpture, double spacing) {
  // A surface oblique to the grid crosses more cells: a net's mean edge is 0.89 of its grid's.
  const Grid grid = grid_around(sculpture, spacing / 0.89);
  mesh::SurfaceMesh mesh = surface_nets(grid, sample_grid(sculpture, grid));
  constexpr int rounds = 12;
  for (int round = 0; round < rounds; ++round) {
    flip_to_delaunay(mesh);
    smooth_tangentially(mesh);
    for (Vector3d& p : mesh.vertices) p = project(sculpture, p);
  }
  flip_to_delaunay(mesh);
  return mesh;
}

std::vector<PartMass> masses_of_joints(const Sculpture& sculpture, std::size_t joints, double spacing) {
  std::vector<PartMass> masses(joints);
  const Grid grid = grid_around(sculpture, spacing);
  const double cell = spacing * spacing * spacing;
  for (int k = 0; k < grid.points[2]; ++k)
    for (int j = 0; j < grid.points[1]; ++j)
      for (int i = 0; i < grid.points[0]; ++i) {
        const Vector3d point = grid.at(i, j, k);
        if (sample_field(sculpture, point).distance >= 0.0) continue;
        PartMass& part = masses[sculpture.parts[nearest_part(sculpture, point)].joint];
        part.mass += cell;
        part.centre += cell * point;
      }
  for (PartMass& part : masses)
    if (part.mass > 0.0) part.centre /= part.mass;
  return masses;
}

}  // namespace fascicle::made
