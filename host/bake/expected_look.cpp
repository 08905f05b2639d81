#include "host/bake/expected_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <queue>
#include <utility>

#include "host/bake/look.h"
#include "host/bake/look_report.h"
#include "host/bake/points.h"
#include "host/base/text.h"
#include "host/drive/felt_acceleration.h"
#include "host/drive/lead_in.h"
#include "host/model/overlap.h"

namespace fascicle::bake {

using scene::Vector3d;

namespace {

constexpr std::size_t slices = 16;  // per column

// Mean edge length around each vertex of the tetrahedral mesh, m.
std::vector<double> mean_edges(const model::Model& model) {
  std::vector<double> edges(model.vertex_count, 0.0);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const std::uint32_t first = model.ring_offset[i], last = model.ring_offset[i + 1];
    for (std::uint32_t e = first; e < last; ++e)
      edges[i] += length(difference(point_at(model.rest, i), point_at(model.rest, model.ring[e])));
    if (last > first) edges[i] *= model.unit / static_cast<double>(last - first);
  }
  return edges;
}

// Length of the path through the flesh from each vertex to the nearest one that follows the skeleton, m;
// infinite if there is none.
std::vector<double> depths(const model::Model& model) {
  std::vector<double> depth(model.vertex_count, INFINITY);
  using Reached = std::pair<double, std::uint32_t>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> next;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (model.is_kinematic(i)) next.emplace(depth[i] = 0.0, i);
  while (!next.empty()) {
    const auto [d, i] = next.top();
    next.pop();
    if (d > depth[i]) continue;
    for (std::uint32_t e = model.ring_offset[i]; e < model.ring_offset[i + 1]; ++e) {
      const std::uint32_t j = model.ring[e];
      const double way =
          d + length(difference(point_at(model.rest, i), point_at(model.rest, j))) * model.unit;
      if (way < depth[j]) next.emplace(depth[j] = way, j);
    }
  }
  return depth;
}

// Pa. Flesh that moves alpha of the way to its goal in a substep h has modulus alpha rho e^2 / (3 h^2),
// because K_i / m_i for regions of modulus E is 3 E / (rho e^2) if edges e are uniform (build/stiffness.h).
std::vector<double> shear_moduli(const model::Model& model, double h) {
  std::vector<double> moduli(model.vertex_count, 0.0);
  const std::vector<double> edges = model.is_implicit() ? std::vector<double>{} : mean_edges(model);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const double density = model.layers[model.layer_of(i)].density;
    const double youngs = model.is_implicit()
                              ? model.youngs_modulus[i]
                              : double{model.alpha[i]} * density * edges[i] * edges[i] / (3.0 * h * h);
    moduli[i] = youngs / 3.0;
  }
  return moduli;
}

// The flesh of a joint as an oscillator: at rest its skin is displaced by compliance times the acceleration.
struct Swing {
  std::uint32_t joint = 0, layer = 0;
  double compliance = 0.0;  // s^2, at its representative skin vertex
  double damping = 0.0;     // 1/s
  double felt = 1.0;        // share of the skeleton's acceleration
  double per_metre = 0.0;   // score per metre of displacement
};

struct Flesh {
  std::vector<std::uint32_t> vertices;  // free only
  std::vector<std::size_t> skin;        // render vertices
};

// Compliance of a joint's flesh by depth above the vertices that follow the skeleton.
struct Column {
  double slice = 0.0;                             // thickness, m
  std::array<double, slices> yield{};             // rho / G per slice, s^2/m^2
  std::array<std::vector<double>, slices> share;  // of yield, by layer
};

Column column_of(const model::Model& model, const std::vector<std::uint32_t>& vertices,
                 const std::vector<double>& depth, const std::vector<double>& shear) {
  Column column;
  for (const std::uint32_t i : vertices) column.slice = std::max(column.slice, depth[i]);
  column.slice *= (1.0 + 1e-9) / static_cast<double>(slices);
  std::array<double, slices> count{};
  for (std::vector<double>& share : column.share) share.assign(model.layers.size(), 0.0);
  for (const std::uint32_t i : vertices) {
    const auto k = static_cast<std::size_t>(depth[i] / column.slice);
    const double one = model.layers[model.layer_of(i)].density / std::max(shear[i], 1e-30);
    column.yield[k] += one;
    column.share[k][model.layer_of(i)] += one;
    count[k] += 1.0;
  }
  // A slice without vertices copies the one below it. Slices below the first free vertex, which is one edge
  // away from those that follow the skeleton, copy that vertex's slice.
  const auto first = static_cast<std::size_t>(
      std::find_if(count.begin(), count.end(), [](double n) { return n > 0.0; }) - count.begin());
  for (std::size_t k = first; k < slices; ++k) {
    if (count[k] > 0.0) {
      for (double& share : column.share[k]) share /= count[k];
      column.yield[k] /= count[k];
    } else {
      column.yield[k] = column.yield[k - 1];
      column.share[k] = column.share[k - 1];
    }
  }
  for (std::size_t k = 0; k < first; ++k) {
    column.yield[k] = column.yield[first];
    column.share[k] = column.share[first];
  }
  return column;
}

// visit(slice, weight): compliance at `depth` is the sum of weight x yield.
template <class Visit>
void for_each_slice(const Column& column, double depth, Visit visit) {
  for (std::size_t k = 0; k < slices; ++k) {
    const double from = static_cast<double>(k) * column.slice;
    if (!(from < depth)) return;
    const double to = std::min(depth, from + column.slice);
    visit(k, (depth - 0.5 * (from + to)) * (to - from));
  }
}

double compliance_at(const Column& column, double depth) {
  double compliance = 0.0;
  for_each_slice(column, depth,
                 [&](std::size_t k, double weight) { compliance += weight * column.yield[k]; });
  return compliance;
}

std::uint32_t softest_layer(const Column& column, double depth) {
  std::vector<double> sum(column.share[0].size(), 0.0);
  for_each_slice(column, depth, [&](std::size_t k, double weight) {
    for (std::size_t l = 0; l < sum.size(); ++l) sum[l] += weight * column.share[k][l];
  });
  return static_cast<std::uint32_t>(std::max_element(sum.begin(), sum.end()) - sum.begin());
}

std::vector<Swing> swings_of(const model::Model& model, const LookBody& body, double h) {
  const std::vector<double> depth = depths(model), shear = shear_moduli(model, h);
  std::vector<Flesh> flesh(model.joint_count);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (!model.is_kinematic(i) && model.skin_offset[i] < model.skin_offset[i + 1] && std::isfinite(depth[i]))
      flesh[drive::main_joint(model, i)].vertices.push_back(i);
  for (std::size_t s = 0; s < body.joint.size(); ++s) flesh[body.joint[s]].skin.push_back(s);

  std::vector<Swing> swings;
  for (std::uint32_t j = 0; j < flesh.size(); ++j) {
    const auto& [vertices, skin] = flesh[j];
    if (vertices.empty() || skin.size() < least_skin_vertices) continue;
    std::vector<double> skin_depth;
    for (const std::size_t s : skin) {
      double d = 0.0;
      for (std::size_t k = 4 * s; k < 4 * s + 4; ++k)
        d += double{model.surface_weight[k]} * depth[model.surface_vertex[k]];
      skin_depth.push_back(std::isfinite(d) ? std::max(d, 0.0) : 0.0);
    }
    const Column column = column_of(model, vertices, depth, shear);
    Swing swing{.joint = j};
    double mass = 0.0, felt = 0.0;
    for (const std::uint32_t i : vertices) {
      mass += model.mass[i];
      swing.damping += model.mass[i] * model.layers[model.layer_of(i)].damping;
      felt += model.mass[i] * (model.carried.empty() ? 1.0 : 1.0 - double{model.carried[i]});
    }
    swing.damping /= mass;
    swing.felt = felt / mass;
    // Represent the skin by the vertex whose swing, in thicknesses, this share of the skin exceeds.
    std::vector<std::pair<double, std::size_t>> ratios;
    for (std::size_t k = 0; k < skin.size(); ++k)
      ratios.emplace_back(compliance_at(column, skin_depth[k]) / body.thickness[skin[k]], k);
    for (const auto& [share, limit] :
         {std::pair{0.5, half_distance_limit}, std::pair{0.1, tenth_distance_limit}}) {
      const auto at =
          ratios.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(ratios.size()));
      std::nth_element(ratios.begin(), at, ratios.end(), std::greater<>());
      swing.compliance = compliance_at(column, skin_depth[at->second]);
      swing.layer = softest_layer(column, skin_depth[at->second]);
      swing.per_metre = 1.0 / (limit * body.thickness[skin[at->second]] * model.unit);
      if (swing.compliance > 0.0) swings.push_back(swing);
    }
  }
  return swings;
}

// z'' = thrown - damping z' - z / compliance, with the mean acceleration of each step (stable at any step
// length).
struct Oscillator {
  Vector3d place = Vector3d::Zero(), speed = Vector3d::Zero(), acceleration = Vector3d::Zero();

  void step(const Vector3d& thrown, double compliance, double damping, double h) {
    const Vector3d drift = place + h * speed + 0.25 * h * h * acceleration;
    const Vector3d pace = speed + 0.5 * h * acceleration;
    acceleration = (thrown - damping * pace - drift / compliance) /
                   (1.0 + 0.5 * h * damping + 0.25 * h * h / compliance);
    place = drift + 0.25 * h * h * acceleration;
    speed = pace + 0.5 * h * acceleration;
  }
};

}  // namespace

std::optional<ExpectedLook> expected_look(const scene::Scene& scene, const model::Model& model,
                                          const LookBody& body, drive::DriveSource& drives,
                                          const drive::DriveSource::GoesOn& goes_on) {
  const double h = 1.0 / (scene.fps * drives.substeps());
  const std::vector<Swing> swings = swings_of(model, body, h);
  if (swings.empty()) return std::nullopt;
  std::vector<std::vector<Vector3d>> throws(swings.size());
  drives.for_each_throw(
      [&](const std::vector<drive::DriveSource::Throw>& of_joint) {
        for (std::size_t k = 0; k < swings.size(); ++k) {
          const drive::DriveSource::Throw& thrown = of_joint[swings[k].joint];
          throws[k].push_back(thrown.gravity + swings[k].felt * thrown.inertia);
        }
      },
      goes_on);
  const auto is_stopped = [&] { return goes_on && !goes_on(); };
  const auto swing_through = [&](std::size_t k, double stiffer) {
    const Swing& swing = swings[k];
    ExpectedLook look{.joint = swing.joint, .layer = swing.layer};
    Oscillator flesh;
    for (std::size_t s = 0; s < throws[k].size(); ++s) {
      if (s == 0) flesh.place = swing.compliance / stiffer * throws[k][0];
      flesh.step(throws[k][s], swing.compliance / stiffer, swing.damping, h);
      const double score = flesh.place.norm() * swing.per_metre;
      if (score <= look.score) continue;
      look.score = score;
      look.frame = s / drives.substeps() + 1;
    }
    return look;
  };
  std::vector<ExpectedLook> looks;
  ExpectedLook worst;
  for (std::size_t k = 0; k < swings.size(); ++k) {
    if (is_stopped()) return std::nullopt;
    looks.push_back(swing_through(k, 1.0));
    if (looks.back().score > worst.score) worst = looks.back();
  }
  // Stiffer flesh may swing further if that brings it closer to resonance with the clip, so the factor rises
  // in small steps.
  constexpr double step = 1.25, most = 1e4;
  const auto is_over = [&](double stiffer) {
    for (std::size_t k = 0; k < swings.size(); ++k)
      if (looks[k].score > 1.0 && swing_through(k, stiffer).score > 1.0) return true;
    return false;
  };
  while (worst.stiffer < most && worst.score > 1.0 && is_over(worst.stiffer)) {
    if (is_stopped()) return std::nullopt;
    worst.stiffer *= step;
  }
  return worst;
}

std::string expected_look_warning(const scene::Scene& scene, const model::Model& model,
                                  const ExpectedLook& expected) {
  const auto& character = std::get<rig::Character>(scene.geometry);
  const std::string layer = "layers." + model.layers[expected.layer].name;
  return layer + ": is too soft for this clip: the flesh at joint \"" +
         character.skeleton[expected.joint].name + "\" is expected to swing to " +
         base::short_text(expected.score) + " times the limit of what looks right, in frame " +
         base::number_text(expected.frame) + "; " +
         base::short_text(std::ceil(10.0 * expected.stiffer) / 10.0) +
         " times stiffer layers would be enough (" +
         (model.is_implicit() ? "--softness, or " + layer + ".youngs_modulus" : layer + ".alpha") +
         "), or more damping, or a lower " + layer + ".inertia_scale";
}

std::string tried_look_warning(const scene::Scene& scene, const TriedLook& tried) {
  const auto& skeleton = std::get<rig::Character>(scene.geometry).skeleton;
  return "frames " + base::number_text(tried.first + 1) + " to " + base::number_text(tried.last) +
         " were tried before the bake and look wrong: " +
         look_warning(tried.cause, tried.worst, skeleton[tried.worst.joint].name, tried.frame,
                      tried.frames_over, tried.driven);
}

TriedFrames frames_to_try(const scene::Scene& scene, std::uint64_t frame) {
  const auto frames_of = [&](double seconds) {
    return static_cast<std::uint64_t>(std::ceil(seconds * scene.fps));
  };
  return {.first = frame > frames_of(tried_before) ? frame - frames_of(tried_before) : 0,
          .last = std::min(frame + frames_of(tried_after), scene::cycle_frames(scene)),
          .settling = frames_of(tried_before / 2.0)};
}

TriedLook try_look(const scene::Scene& scene, const model::Model& model, const LookBody& body,
                   drive::DriveSource& drives, model::Solver& solver, const TriedFrames& frames,
                   const std::function<bool(const TriedLook&)>& goes_on) {
  TriedLook tried;
  tried.first = frames.first;
  tried.last = frames.last;
  const bool is_led = frames.first == 0 && frames.has_lead_in;
  if (is_led) {
    std::optional<scene::Scene> once;
    if (scene.motion.seamless) once.emplace(scene).motion.seamless = false;
    drive::lead_in(once ? *once : scene, model, drives, solver, [&] { return goes_on && !goes_on(tried); });
  } else {
    solver.load(frames.first == 0 ? drives.initial_state() : drives.state_on_skeleton(frames.first));
  }
  Look look(model, body, scene.fps);
  std::optional<model::OverlapMeter> overlap;
  for (std::uint64_t k = frames.first + 1; k <= frames.last; ++k) {
    if (goes_on && !goes_on(tried)) {
      tried.last = k - 1;
      break;
    }
    solver.submit(drives.drive(k), {.positions = true, .skinned = true});
    const model::Frame seen = solver.collect();
    tried.is_finite =
        std::all_of(seen.positions.begin(), seen.positions.end(), [](float x) { return std::isfinite(x); });
    if (!tried.is_finite) {
      tried.last = k;
      break;
    }
    // Flesh that starts on the skeleton has to settle first.
    if (frames.first > 0 && k <= frames.first + frames.settling) {
      look.remember(seen);
      continue;
    }
    const LookScores scores = look.of(seen);
    if (scores.worst().score > 1.0) {
      ++tried.frames_over;
      if (!overlap && model.has_contact()) overlap.emplace(model);
      const double driven = overlap ? overlap->of(seen.skinned).deepest : 0.0;
      if (driven > deepest_for_contact * model::extent(model)) tried.driven = std::max(tried.driven, driven);
    }
    if (scores.worst().score <= tried.worst.score) continue;
    tried.worst = scores.worst();
    tried.cause = scores.cause();
    tried.frame = k;
  }
  solver.load(drives.initial_state());
  return tried;
}

}  // namespace fascicle::bake
