#include "tests/support/bar_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "host/model/contact_near.h"
#include "tests/support/contact_models.h"
#include "tests/support/limit_models.h"

namespace fascicle::tests {
namespace {

using model::Model;

constexpr double spacing = 0.05;

// Ascending neighbours in Kuhn's division: two grid points share a tetrahedron if the components of their
// difference do not have mixed signs.
std::vector<std::set<std::uint32_t>> one_rings(const BarOptions& o) {
  const int nx = static_cast<int>(o.x), ny = static_cast<int>(o.y), nz = static_cast<int>(o.z);
  const auto number = [&](int i, int j, int k) { return static_cast<std::uint32_t>((i * ny + j) * nz + k); };
  std::vector<std::set<std::uint32_t>> rings(o.x * o.y * o.z);
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      for (int k = 0; k < nz; ++k)
        for (int step = 1; step < 8; ++step) {
          const int a = i + (step & 1), b = j + (step >> 1 & 1), c = k + (step >> 2 & 1);
          if (a >= nx || b >= ny || c >= nz) continue;
          rings[number(i, j, k)].insert(number(a, b, c));
          rings[number(a, b, c)].insert(number(i, j, k));
        }
  return rings;
}

// A pseudo-random value in [0, 1) that depends only on the pair.
double noise(std::uint32_t a, std::uint32_t b) {
  std::uint32_t h = (a + 1) * 2654435761u ^ (b + 1) * 2246822519u;
  h = (h ^ h >> 15) * 3266489917u;
  return static_cast<double>(h >> 8) * 0x1p-24;
}

void add_weights(Model& m) {
  const std::uint32_t n = m.vertex_count;
  m.share_given.resize(m.ring.size());
  m.share_taken.resize(m.ring.size());
  std::vector<double> own(n, 1.0);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t first = m.ring_offset[i], last = m.ring_offset[i + 1];
    double sum = 1.0;
    for (std::uint32_t e = first; e < last; ++e) sum += 0.1 + noise(i, m.ring[e]);
    for (std::uint32_t e = first; e < last; ++e) {
      const double share = std::floor((0.1 + noise(i, m.ring[e])) / sum * 65536.0) / 65536.0;
      m.share_given[e] = static_cast<float>(share);
      own[i] -= share;
    }
  }
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t e = m.ring_offset[i]; e < m.ring_offset[i + 1]; ++e) {
      const std::uint32_t r = m.ring[e];
      const auto back =
          std::lower_bound(m.ring.begin() + m.ring_offset[r], m.ring.begin() + m.ring_offset[r + 1], i);
      m.share_taken[static_cast<std::size_t>(back - m.ring.begin())] = m.share_given[e];
    }
  m.region_rest.assign(4 * std::size_t{n}, 0.0f);
  for (std::uint32_t r = 0; r < n; ++r) {
    double total = own[r] * static_cast<double>(m.pull[r]);
    std::array<double, 3> centre{};
    for (std::uint32_t e = m.ring_offset[r]; e < m.ring_offset[r + 1]; ++e) {
      const std::uint32_t i = m.ring[e];
      const double w = static_cast<double>(m.share_taken[e]) * static_cast<double>(m.pull[i]);
      total += w;
      for (std::size_t c = 0; c < 3; ++c)
        centre[c] += w * (static_cast<double>(m.rest[3 * std::size_t{i} + c]) -
                          static_cast<double>(m.rest[3 * std::size_t{r} + c]));
    }
    if (total <= 0.0) continue;
    for (std::size_t c = 0; c < 3; ++c)
      m.region_rest[4 * std::size_t{r} + c] = static_cast<float>(centre[c] / total);
    m.region_rest[4 * std::size_t{r} + 3] = static_cast<float>(1.0 / total);
  }
}

void add_skin(Model& m, double length) {
  m.joint_count = 2;
  m.skin_offset.push_back(0);
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    // Quarters are exact, so weights sum to one.
    const double along = std::clamp(static_cast<double>(m.rest[3 * std::size_t{i}]) / length, 0.0, 1.0);
    const double second = std::round(along * 4.0) / 4.0;
    if (second < 1.0) {
      m.skin_joint.push_back(0);
      m.skin_weight.push_back(static_cast<float>(1.0 - second));
    }
    if (second > 0.0) {
      m.skin_joint.push_back(1);
      m.skin_weight.push_back(static_cast<float>(second));
    }
    m.skin_offset.push_back(static_cast<std::uint32_t>(m.skin_joint.size()));
  }
}

// Ties each vertex of the top layer to a triangle of its neighbours below.
void add_ties(const BarOptions& o, Model& m) {
  std::vector<std::vector<std::pair<std::uint32_t, float>>> entries(m.vertex_count);
  for (std::uint32_t along = 1; along + 1 < o.x; ++along)
    for (std::uint32_t k = 0; k < o.z; ++k) {
      const auto at = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
        return (x * o.y + y) * o.z + z;
      };
      const auto t = static_cast<std::uint32_t>(m.tie.size());
      const std::uint32_t s = at(along, o.y - 1, k);
      const std::uint32_t corners[3] = {at(along, o.y - 2, k), at(along - 1, o.y - 2, k),
                                        at(along + 1, o.y - 2, (k + 1) % o.z)};
      m.tie.push_back({s, corners[0], corners[1], corners[2], 2.0f, along == 1 ? 0.0f : 1.0f, 0.5f,
                       0.9f * static_cast<float>(spacing)});
      entries[s].emplace_back(t, 0.5f);
      for (const std::uint32_t j : corners)
        if (!m.is_kinematic(j)) entries[j].emplace_back(t, 0.2f + 0.01f * static_cast<float>(t % 7));
    }
  m.tie_offset.push_back(0);
  for (const auto& of_vertex : entries) {
    for (const auto& [tie, coefficient] : of_vertex) {
      m.tie_index.push_back(tie);
      m.tie_coefficient.push_back(coefficient);
    }
    m.tie_offset.push_back(static_cast<std::uint32_t>(m.tie_index.size()));
  }
}

// Kuhn's six tetrahedra of each cube that spans `size` cells of the grid.
std::vector<std::uint32_t> kuhn_tetrahedra(const BarOptions& o, std::uint32_t size) {
  const std::array<std::array<std::size_t, 3>, 6> orders{
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
  std::vector<std::uint32_t> corners;
  for (std::uint32_t x = 0; x + size < o.x; ++x)
    for (std::uint32_t y = 0; y + size < o.y; ++y)
      for (std::uint32_t z = 0; z + size < o.z; ++z)
        for (std::size_t order = 0; order < 6; ++order) {
          std::array<std::uint32_t, 3> at{x, y, z};
          std::array<std::uint32_t, 4> corner{};
          corner[0] = (at[0] * o.y + at[1]) * o.z + at[2];
          for (std::size_t k = 0; k < 3; ++k) {
            at[orders[order][k]] += size;
            corner[k + 1] = (at[0] * o.y + at[1]) * o.z + at[2];
          }
          if (order >= 3) std::swap(corner[0], corner[1]);
          corners.insert(corners.end(), corner.begin(), corner.end());
        }
  return corners;
}

// Skips tetrahedra that the noise inverted.
void add_limited_tetrahedra(const BarOptions& o, Model& m) {
  m.tetrahedron = kuhn_tetrahedra(o, 1);
  add_limits(m, 0.9);
}

// Tetrahedra span two cells, so they contain points that are not their corners. Margins are so small that any
// bending exceeds them. A third of the points may touch their surroundings from the start.
void add_contacts(const BarOptions& o, Model& m) {
  m.contact_tetrahedron = kuhn_tetrahedra(o, 2);
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    m.contact_depth.push_back(static_cast<float>(0.04 * noise(i, 7)));
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    if (i % 11 == 10) continue;
    std::vector<std::uint32_t> near;
    for (std::uint32_t j = 0; i % 3 == 1 && j < o.x * o.y * o.z; ++j) {
      const auto apart = [&](std::uint32_t each, std::uint32_t count) {
        const std::uint32_t a = i / each % count, b = j / each % count;
        return a < b ? b - a : a - b;
      };
      if (apart(o.y * o.z, o.x) <= 1 && apart(o.z, o.y) <= 2 && apart(1, o.z) <= 2) near.push_back(j);
    }
    m.contact.push_back({.vertex = i,
                         .margin = 1e-5f * static_cast<float>(1 + i % 5),
                         .allowance = near.empty() ? 0.0f : 0.01f * static_cast<float>(i % 4),
                         .friction = 0.25f * static_cast<float>(i % 4),
                         .first_near = static_cast<std::uint32_t>(m.contact_near.size()),
                         .near_count = 0});
    model::append_runs(near, m.contact_near);
    shader::ContactPoint& point = m.contact.back();
    point.near_count = static_cast<std::uint32_t>(m.contact_near.size()) - point.first_near;
  }
  finish_contact(m);
  if (o.ignored_contact) ignore_some_contact(m, 3);
}

// Four solids; each ignores some vertices.
constexpr std::uint32_t solid_count = 4;
void add_colliders(Model& m) {
  m.collider_count = solid_count;
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    m.spared.push_back(i % 7 == 3 ? 1U << i / 7 % solid_count : 0U);
}

// A rotation about z by twice the angle whose tangent is t (needs no sine), then a fixed rotation about x.
struct Turn {
  double rows[3][3];
};
Turn turned(double t) {
  const double c = (1.0 - t * t) / (1.0 + t * t), s = 2.0 * t / (1.0 + t * t);
  return {{{c, s, 0.0}, {-0.8 * s, 0.8 * c, 0.6}, {0.6 * s, -0.6 * c, 0.8}}};
}

// Writes a map, as three rows of four, from positions relative to `origin` into the space of a solid about
// `center`.
void write_map(const Turn& turn, const std::array<double, 3>& center, const std::array<double, 3>& origin,
               float* rows) {
  for (const auto& row : turn.rows) {
    double shift = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      *rows++ = static_cast<float>(row[c]);
      shift += row[c] * (origin[c] - center[c]);
    }
    *rows++ = static_cast<float>(shift);
  }
}

// The centre of solid k at time t, in frames. The bar falls onto some solids and overlaps others at the
// start.
std::array<double, 3> center_of(std::uint32_t k, double t) {
  switch (k) {
    case 0:  // the plane
      return {0.0, 0.005 * t - 0.02, 0.0};
    case 1:
      return {0.1 + 0.002 * t, 0.01, 0.02 + 0.004 * t};
    case 2:
      return {0.15 + 0.003 * t, 0.09, 0.05};
    default:
      return {0.3, 0.22 - 0.012 * t, 0.2 - 0.01 * t};
  }
}

}  // namespace

Model make_bar(const BarOptions& o) {
  std::vector<std::set<std::uint32_t>> rings = one_rings(o);
  const auto grid = static_cast<std::uint32_t>(rings.size());
  if (o.odd_vertices) rings.resize(grid + 2);
  Model m;
  m.vertex_count = static_cast<std::uint32_t>(rings.size());
  m.layers = {{"muscle", 1.0, 1000.0, false}, {"fat", 6.0, 900.0, false}};
  m.ring_offset.push_back(0);
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    const std::uint32_t k = i % o.z, j = i / o.z % o.y, along = std::min(i, grid - 1) / (o.y * o.z);
    const bool free = along > 0;
    for (const std::uint32_t c : {along, j, k})
      m.rest.push_back(static_cast<float>(spacing * (c + 0.3 * noise(i, 100 + c))));
    m.source_vertex.push_back(i);
    m.mass.push_back(0.1);
    m.alpha.push_back(free ? (i % 2 ? 0.3f : 0.9f) : 0.0f);
    m.beta.push_back(0.5f);
    m.fibre.insert(m.fibre.end(), {1.0f, 0.0f, 0.0f});
    m.tag.push_back(i % 2 | (free ? 0 : shader::tag_kinematic));
    m.pull.push_back(i + 1 == m.vertex_count && o.odd_vertices ? 0.0f : 200.0f + static_cast<float>(i % 7));
    m.ring.insert(m.ring.end(), rings[i].begin(), rings[i].end());
    m.ring_offset.push_back(static_cast<std::uint32_t>(m.ring.size()));
  }
  add_weights(m);
  if (o.skeleton) add_skin(m, spacing * (o.x - 1));
  if (o.carried)
    for (std::uint32_t i = 0; i < m.vertex_count; ++i) m.carried.push_back(0.5f * static_cast<float>(i % 3));
  if (o.muscle) {
    m.muscle_count = 2;
    m.muscle_offset.push_back(0);
    for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
      for (std::uint32_t k = 0; k < i % 3; ++k) m.region_muscle.push_back({k, 0.5f, 0.25f});
      m.muscle_offset.push_back(static_cast<std::uint32_t>(m.region_muscle.size()));
      m.region_frame.push_back({0.0f, 0.6f, 0.8f, 1.0f, 0.0f, 0.0f, 0.0f, -0.8f, 0.6f});
    }
  }
  if (o.volume) {
    for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
      // Estimates a moment's size from its trace. Half of the estimates are slightly off, so these regions
      // push even at rest.
      float size = 0.0f;
      for (std::uint32_t e = m.ring_offset[i]; e < m.ring_offset[i + 1]; ++e)
        size += m.share_taken[e] * m.pull[m.ring[e]] * static_cast<float>(spacing * spacing);
      const bool some = i % 3 != 2 && size > 0.0f;
      m.volume_gain.push_back(some ? 2.0f : 0.0f);
      m.region_volume.insert(m.region_volume.end(),
                             {some ? 1.5f / size : 0.0f, some ? 4.0f : 1.0f, some ? 2.5f : 0.0f});
    }
  }
  if (o.ties) add_ties(o, m);
  if (o.forces) {
    m.force_count = 2;
    m.force_offset.push_back(0);
    for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
      for (std::uint32_t f = 0; f < i % 3; ++f) {
        m.force_index.push_back(f);
        m.force_coefficient.push_back(0.7f + static_cast<float>(i % 5));
      }
      m.force_offset.push_back(static_cast<std::uint32_t>(m.force_index.size()));
    }
  }
  if (o.surface) {
    for (std::uint32_t s = 0; s < 37; ++s) {
      for (std::uint32_t c = 0; c < 4; ++c) m.surface_vertex.push_back((s * 11 + c * 5) % m.vertex_count);
      m.surface_weight.insert(m.surface_weight.end(), {0.1f, 0.2f, 0.3f, 0.4f});
    }
  }
  if (o.implicit) {
    for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
      m.youngs_modulus.push_back(1e4);
      // With the tests' time steps, `a` ranges from below one half to values that round to 1.
      m.stiffness.push_back(std::ldexp(1.0, static_cast<int>(i % 40)));
    }
    if (o.skeleton && m.carried.empty()) m.carried.assign(m.vertex_count, 0.0f);
  }
  if (o.limits) add_limited_tetrahedra(o, m);
  if (o.contact) add_contacts(o, m);
  if (o.colliders) add_colliders(m);
  return m;
}

void BarMotion::append_pose(double time, float jump, std::vector<shader::Bone>& to) const {
  const auto t = static_cast<float>(time / substeps_);
  for (std::uint32_t j = 0; j < model_.joint_count; ++j) {
    // A shear instead of a rotation: any affine map will do, and this one needs no sine.
    const float bend = j == 1 ? 0.02f * t + jump : 0.0f;
    to.push_back({1.0f, 0.0f, bend, 0.01f * t + jump, bend, 1.0f, 0.0f, 0.0f, 0.0f, -bend, 1.0f, 0.005f * t,
                  9.81f * bend, 0.1f * bend, -bend, 0.0f});
  }
}

// The motion of the solids during the substep that ends at `time`, in substeps.
void BarMotion::append_colliders(double time) {
  for (std::uint32_t k = 0; k < model_.collider_count; ++k) {
    shader::Collider& solid = colliders_.emplace_back();
    for (const bool at_end : {false, true}) {
      const double t = (at_end ? time : time - 1.0) / substeps_;
      write_map(turned(k == 0 ? -0.05 : 0.01 * k * t), center_of(k, t), origin_,
                at_end ? &solid.xx : &solid.before_xx);
    }
    solid.is_plane = k == 0 ? 1.0f : 0.0f;
    solid.radius = k == 0 ? 0.005f : k == 3 ? 0.01f : 0.03f;
    solid.half_y = k >= 2 ? 0.05f : 0.0f;
    solid.half_x = solid.half_z = k == 3 ? 0.04f : 0.0f;
    solid.friction = 0.3f * static_cast<float>(k);
    solid.lifted = 0.02f;
  }
}

model::Drive BarMotion::drive(std::uint64_t frame) {
  bones_.clear();
  muscles_.clear();
  forces_.clear();
  for (std::uint32_t s = 0; s < substeps_; ++s) {
    const float t = static_cast<float>((frame - 1) * substeps_ + s + 1) / static_cast<float>(substeps_);
    // In every five frames the motion jumps in frame 3, after its first substep, and jumps back in frame 5.
    const bool jumped = cuts_ && (frame % 5 == 4 || (frame % 5 == 3 && s > 0));
    append_pose(static_cast<double>((frame - 1) * substeps_ + s + 1), jumped ? 0.25f : 0.0f, bones_);
    for (std::uint32_t k = 0; k < model_.muscle_count; ++k)
      muscles_.push_back({0.01f * t, 0.08f * t, 0.06f * t, 0.05f * t * static_cast<float>(k + 1), 0.1f * t});
    for (std::uint32_t f = 0; f < model_.force_count; ++f)
      forces_.push_back({0.3f * t, -0.2f, 0.1f * static_cast<float>(f), 0.0f});
  }
  decay_ = {0.999f, 0.95f};
  model::Drive drive;
  drive.substeps = substeps_;
  drive.h = 1.0 / 60.0 / substeps_;
  drive.gravity = {0.0f, -9.81f, 0.0f};
  if (model_.has_skeleton() && frame % 2 == 0 && !(cuts_ && frame % 5 == 0)) {
    drive.origin_shift = {0.0078125f, 0.0f, -0.001f};
    for (std::size_t c = 0; c < 3; ++c) origin_[c] += static_cast<double>(drive.origin_shift[c]);
  }
  poses_of_cuts_.clear();
  cut_list_.clear();
  if (cuts_ && (frame % 5 == 3 || frame % 5 == 0)) {
    const bool leaves = frame % 5 == 3;
    const std::uint32_t substep = leaves ? 1 : 0;
    const auto at = static_cast<double>((frame - 1) * substeps_ + substep);
    append_pose(at - 1.0, leaves ? 0.0f : 0.25f, poses_of_cuts_);
    append_pose(at, leaves ? 0.0f : 0.25f, poses_of_cuts_);
    append_pose(at, leaves ? 0.25f : 0.0f, poses_of_cuts_);
    append_pose(at + 1.0, leaves ? 0.25f : 0.0f, poses_of_cuts_);
    const auto pose = [&](std::size_t k) {
      return std::span<const shader::Bone>(poses_of_cuts_)
          .subspan(k * model_.joint_count, model_.joint_count);
    };
    cut_list_.push_back({substep, origin_, pose(0), pose(1), pose(2), pose(3)});
    drive.origin_shift = {0.0f, 0.0f, 0.0f};
  }
  // Relative to the frame's origin, which is only known now.
  colliders_.clear();
  for (std::uint32_t s = 0; s < substeps_; ++s)
    append_colliders(static_cast<double>((frame - 1) * substeps_ + s + 1));
  drive.colliders = colliders_;
  drive.cuts = cut_list_;
  drive.origin = origin_;
  drive.bones = bones_;
  drive.muscles = muscles_;
  drive.forces = forces_;
  drive.decay = decay_;
  return drive;
}

}  // namespace fascicle::tests
