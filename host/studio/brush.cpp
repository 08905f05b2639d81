#include "host/studio/brush.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include <Eigen/Geometry>

namespace fascicle::studio {
namespace {

double share_of(Falloff falloff, double way) {
  if (falloff == Falloff::constant) return 1.0;
  const double left = std::max(1.0 - way, 0.0);
  return falloff == Falloff::linear ? left : left * left * (3.0 - 2.0 * left);
}

Vector3d mirrored(const Vector3d& v) {
  return {-v[0], v[1], v[2]};
}

}  // namespace

PaintGround::PaintGround(const mesh::SurfaceMesh& surface, std::vector<rig::PaintedAttribute> own)
    : surface_(surface), own_(std::move(own)), hash_(rig::surface_hash(surface)) {
  std::map<std::array<double, 3>, std::uint32_t> points;
  for (const Vector3d& p : surface_.vertices) {
    const auto [known, is_new] =
        points.try_emplace({p[0], p[1], p[2]}, static_cast<std::uint32_t>(place_.size()));
    if (is_new) place_.push_back(p);
    point_of_.push_back(known->second);
  }
  // CSR lists: the vertices at each point, and its neighbours.
  const auto offsets = [&](const auto& each) {
    std::vector<std::uint32_t> offset(place_.size() + 1, 0);
    each([&](std::uint32_t point, std::uint32_t) { ++offset[point + 1]; });
    for (std::size_t k = 1; k < offset.size(); ++k) offset[k] += offset[k - 1];
    return offset;
  };
  const auto fill = [&](const std::vector<std::uint32_t>& offset, std::vector<std::uint32_t>& list,
                        const auto& each) {
    list.resize(offset.back());
    std::vector<std::uint32_t> next(offset.begin(), offset.end() - 1);
    each([&](std::uint32_t point, std::uint32_t entry) { list[next[point]++] = entry; });
  };
  const auto each_vertex = [&](const auto& use) {
    for (std::uint32_t v = 0; v < point_of_.size(); ++v) use(point_of_[v], v);
  };
  const auto each_side = [&](const auto& use) {
    for (const auto& t : surface_.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        use(point_of_[t[k]], point_of_[t[(k + 1) % 3]]);
        use(point_of_[t[(k + 1) % 3]], point_of_[t[k]]);
      }
  };
  vertex_offset_ = offsets(each_vertex);
  fill(vertex_offset_, vertex_, each_vertex);
  neighbour_offset_ = offsets(each_side);
  fill(neighbour_offset_, neighbour_, each_side);
  normal_.assign(place_.size(), Vector3d::Zero());
  for (const auto& t : surface_.triangles) {
    const Vector3d& a = surface_.vertices[t[0]];
    const Vector3d area = (surface_.vertices[t[1]] - a).cross(surface_.vertices[t[2]] - a);
    for (const std::uint32_t corner : t) normal_[point_of_[corner]] += area;
  }
  for (Vector3d& normal : normal_)
    if (const double length = normal.norm(); length > 0.0) normal /= length;
}

std::uint32_t PaintGround::nearest(const Vector3d& place) const {
  std::uint32_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t p = 0; p < place_.size(); ++p) {
    const double distance = (place_[p] - place).squaredNorm();
    if (distance < least) least = distance, best = p;
  }
  return best;
}

std::size_t PaintGround::count_within(const Vector3d& place, double radius) const {
  std::size_t count = 0;
  for (std::size_t p = 0; p < place_.size(); ++p)
    if ((place_[p] - place).squaredNorm() <= radius * radius)
      count += vertex_offset_[p + 1] - vertex_offset_[p];
  return count;
}

double PaintGround::distance_to(const Vector3d& place) const {
  return place_.empty() ? std::numeric_limits<double>::infinity() : (place_[nearest(place)] - place).norm();
}

std::vector<PaintGround::Reached> PaintGround::reached(const Vector3d& place, double radius,
                                                       double farthest) const {
  std::vector<Reached> found;
  if (place_.empty()) return found;
  const std::uint32_t first = nearest(place);
  if ((place_[first] - place).norm() > std::max(radius, farthest)) return found;
  std::vector<std::uint32_t> waiting{first};
  std::vector<char> is_known(place_.size(), 0);
  is_known[first] = 1;
  while (!waiting.empty()) {
    const std::uint32_t point = waiting.back();
    waiting.pop_back();
    for (std::uint32_t k = vertex_offset_[point]; k < vertex_offset_[point + 1]; ++k)
      found.push_back({vertex_[k], (place_[point] - place).norm()});
    for (std::uint32_t k = neighbour_offset_[point]; k < neighbour_offset_[point + 1]; ++k) {
      const std::uint32_t next = neighbour_[k];
      if (is_known[next] || (place_[next] - place).norm() > radius) continue;
      is_known[next] = 1;
      waiting.push_back(next);
    }
  }
  return found;
}

const PaintPlace* place_under(std::span<const PaintPlace> places, const Vector3d& place) {
  if (places.size() == 1) return places.data();
  const PaintPlace* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const PaintPlace& one : places) {
    const double distance = one.ground->distance_to(place - one.offset);
    if (distance < least) least = distance, best = &one;
  }
  return best;
}

bool reaches_too_many(const Brush& brush, std::span<const PaintPlace> grounds,
                      std::span<const std::array<double, 3>> places) {
  const std::size_t sides = brush.is_mirrored ? 2 : 1;
  std::size_t vertices = 0;
  for (const PaintPlace& one : grounds) vertices = std::max(vertices, one.ground->surface().vertices.size());
  // A place paints one character.
  if (sides * places.size() * vertices <= most_reached) return false;
  std::size_t reached = 0;
  for (const auto& of_page : places) {
    const Vector3d place(of_page[0], of_page[1], of_page[2]);
    const PaintPlace* under = place_under(grounds, place);
    if (under == nullptr || under->is_rigid) continue;
    const Vector3d own = place - under->offset;
    reached += under->ground->count_within(own, brush.radius);
    if (brush.is_mirrored) reached += under->ground->count_within(mirrored(own), brush.radius);
    if (reached > most_reached) return true;
  }
  return false;
}

Painting::Painting(std::shared_ptr<const PaintGround> ground, const rig::Paint& paint)
    : ground_(std::move(ground)) {
  const auto count = static_cast<std::uint32_t>(ground_->surface().vertices.size());
  for (const rig::PaintKind& kind : rig::paint_kinds()) {
    Sheet& sheet = sheets_.emplace_back();
    for (const rig::PaintedAttribute& own : ground_->own())
      sheet.has_own = sheet.has_own || (own.name == kind.name && own.width == kind.width);
    sheet.is_set.assign(count, 0);
    for (std::uint32_t v = 0; v < count; ++v)
      for (std::size_t c = 0; c < kind.width; ++c) sheet.values.push_back(own_value(kind, v, c));
  }
  for (const rig::PaintedVertices& painted : paint.attributes) {
    const rig::PaintKind& kind = *rig::find_paint_kind(painted.name);
    Sheet& sheet = sheet_of(kind);
    for (std::size_t k = 0; k < painted.vertex.size(); ++k) {
      sheet.is_set[painted.vertex[k]] = 1;
      for (std::size_t c = 0; c < kind.width; ++c)
        sheet.values[kind.width * painted.vertex[k] + c] = painted.value[kind.width * k + c];
    }
  }
}

Painting::Sheet& Painting::sheet_of(const rig::PaintKind& kind) {
  return sheets_[static_cast<std::size_t>(&kind - rig::paint_kinds().data())];
}
const Painting::Sheet& Painting::sheet_of(const rig::PaintKind& kind) const {
  return sheets_[static_cast<std::size_t>(&kind - rig::paint_kinds().data())];
}

float Painting::own_value(const rig::PaintKind& kind, std::uint32_t vertex, std::size_t component) const {
  for (const rig::PaintedAttribute& own : ground_->own())
    if (own.name == kind.name && own.width == kind.width)
      return static_cast<float>(own.values[own.width * vertex + component]);
  return static_cast<float>(kind.elsewhere);
}

void Painting::stamp(const Brush& brush, const Vector3d& place, const Vector3d& along) {
  const double away = ground_->distance_to(place);
  stamp_once(brush, place, along, away);
  // There may be no surface on the other side. A small brush reaches one vertex there if it does here.
  if (brush.is_mirrored) stamp_once(brush, mirrored(place), mirrored(along), away);
}

void Painting::stamp_once(const Brush& brush, const Vector3d& place, const Vector3d& along, double farthest) {
  Sheet& sheet = sheet_of(*brush.kind);
  const bool is_shaded = !brush.kind->is_whole && brush.kind->elsewhere != 0.0;
  for (const PaintGround::Reached& one : ground_->reached(place, brush.radius, farthest)) {
    if (brush.erases) {
      sheet.is_set[one.vertex] = 0;
      for (std::size_t c = 0; c < brush.kind->width; ++c)
        sheet.values[brush.kind->width * one.vertex + c] = own_value(*brush.kind, one.vertex, c);
      continue;
    }
    // A brush smaller than the mesh's triangles acts at full strength on the vertex that it reaches.
    const double way = one.distance < brush.radius ? one.distance / brush.radius : 0.0;
    const double share = brush.strength * share_of(brush.falloff, way);
    if (is_shaded || brush.kind->is_direction)
      mix(brush, one.vertex, share, along);
    else
      sheet.values[one.vertex] = brush.value, sheet.is_set[one.vertex] = 1;
  }
}

void Painting::mix(const Brush& brush, std::uint32_t vertex, double share, const Vector3d& along) {
  if (!(share > 0.0)) return;
  Sheet& sheet = sheet_of(*brush.kind);
  if (!brush.kind->is_direction) {
    const double before{sheet.values[vertex]};
    sheet.values[vertex] = static_cast<float>(before + share * (double{brush.value} - before));
    sheet.is_set[vertex] = 1;
    return;
  }
  // Fibres are tangential to the skin and have no sign: take the sign nearer to the present fibre.
  const Vector3d& normal = ground_->normal(vertex);
  Vector3d direction = along - along.dot(normal) * normal;
  if (!(direction.norm() > 1e-6 * along.norm())) return;
  direction.normalize();
  float* value = sheet.values.data() + 3 * std::size_t{vertex};
  const Vector3d before(double{value[0]}, double{value[1]}, double{value[2]});
  Vector3d after = direction;
  if (before.norm() > 0.0) {
    if (before.dot(direction) < 0.0) direction = -direction;
    after = (1.0 - share) * before.normalized() + share * direction;
  }
  if (!(after.norm() > 1e-6)) return;
  after.normalize();
  for (int axis = 0; axis < 3; ++axis) value[axis] = static_cast<float>(after[axis]);
  sheet.is_set[vertex] = 1;
}

rig::Paint Painting::paint() const {
  rig::Paint paint{ground_->hash(), ground_->surface().vertices.size(), {}};
  for (const rig::PaintKind& kind : rig::paint_kinds()) {
    const Sheet& sheet = sheet_of(kind);
    rig::PaintedVertices painted{kind.name, {}, {}};
    for (std::uint32_t v = 0; v < sheet.is_set.size(); ++v) {
      if (!sheet.is_set[v]) continue;
      painted.vertex.push_back(v);
      for (std::size_t c = 0; c < kind.width; ++c) painted.value.push_back(sheet.values[kind.width * v + c]);
    }
    if (!painted.vertex.empty()) paint.attributes.push_back(std::move(painted));
  }
  return paint;
}

std::vector<float> Painting::shown(const rig::PaintKind& kind) const {
  return sheet_of(kind).values;
}

bool Painting::has(const rig::PaintKind& kind) const {
  const Sheet& sheet = sheet_of(kind);
  return sheet.has_own ||
         std::any_of(sheet.is_set.begin(), sheet.is_set.end(), [](char c) { return c != 0; });
}

}  // namespace fascicle::studio
