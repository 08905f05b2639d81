#include "tests/support/contact_models.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <span>
#include <vector>

#include "host/model/contact_depth.h"
#include "host/model/contact_near.h"

namespace fascicle::tests {

using model::Model;

namespace {

std::set<std::uint32_t> boundary_vertices(const Model& m) {
  std::map<std::array<std::uint32_t, 3>, int> faces;
  for (std::size_t t = 0; t < m.tetrahedron.size(); t += 4)
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
      std::array<std::uint32_t, 3> face{};
      for (std::size_t k = 0; k < 3; ++k) face[k] = m.tetrahedron[t + (left_out + 1 + k) % 4];
      std::sort(face.begin(), face.end());
      ++faces[face];
    }
  std::set<std::uint32_t> vertices;
  for (const auto& [face, count] : faces)
    if (count == 1) vertices.insert(face.begin(), face.end());
  return vertices;
}

// Appends low x y z 0 and high x y z 0 of the tetrahedra from `first` on.
void append_rest_box(Model& m, std::size_t first, std::size_t count) {
  std::array<float, 3> low{}, high{};
  low.fill(std::numeric_limits<float>::infinity());
  high.fill(-std::numeric_limits<float>::infinity());
  const std::size_t end = std::min(4 * (first + count), m.contact_tetrahedron.size());
  for (std::size_t e = 4 * first; e < end; ++e)
    for (std::size_t a = 0; a < 3; ++a) {
      const float x = m.rest[3 * std::size_t{m.contact_tetrahedron[e]} + a];
      low[a] = std::min(low[a], x);
      high[a] = std::max(high[a], x);
    }
  for (const std::array<float, 3>& side : {low, high}) {
    m.contact_rest_box.insert(m.contact_rest_box.end(), side.begin(), side.end());
    m.contact_rest_box.push_back(0.0f);
  }
}

}  // namespace

void finish_contact(Model& m) {
  m.contact_number.assign(m.vertex_count, shader::no_contact);
  for (std::uint32_t p = 0; p < m.contact.size(); ++p) m.contact_number[m.contact[p].vertex] = p;
  std::vector<std::vector<std::uint32_t>> entries(m.vertex_count);
  for (std::uint32_t e = 0; e < m.contact_tetrahedron.size(); ++e)
    entries[m.contact_tetrahedron[e]].push_back(e);
  m.contact_offset = {0};
  m.contact_entry.clear();
  for (const auto& of_vertex : entries) {
    m.contact_entry.insert(m.contact_entry.end(), of_vertex.begin(), of_vertex.end());
    m.contact_offset.push_back(static_cast<std::uint32_t>(m.contact_entry.size()));
  }
  m.contact_rest_box.clear();
  for (const std::size_t size :
       {std::size_t{shader::contact_leaf}, std::size_t{shader::contact_leaf} * shader::contact_branch})
    for (std::size_t t = 0; t < m.contact_tetrahedron_count(); t += size) append_rest_box(m, t, size);
  double mass = 0.0;
  int free = 0;
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    if (!m.is_kinematic(i)) {
      mass += m.mass[i];
      ++free;
    }
  m.mobility.clear();
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    m.mobility.push_back(m.is_kinematic(i) ? 0.0f : static_cast<float>(mass / free / m.mass[i]));
}

void add_contact(Model& m, double margin, const std::function<double(std::uint32_t)>& depth_of_vertex,
                 double friction) {
  for (const std::uint32_t i : boundary_vertices(m))
    m.contact.push_back({.vertex = i,
                         .margin = static_cast<float>(margin),
                         .allowance = 0.0f,
                         .friction = static_cast<float>(friction),
                         .first_near = 0,
                         .near_count = 0});
  m.contact_tetrahedron = m.tetrahedron;
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    m.contact_depth.push_back(model::as_factor(depth_of_vertex(i)));
  finish_contact(m);
}

std::function<double(std::uint32_t)> depth_below_boundary(const Model& m) {
  const std::set<std::uint32_t> boundary = boundary_vertices(m);
  return [rest = m.rest, boundary](std::uint32_t i) {
    double least = std::numeric_limits<double>::infinity();
    for (const std::uint32_t j : boundary) {
      double squares = 0.0;
      for (std::size_t a = 0; a < 3; ++a) {
        const double apart = double{rest[3 * std::size_t{i} + a]} - double{rest[3 * std::size_t{j} + a]};
        squares += apart * apart;
      }
      least = std::min(least, std::sqrt(squares));
    }
    return least;
  };
}

void add_gap(Model& m, std::uint32_t p, const std::vector<std::uint32_t>& vertices, float allowance) {
  shader::ContactPoint& point = m.contact[p];
  std::vector<shader::VertexRun> runs;
  model::append_runs(vertices, runs);
  point.near_count = static_cast<std::uint32_t>(runs.size());
  point.allowance = allowance;
  m.contact_near.insert(m.contact_near.begin() + point.first_near, runs.begin(), runs.end());
  for (std::size_t k = p + 1; k < m.contact.size(); ++k) m.contact[k].first_near += point.near_count;
}

void ignore_some_contact(Model& m, unsigned seed) {
  std::mt19937 random(seed);
  m.contact_ignored.clear();
  m.contact_group.clear();
  // Every tetrahedron of every other leaf is in one common group.
  for (std::uint32_t t = 0; t < m.contact_tetrahedron_count(); ++t)
    m.contact_group.push_back((random() % 8 & 5U) | (t / shader::contact_leaf % 2 == 0 ? 2U : 0U));
  m.contact_group[0] |= 7U;
  for (std::uint32_t p = 0; p < m.contact.size(); ++p)
    m.contact_ignored.push_back(
        p < m.contact.size() / 4 ? 2U : static_cast<std::uint32_t>(random() % 8 & random() % 8));
  add_group_depths(m);
}

void add_group_depths(Model& m) {
  m.contact_depth.resize(m.vertex_count);
  const std::size_t count = model::contact_group_count(m);
  // Some deeper, some less deep than ungrouped.
  for (std::size_t group = 0; group < count; ++group)
    for (std::size_t i = 0; i < m.vertex_count; ++i)
      m.contact_depth.push_back((0.5f + 0.25f * static_cast<float>((i + group) % 4)) * m.contact_depth[i]);
}

Model without_contact(Model m) {
  m.contact.clear();
  m.contact_near.clear();
  m.contact_tetrahedron.clear();
  m.contact_depth.clear();
  m.contact_number.clear();
  m.contact_offset.clear();
  m.contact_entry.clear();
  m.contact_rest_box.clear();
  m.contact_ignored.clear();
  m.contact_group.clear();
  if (!m.has_limits()) m.mobility.clear();
  return m;
}

}  // namespace fascicle::tests
