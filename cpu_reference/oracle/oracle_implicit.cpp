#include "cpu_reference/oracle/oracle_implicit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "cpu_reference/oracle/oracle_tie.h"
#include "cpu_reference/oracle/oracle_weights.h"
#include "cpu_reference/oracle/points.h"

namespace fascicle::cpu_reference {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::Model;

namespace {

// Calls visit(face, n) for each triangle of the body's surface; n is its outward normal, with the area as
// length.
template <class Visit>
void for_each_surface_triangle(const Model& model, Visit visit) {
  struct Sides {
    int tetrahedra = 0;
    std::uint32_t opposite = 0;
  };
  std::map<std::array<std::uint32_t, 3>, Sides> faces;
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4)
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      std::array<std::uint32_t, 3> face{};
      for (std::size_t k = 0; k < 3; ++k) face[k] = model.tetrahedron[t + (opposite + 1 + k) % 4];
      std::sort(face.begin(), face.end());
      Sides& sides = faces[face];
      ++sides.tetrahedra;
      sides.opposite = model.tetrahedron[t + opposite];
    }
  for (const auto& [face, sides] : faces) {
    if (sides.tetrahedra != 1) continue;
    const Vector3d o = vector_at(model.rest, face[0]);
    const Vector3d n = (vector_at(model.rest, face[1]) - o).cross(vector_at(model.rest, face[2]) - o) / 2.0;
    visit(face, n.dot(vector_at(model.rest, sides.opposite) - o) > 0.0 ? Vector3d(-n) : n);
  }
}

// The mean of u u^T over the directions u that transmit stress at each vertex: I/3 inside; (I - N)/2 on the
// free surface, with N the area-weighted mean of n n^T over the surface's triangles at the vertex.
std::vector<Matrix3d> stress_directions(const Model& model) {
  std::vector<Matrix3d> normals(model.vertex_count, Matrix3d::Zero());
  std::vector<double> area(model.vertex_count, 0.0);
  for_each_surface_triangle(model, [&](const auto& face, const Vector3d& n) {
    for (const std::uint32_t v : face) {
      area[v] += n.norm();
      normals[v] += n.norm() * n.normalized() * n.normalized().transpose();
    }
  });
  // Under sliding skin, flesh ends at the tetrahedra with one corner in that skin.
  const std::vector<bool> slides = sliding_vertices(model);
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4) {
    std::vector<std::uint32_t> below;
    for (std::size_t k = t; k < t + 4; ++k)
      if (!slides[model.tetrahedron[k]]) below.push_back(model.tetrahedron[k]);
    if (below.size() != 3) continue;
    const Vector3d o = vector_at(model.rest, below[0]);
    const Vector3d n = (vector_at(model.rest, below[1]) - o).cross(vector_at(model.rest, below[2]) - o) / 2.0;
    for (const std::uint32_t v : below) {
      area[v] += n.norm();
      normals[v] += n * n.transpose() / n.norm();
    }
  }
  std::vector<Matrix3d> directions(model.vertex_count, Matrix3d::Identity() / 3.0);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (area[i] > 0.0) directions[i] = (Matrix3d::Identity() - normals[i] / area[i]) / 2.0;
  return directions;
}

// The tangents, as two columns, of the regions that are sheets (those of free vertices in sliding layers,
// with all members on the surface and in such layers): perpendicular to the mean normal of the surface within
// these layers. 0 for other regions.
std::vector<Eigen::Matrix<double, 3, 2>> sheet_tangents(const Model& model) {
  const std::vector<bool> slides = sliding_vertices(model);
  std::vector<Vector3d> normals(model.vertex_count, Vector3d::Zero());
  std::vector<bool> in_sheet(model.vertex_count);
  for_each_surface_triangle(model, [&](const auto& face, const Vector3d& n) {
    const bool all_slide = slides[face[0]] && slides[face[1]] && slides[face[2]];
    for (const std::uint32_t v : face) {
      in_sheet[v] = slides[v];
      if (all_slide) normals[v] += n;
    }
  });
  std::vector<Eigen::Matrix<double, 3, 2>> tangents(model.vertex_count, Eigen::Matrix<double, 3, 2>::Zero());
  for (std::uint32_t r = 0; r < model.vertex_count; ++r) {
    bool is_sheet = in_sheet[r] && !model.is_kinematic(r) && !normals[r].isZero(0.0);
    for (std::uint32_t e = model.ring_offset[r]; e < model.ring_offset[r + 1]; ++e)
      is_sheet = is_sheet && in_sheet[model.ring[e]];
    if (!is_sheet) continue;
    const Vector3d n = normals[r].normalized();
    tangents[r] << n.unitOrthogonal(), n.cross(n.unitOrthogonal());
  }
  return tangents;
}

}  // namespace

std::vector<double> region_stiffness(const Model& model) {
  std::vector<double> volume(model.vertex_count, 0.0);
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4) {
    const std::uint32_t* corner = &model.tetrahedron[t];
    const Vector3d o = vector_at(model.rest, corner[0]);
    const double v = (vector_at(model.rest, corner[1]) - o)
                         .cross(vector_at(model.rest, corner[2]) - o)
                         .dot(vector_at(model.rest, corner[3]) - o) /
                     6.0;
    for (int k = 0; k < 4; ++k) volume[corner[k]] += v / 4.0;
  }
  const std::vector<Matrix3d> directions = stress_directions(model);
  const std::vector<Eigen::Matrix<double, 3, 2>> tangents = sheet_tangents(model);
  std::vector<double> k(model.vertex_count);
  for (std::uint32_t r = 0; r < model.vertex_count; ++r) {
    Matrix3d S = Matrix3d::Zero();
    const auto add = [&](std::uint32_t i) {
      const Vector3d r_i = offset_from_mass_centre(model, i, r);
      S += model.mass[i] * r_i * r_i.transpose();
    };
    add(r);
    for (std::uint32_t e = model.ring_offset[r]; e < model.ring_offset[r + 1]; ++e) add(model.ring[e]);
    // k_r D S = V_r u u^T under the stress u u^T, where D is the deformation left after removing the region's
    // rotation: it stretches by u.D u = (V_r/k_r) u.S^-1 u. Lengths are in working units: V holds unit^3 and
    // S unit^2. In a sheet, both u and D lie in it.
    const Eigen::Matrix<double, 3, 2>& B = tangents[r];
    const double compliance = B.isZero(0.0) ? (directions[r] * S.inverse()).trace()
                                            : Eigen::Matrix2d(B.transpose() * S * B).inverse().trace() / 2.0;
    k[r] = model.youngs_modulus[r] * volume[r] * model.unit * compliance;
  }
  return k;
}

std::vector<double> vertex_stiffness(const Model& model, const std::vector<double>& region) {
  std::vector<double> K(model.vertex_count);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    double sum = region[i];
    for (std::uint32_t e = model.ring_offset[i]; e < model.ring_offset[i + 1]; ++e)
      sum += region[model.ring[e]];
    K[i] = sum * model.mass[i];
  }
  return K;
}

// y = (1 + b) q - b q_prev + H v_y,  (v_y - ((1 + b) v - b v_prev))/H = f - d (v_y - u).
Vector3d predicted_position(const VertexHistory& past, const Stepping& step, const Vector3d& f, double d,
                            const Vector3d& u) {
  const auto continued = [&](const Vector3d& now, const Vector3d& before) {
    return Vector3d((1.0 + step.second()) * now - step.second() * before);
  };
  const double H = step.length();
  const Vector3d v_y = (continued(past.v, past.v_before) + H * (f + d * u)) / (1.0 + d * H);
  return continued(past.q, past.q_before) + H * v_y;
}

// q + h v_s with v_s = v + s (c (v - v_prev) + (1 - c) h p f/|f|),  p = clamp((v - v_prev) . f / (h |f|), 0,
// |f|), damped like v_y. s is 1/2 for BDF2 and 1 for backward Euler: how far a constant acceleration moves a
// vertex beyond h v, in units of h^2 p. Without history v_s is v.
Vector3d start_of_iterations(const VertexHistory& past, const Stepping& step, const Vector3d& f, double d,
                             const Vector3d& u, double share) {
  Vector3d v = past.v;
  const double s = 0.5 * step.bdf2() + (1.0 - step.bdf2());
  if (step.has_history) v += s * share * (past.v - past.v_before);
  // An acceleration below 2^-20 counts as zero.
  if (step.has_history && f.squaredNorm() >= std::ldexp(1.0, -40)) {
    const double p = std::clamp((past.v - past.v_before).dot(f) / (step.h * f.norm()), 0.0, f.norm());
    v += s * (1.0 - share) * step.h * p * f.normalized();
  }
  return past.q + step.h * (v + d * step.length() * u) / (1.0 + d * step.length());
}

// a = K H^2 / (m (1 + d H) + K H^2)
Vector3d pulled_position(const Vector3d& y, const Vector3d& g, double mass, double stiffness, double d,
                         const Stepping& step) {
  const double H = step.length();
  const double inertia = mass * (1.0 + d * H), pull = stiffness * H * H;
  return (inertia * y + pull * g) / (inertia + pull);
}

// v = (1 - t) (q_new - q)/h + t (3 q_new - 4 q + q_prev)/(2h)
Vector3d differentiated_position(const Vector3d& q, const VertexHistory& past, const Stepping& step) {
  const double t = step.bdf2();
  return (1.0 - t) * (q - past.q) / step.h + t * (3.0 * q - 4.0 * past.q + past.q_before) / (2.0 * step.h);
}

// The gain shifts and scales [0, a] to [-rho, rho], and for a_N T_{N-1}(1/rho) = 20. If factors go down to -s
// a, taking the share 1/(1 + s a) of each pass maps them to [0, (a + s a)/(1 + s a)].
Chebyshev::Chebyshev(std::uint32_t steps, double largest, double overshoot)
    : iterations(steps), stiffest(largest), share(1.0 / (1.0 + overshoot * largest)) {
  const double slowest = (largest + overshoot * largest) * share;
  rho = std::min(1.0 / std::cosh(std::acosh(20.0) / double(steps - 1)), slowest / (2.0 - slowest));
}

double Chebyshev::gain(std::uint32_t k) const {
  return k + 1 == iterations ? share : share * (1.0 + rho);
}

double Chebyshev::extrapolated() const {
  const double least_rho = 1.0 / std::cosh(std::acosh(20.0) / double(iterations - 1));
  const double reached = 2.0 * least_rho / (1.0 + least_rho);
  return std::min(1.0, reached / (1.0 - reached) / (stiffest / (1.0 - stiffest)));
}

// omega_k = (2/rho) T_k(1/rho) / T_{k+1}(1/rho), but 1 at first, without an x_prev. With 1/rho = cosh t that
// becomes the following.
double Chebyshev::omega(std::uint32_t k) const {
  if (k == 0 || k + 1 == iterations) return 1.0;
  const double t = std::acosh(1.0 / rho);
  const auto power = [&](double n) { return std::exp(-2.0 * n * t); };
  return (1.0 + power(1)) * (1.0 + power(k)) / (1.0 + power(k + 1));
}

}  // namespace fascicle::cpu_reference
