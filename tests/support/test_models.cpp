#include "tests/support/test_models.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "cpu_reference/oracle/oracle.h"
#include "cpu_reference/oracle/oracle_implicit.h"

namespace fascicle::tests {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::Model;

namespace {

double volume_of(const Mesh& mesh, const std::array<std::uint32_t, 4>& t) {
  Matrix3d edges;
  for (int k = 0; k < 3; ++k) edges.col(k) = mesh.points[t[std::size_t(k) + 1]] - mesh.points[t[0]];
  return edges.determinant() / 6.0;
}

Vector3d rest_of(const Model& model, std::uint32_t i) {
  return Vector3d(model.rest[3 * i], model.rest[3 * i + 1], model.rest[3 * i + 2]);
}

void add_one_rings(Model& model, const Mesh& mesh) {
  std::vector<std::set<std::uint32_t>> rings(mesh.points.size());
  for (const auto& t : mesh.tetrahedra)
    for (std::uint32_t a : t)
      for (std::uint32_t b : t)
        if (a != b) rings[a].insert(b);
  model.ring_offset = {0};
  for (const auto& ring : rings) {
    model.ring.insert(model.ring.end(), ring.begin(), ring.end());
    model.ring_offset.push_back(std::uint32_t(model.ring.size()));
  }
}

// A render vertex for each boundary vertex, slightly inside one of its tetrahedra.
void add_surface(Model& model, const Mesh& mesh) {
  std::map<std::array<std::uint32_t, 3>, std::pair<int, std::array<std::uint32_t, 3>>> faces;
  for (const auto& t : mesh.tetrahedra) {
    const std::array<std::array<std::uint32_t, 3>, 4> outward{
        {{t[1], t[2], t[3]}, {t[0], t[3], t[2]}, {t[0], t[1], t[3]}, {t[0], t[2], t[1]}}};
    for (const auto& face : outward) {
      auto key = face;
      std::sort(key.begin(), key.end());
      ++faces[key].first;
      faces[key].second = face;
    }
  }
  std::map<std::uint32_t, std::uint32_t> render_vertex;
  for (const auto& [key, face] : faces) {
    if (face.first != 1) continue;
    for (std::uint32_t i : face.second) {
      render_vertex.try_emplace(i, std::uint32_t(render_vertex.size()));
      model.surface_triangle.push_back(render_vertex.at(i));
    }
  }
  model.surface_vertex.resize(4 * render_vertex.size());
  model.surface_weight.resize(4 * render_vertex.size());
  for (const auto& [i, number] : render_vertex) {
    const auto t =
        std::find_if(mesh.tetrahedra.begin(), mesh.tetrahedra.end(), [&, vertex = i](const auto& corners) {
          return std::find(corners.begin(), corners.end(), vertex) != corners.end();
        });
    for (std::size_t k = 0; k < 4; ++k) {
      model.surface_vertex[4 * number + k] = (*t)[k];
      model.surface_weight[4 * number + k] = (*t)[k] == i ? 0.625f : 0.125f;
    }
  }
}

}  // namespace

Mesh kuhn_bar(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz, double spacing) {
  Mesh mesh;
  for (std::uint32_t z = 0; z <= nz; ++z)
    for (std::uint32_t y = 0; y <= ny; ++y)
      for (std::uint32_t x = 0; x <= nx; ++x) mesh.points.push_back(spacing * Vector3d(x, y, z));
  const std::array<std::uint32_t, 3> stride{1, nx + 1, (nx + 1) * (ny + 1)};
  for (std::uint32_t z = 0; z < nz; ++z)
    for (std::uint32_t y = 0; y < ny; ++y)
      for (std::uint32_t x = 0; x < nx; ++x) {
        const std::uint32_t corner = x * stride[0] + y * stride[1] + z * stride[2];
        std::array<std::size_t, 3> axes{0, 1, 2};
        do {
          std::array<std::uint32_t, 4> t{corner, 0, 0, 0};
          for (std::size_t k = 0; k < 3; ++k) t[k + 1] = t[k] + stride[axes[k]];
          if (volume_of(mesh, t) < 0.0) std::swap(t[2], t[3]);
          mesh.tetrahedra.push_back(t);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
  return mesh;
}

Mesh jittered(Mesh mesh, double step, int reach, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> steps(-reach, reach);
  for (Vector3d& p : mesh.points)
    for (int k = 0; k < 3; ++k) p[k] += step * steps(random);
  return mesh;
}

Mesh regular_tetrahedron() {
  Mesh mesh;
  mesh.points = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  mesh.tetrahedra = {{0, 1, 2, 3}};
  if (volume_of(mesh, mesh.tetrahedra[0]) < 0.0) std::swap(mesh.tetrahedra[0][2], mesh.tetrahedra[0][3]);
  return mesh;
}

Model make_model(const Mesh& mesh, const BodyOptions& options) {
  Model model;
  const auto n = std::uint32_t(mesh.points.size());
  model.vertex_count = n;
  model.weight_form = options.weight_form;
  model.momentum_scaled = options.momentum_scaled;
  model.layers = {{"body", options.damping, options.density, false}};
  model.alpha.assign(n, options.alpha);
  model.beta.assign(n, options.beta);
  model.tag.assign(n, 0);
  model.mass.assign(n, 0.0);
  for (std::uint32_t i = 0; i < n; ++i) {
    model.source_vertex.push_back(i);
    for (int k = 0; k < 3; ++k) model.rest.push_back(float(mesh.points[i][k]));
    for (int k = 0; k < 3; ++k) model.fibre.push_back(float(options.fibre[k]));
    if (options.kinematic && options.kinematic(mesh.points[i])) make_kinematic(model, i);
  }
  for (const auto& t : mesh.tetrahedra) {
    for (std::uint32_t i : t) model.mass[i] += options.density * volume_of(mesh, t) / 4.0;
    model.tetrahedron.insert(model.tetrahedron.end(), t.begin(), t.end());
  }
  add_one_rings(model, mesh);
  add_surface(model, mesh);
  fill_weights(model);
  return model;
}

void make_kinematic(Model& model, std::uint32_t i) {
  model.tag[i] |= shader::tag_kinematic;
  model.alpha[i] = 0.0f;
}

Model make_implicit(Model model, double E) {
  model.youngs_modulus.assign(model.vertex_count, E);
  model.stiffness = cpu_reference::vertex_stiffness(model, cpu_reference::region_stiffness(model));
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) model.stiffness[i] /= model.mass[i];
  if (model.has_skeleton() && model.carried.empty()) model.carried.assign(model.vertex_count, 0.0f);
  fill_weights(model);
  return model;
}

void fill_weights(Model& model) {
  const cpu_reference::Oracle oracle(
      model, {.integrator =
                  model.is_implicit() ? model::Integrator::implicit_step : model::Integrator::explicit_step});
  const std::uint32_t n = model.vertex_count;
  const auto ring = [&](std::uint32_t i) {
    return std::vector<std::uint32_t>(model.ring.begin() + model.ring_offset[i],
                                      model.ring.begin() + model.ring_offset[i + 1]);
  };
  model.pull.assign(n, 0.0f);
  model.share_given.assign(model.ring.size(), 0.0f);
  model.share_taken.assign(model.ring.size(), 0.0f);
  model.region_rest.assign(4 * std::size_t{n}, 0.0f);

  std::vector<double> pull(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    pull[i] = oracle.weight(i, i);
    for (std::uint32_t r : ring(i)) pull[i] += oracle.weight(i, r);
    // Rounding down keeps the share of the vertex's own region non-negative.
    for (std::uint32_t e = model.ring_offset[i]; e < model.ring_offset[i + 1]; ++e)
      if (pull[i] > 0.0)
        model.share_given[e] =
            float(std::floor(oracle.weight(i, model.ring[e]) / pull[i] * 65536.0) / 65536.0);
  }
  const auto share_of_pair = [&](std::uint32_t i, std::uint32_t r) {
    double own = 1.0;
    for (std::uint32_t e = model.ring_offset[i]; e < model.ring_offset[i + 1]; ++e) {
      if (model.ring[e] == r) return double(model.share_given[e]);
      own -= double(model.share_given[e]);
    }
    return own;
  };

  // Fills region_rest for these pulls and returns |A_r| at rest.
  const auto fill_region = [&](std::uint32_t r, const auto& pulls) {
    const auto weight = [&](std::uint32_t i) { return double(pulls[i]) * share_of_pair(i, r); };
    double W = weight(r);
    Vector3d sum = Vector3d::Zero();
    for (std::uint32_t i : ring(r)) {
      W += weight(i);
      sum += weight(i) * (rest_of(model, i) - rest_of(model, r));
    }
    if (!(W > 0.0)) return 0.0;
    const Vector3d o = sum / W;
    for (int k = 0; k < 3; ++k) model.region_rest[4 * r + std::size_t(k)] = float(o[k]);
    model.region_rest[4 * r + 3] = float(1.0 / W);
    Matrix3d A = weight(r) * o * o.transpose();
    for (std::uint32_t i : ring(r)) {
      const Vector3d b = rest_of(model, i) - rest_of(model, r) - o;
      A += weight(i) * b * b.transpose();
    }
    return A.norm();
  };
  double moments = 0.0;
  for (std::uint32_t r = 0; r < n; ++r) {
    for (std::uint32_t e = model.ring_offset[r]; e < model.ring_offset[r + 1]; ++e)
      model.share_taken[e] = float(share_of_pair(model.ring[e], r));
    moments += fill_region(r, pull);
  }
  const double factor = moments > 0.0 ? n / moments : 1.0;
  for (std::uint32_t i = 0; i < n; ++i) model.pull[i] = float(pull[i] * factor);
  // Again with the rounded pulls: with rest centres that match them exactly, a body at rest stays at rest.
  for (std::uint32_t r = 0; r < n; ++r) fill_region(r, model.pull);
}

void add_volume(Model& model, float gain) {
  const std::uint32_t n = model.vertex_count;
  model.volume_gain.assign(n, 0.0f);
  model.region_volume.assign(3 * std::size_t{n}, 0.0f);
  for (std::uint32_t r = 0; r < n; ++r) {
    model.region_volume[3 * r + 1] = 1.0f;
    const Vector3d o(model.region_rest[4 * r], model.region_rest[4 * r + 1], model.region_rest[4 * r + 2]);
    Matrix3d A = Matrix3d::Zero();
    for (std::uint32_t e = model.ring_offset[r]; e < model.ring_offset[r + 1]; ++e) {
      const Vector3d b = rest_of(model, model.ring[e]) - rest_of(model, r);
      A += double(model.share_taken[e] * model.pull[model.ring[e]]) * b * (b - o).transpose();
    }
    const Eigen::JacobiSVD<Matrix3d> svd(A);
    if (!(svd.singularValues()[2] > 1e-3 * svd.singularValues()[0])) continue;
    const double size = std::cbrt(A.determinant());
    const Matrix3d inverse = size * A.inverse();
    model.volume_gain[r] = gain;
    model.region_volume[3 * r] = float(1.0 / size);
    model.region_volume[3 * r + 1] = float(inverse.squaredNorm());
    model.region_volume[3 * r + 2] = float(gain * inverse.squaredNorm() / inverse.trace());
  }
}

void add_skeleton(Model& model) {
  double low = rest_of(model, 0).x();
  double high = low;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    low = std::min(low, rest_of(model, i).x());
    high = std::max(high, rest_of(model, i).x());
  }
  model.joint_count = 2;
  model.skin_offset = {0};
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const double along = (rest_of(model, i).x() - low) / (high - low);
    // In steps of 1/64, so the two weights sum to exactly one.
    const double second = std::round(64.0 * std::clamp(2.0 * along - 0.5, 0.0, 1.0)) / 64.0;
    if (second < 1.0) {
      model.skin_joint.push_back(0);
      model.skin_weight.push_back(float(1.0 - second));
    }
    if (second > 0.0) {
      model.skin_joint.push_back(1);
      model.skin_weight.push_back(float(second));
    }
    model.skin_offset.push_back(std::uint32_t(model.skin_joint.size()));
  }
}

Model random_model(unsigned seed, std::uint32_t most_cells) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> normal;
  const auto chance = [&](double p) { return unit(random) < p; };
  const auto direction = [&] {
    return Vector3d(normal(random), normal(random), normal(random)).normalized();
  };
  const auto cells = [&] {
    const std::uint32_t least = most_cells > 3 ? most_cells / 2 : 1;
    return least + std::uint32_t(double(most_cells - least + 1) * unit(random));
  };

  const double spacing = 1.0 / 16.0;
  const std::uint32_t nx = cells(), ny = cells(), nz = cells();
  const Mesh mesh = jittered(kuhn_bar(nx, ny, nz, spacing), spacing / 64.0, 6, seed);
  BodyOptions options;
  options.weight_form = chance(0.25) ? model::WeightForm::kaneda2017 : model::WeightForm::symmetric;
  options.momentum_scaled = chance(0.75);
  Model model = make_model(mesh, options);
  model.layers = {{"muscle", chance(0.5) ? 0.0 : 6.0, 1050.0, false}, {"fat", 13.4, 920.0, false}};
  const double kinematic = chance(0.3) ? 0.0 : 0.3;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    model.tag[i] = chance(0.5) ? 1 : 0;
    // Formulas degenerate at the ends of the range, so take them often.
    model.alpha[i] = chance(0.1) ? 0.0f : chance(0.1) ? 1.0f : float(unit(random));
    model.beta[i] = chance(0.2) ? 0.0f : chance(0.2) ? 1.0f : float(unit(random));
    const Vector3d d = chance(0.1) ? Vector3d::Zero() : chance(0.2) ? Vector3d::UnitX() : direction();
    if (d.isZero(0.0)) model.beta[i] = 0.0f;
    for (int k = 0; k < 3; ++k) model.fibre[3 * i + std::size_t(k)] = float(d[k]);
    if (chance(kinematic)) make_kinematic(model, i);
  }
  fill_weights(model);
  if (chance(0.5)) add_skeleton(model);
  if (chance(0.5)) {
    model.muscle_count = 2;
    model.muscle_offset.push_back(0);
    for (std::uint32_t r = 0; r < model.vertex_count; ++r) {
      for (std::uint32_t muscle = 0; muscle < 2; ++muscle)
        if (chance(0.5))
          model.region_muscle.push_back({muscle, float(1.5 * unit(random)), float(0.5 * unit(random))});
      model.muscle_offset.push_back(std::uint32_t(model.region_muscle.size()));
      const Vector3d axis = direction();
      model.region_frame.push_back(region_frame(direction(), axis, axis.unitOrthogonal()));
    }
  }
  if (chance(0.5)) {
    model.force_count = 2;
    model.force_offset = {0};
    for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
      for (std::uint32_t f = 0; f < 2; ++f)
        if (chance(0.4)) {
          model.force_index.push_back(f);
          model.force_coefficient.push_back(float(unit(random)));
        }
      model.force_offset.push_back(std::uint32_t(model.force_index.size()));
    }
  }
  if (model.has_skeleton() && chance(0.5))
    for (std::uint32_t i = 0; i < model.vertex_count; ++i)
      model.carried.push_back(chance(0.2) ? 0.0f : chance(0.2) ? 1.0f : float(unit(random)));
  if (chance(0.5)) add_volume(model, float(3.0 * unit(random)));
  return model;
}

shader::RegionFrame region_frame(const Vector3d& normal, const Vector3d& axis, const Vector3d& around) {
  shader::RegionFrame frame{};
  float* const numbers[9] = {&frame.normal_x, &frame.normal_y, &frame.normal_z, &frame.axis_x,  &frame.axis_y,
                             &frame.axis_z,   &frame.around_x, &frame.around_y, &frame.around_z};
  for (int k = 0; k < 9; ++k) {
    const float x = float(k < 3 ? normal[k] : k < 6 ? axis[k - 3] : around[k - 6]);
    *numbers[k] = std::abs(x) < model::least_factor ? 0.0f : x;
  }
  return frame;
}

void add_muscle(Model& model, const Vector3d& normal, double bulge, double shear, std::uint32_t every) {
  model.muscle_count = 1;
  model.muscle_offset = {0};
  const Vector3d axis = normal.unitOrthogonal();
  for (std::uint32_t r = 0; r < model.vertex_count; ++r) {
    if (r % every == 0) model.region_muscle.push_back({0, float(bulge), float(shear)});
    model.muscle_offset.push_back(std::uint32_t(model.region_muscle.size()));
    model.region_frame.push_back(region_frame(normal, axis, normal.cross(axis)));
  }
}

model::Drive TestDrive::get() {
  drive.bones = bones;
  drive.muscles = muscles;
  drive.forces = forces;
  drive.colliders = colliders;
  drive.decay = decay;
  return drive;
}

TestDrive quiet_drive(const Model& model, double h, std::uint32_t substeps, const Vector3d& gravity) {
  TestDrive d;
  d.drive.substeps = substeps;
  d.drive.h = h;
  d.drive.origin = model.rest_origin;
  d.drive.gravity = {float(gravity.x()), float(gravity.y()), float(gravity.z())};
  d.bones.assign(std::size_t{substeps} * model.joint_count, identity_bone);
  d.muscles.assign(std::size_t{substeps} * model.muscle_count, shader::Muscle{0, 0, 0, 0, 0});
  d.forces.assign(std::size_t{substeps} * model.force_count, shader::Force{0, 0, 0, 0});
  d.colliders.assign(std::size_t{substeps} * model.collider_count, far_collider);
  for (const model::Layer& layer : model.layers) d.decay.push_back(float(std::exp(-layer.damping * h)));
  return d;
}

}  // namespace fascicle::tests
