#include "host/build/bone_choice.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "host/build/measures.h"
#include "host/build/message.h"
#include "host/build/surface_search.h"

namespace fascicle::build {

namespace {

// Bones shorter than this part of the skeleton's extent are points.
constexpr double point_of_extent = 1e-6;
// An end's bone reaches this far into what most of its skin spans.
constexpr double end_reach = 0.85;
constexpr double most_skin = 0.98;
// Places along a bone where it is asked whether it runs inside the skin.
constexpr int axis_samples = 10;

// What one joint and those below it move.
struct Skin {
  double area = 0.0;
  Vector3d normal = Vector3d::Zero();  // sum w a n
  Vector3d middle = Vector3d::Zero();  // weighted by area
};

struct VertexArea {
  double area = 0.0;
  Vector3d normal = Vector3d::Zero();
};

std::vector<VertexArea> vertex_areas(const scene::SurfaceMesh& surface) {
  std::vector<VertexArea> of(surface.vertices.size());
  for (const auto& t : surface.triangles) {
    const Vector3d& a = surface.vertices[t[0]];
    const Vector3d normal = (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a) / 6.0;
    for (const std::uint32_t corner : t) {
      of[corner].area += normal.norm();
      of[corner].normal += normal;
    }
  }
  return of;
}

// Each joint's part in each vertex, with the joints below it: pairs (joint, weight) of every vertex.
using PartsWithBelow = std::vector<std::vector<std::pair<std::uint32_t, double>>>;

PartsWithBelow parts_with_below(const scene::Character& character) {
  PartsWithBelow parts(character.surface.vertices.size());
  std::vector<double> weight(character.skeleton.size(), 0.0);
  for (std::size_t v = 0; v < parts.size(); ++v) {
    std::vector<std::uint32_t> touched;
    double all = 0.0;
    for (std::size_t k = 0; k < 8; ++k) {
      const double w = character.weights[v][k];
      if (!(w > 0.0)) continue;
      all += w;
      for (auto j = static_cast<std::int32_t>(character.joints[v][k]); j >= 0;
           j = character.skeleton[static_cast<std::size_t>(j)].parent) {
        const auto joint = static_cast<std::uint32_t>(j);
        if (weight[joint] == 0.0) touched.push_back(joint);
        weight[joint] += w;
      }
    }
    std::sort(touched.begin(), touched.end());
    for (const std::uint32_t joint : touched) {
      parts[v].emplace_back(joint, weight[joint] / all);
      weight[joint] = 0.0;
    }
  }
  return parts;
}

Vector3d bind_position(const scene::Joint& joint, const std::string& source) {
  const Eigen::FullPivLU<Eigen::Matrix4d> factored(joint.inverse_bind);
  if (!joint.inverse_bind.allFinite() || !factored.isInvertible())
    fail(source, "joint \"" + joint.name + "\": its inverse bind matrix has no inverse");
  const Eigen::Vector4d origin = factored.solve(Eigen::Vector4d(0, 0, 0, 1));
  return origin.head<3>() / origin[3];
}

class Chooser {
 public:
  Chooser(const scene::Character& character, const scene::SkeletonSettings& settings, double scale,
          const std::string& source)
      : character_(character),
        settings_(settings),
        source_(source),
        surface_(character.surface),
        choice_(),
        place_(character.skeleton.size(), Vector3d::Zero()) {
    for (Vector3d& p : surface_.vertices) p *= scale;
    std::optional<Vector3d> low, high;
    for (std::size_t j = 0; j < place_.size(); ++j) {
      if (!character.skeleton[j].skins) continue;
      place_[j] = scale * bind_position(character.skeleton[j], source);
      low = low ? Vector3d(low->cwiseMin(place_[j])) : place_[j];
      high = high ? Vector3d(high->cwiseMax(place_[j])) : place_[j];
    }
    shortest_ = low ? point_of_extent * (*high - *low).norm() : 0.0;
  }

  BoneChoice run() {
    measure();
    const std::vector<char> wanted = named(settings_.bones, "skeleton.bones", false);
    const std::vector<char> refused = named(settings_.not_bones, "skeleton.not_bones", false);
    is_bone_.resize(size());
    for (std::size_t j = 0; j < size(); ++j) {
      const JointReport& joint = choice_.report[j];
      const bool fits =
          joint.share > 0.0 && joint.share >= settings_.least_share && joint.openness <= most_open_limb;
      is_bone_[j] = character_.skeleton[j].skins && !refused[j] && (wanted[j] || fits);
    }
    const SurfaceSearch search(surface_);
    // What is dropped makes other joints ends, and others' parents.
    while (!drop_outside(search, wanted)) continue;
    drop_twists(wanted);
    write_bones();
    write_uses();
    return std::move(choice_);
  }

 private:
  std::size_t size() const { return place_.size(); }

  void measure() {
    parts_ = parts_with_below(character_);
    areas_ = vertex_areas(surface_);
    std::vector<Skin> skin(size());
    double whole = 0.0;
    for (std::size_t v = 0; v < parts_.size(); ++v) {
      whole += areas_[v].area;
      for (const auto& [joint, w] : parts_[v]) {
        skin[joint].area += w * areas_[v].area;
        skin[joint].normal += w * areas_[v].normal;
        skin[joint].middle += w * areas_[v].area * surface_.vertices[v];
      }
    }
    for (std::size_t j = 0; j < size(); ++j) {
      JointReport joint;
      joint.name = character_.skeleton[j].name;
      joint.parent = character_.skeleton[j].parent;
      if (skin[j].area > 0.0) {
        joint.share = skin[j].area / whole;
        joint.openness = skin[j].normal.norm() / skin[j].area;
        skin[j].middle /= skin[j].area;
      }
      middle_.push_back(skin[j].middle);
      choice_.report.push_back(std::move(joint));
    }
  }

  // The joints of these names, with all below them if asked for.
  std::vector<char> named(const std::vector<std::string>& names, const std::string& key,
                          bool and_below) const {
    std::vector<char> is(size(), 0);
    for (const std::string& name : names) {
      bool found = false;
      for (std::size_t j = 0; j < size(); ++j) {
        if (character_.skeleton[j].name != name) continue;
        is[j] = 1;
        found = true;
      }
      if (!found) fail(source_, key + ": no joint is called \"" + name + "\"; `fascicle inspect` lists them");
    }
    if (and_below)
      for (std::size_t j = 0; j < size(); ++j)
        if (const std::int32_t parent = character_.skeleton[j].parent; parent >= 0)
          is[j] = is[j] || is[static_cast<std::size_t>(parent)];
    return is;
  }

  // The next bone above, or -1.
  std::int32_t bone_above(std::size_t joint) const {
    std::int32_t parent = character_.skeleton[joint].parent;
    while (parent >= 0 && !is_bone_[static_cast<std::size_t>(parent)])
      parent = character_.skeleton[static_cast<std::size_t>(parent)].parent;
    return parent;
  }

  // Bones of length, each from a joint to the next below it; leads_on tells the joints they start from.
  struct Segment {
    std::size_t from, to;
  };
  std::vector<Segment> segments() const {
    std::vector<Segment> all;
    for (std::size_t j = 0; j < size(); ++j) {
      if (!is_bone_[j]) continue;
      const std::int32_t parent = bone_above(j);
      if (parent < 0) continue;
      const auto p = static_cast<std::size_t>(parent);
      if ((place_[j] - place_[p]).norm() > shortest_) all.push_back({p, j});
    }
    return all;
  }

  static bool runs_inside(const SurfaceSearch& search, const Vector3d& from, const Vector3d& to) {
    int inside = 0;
    for (int k = 0; k < axis_samples; ++k)
      inside += search.is_inside(from + (k + 0.5) / axis_samples * (to - from)) ? 1 : 0;
    return 2 * inside >= axis_samples;
  }

  // The tip of the bone of a joint that ends a chain: into its skin, as far as that reaches for the most
  // part.
  Vector3d tip_of(std::size_t joint) const {
    const Vector3d towards = middle_[joint] - place_[joint];
    const double length = towards.norm();
    if (!(choice_.report[joint].share > 0.0) || !(length > shortest_)) return place_[joint];
    std::vector<std::pair<double, double>> reach;  // along the bone, area
    double all = 0.0;
    for (std::size_t v = 0; v < parts_.size(); ++v)
      for (const auto& [j, w] : parts_[v]) {
        if (j != joint) continue;
        reach.emplace_back((surface_.vertices[v] - place_[joint]).dot(towards) / length, w * areas_[v].area);
        all += w * areas_[v].area;
      }
    std::sort(reach.begin(), reach.end());
    double sum = 0.0, far = 0.0;
    for (const auto& [along, area] : reach) {
      far = along;
      sum += area;
      if (sum >= most_skin * all) break;
    }
    return place_[joint] + std::max(end_reach * far, length) / length * towards;
  }

  // Drops the joints whose axes all run outside the skin; true if there were none.
  bool drop_outside(const SurfaceSearch& search, const std::vector<char>& wanted) {
    std::vector<char> leads_on(size(), 0), has_axis(size(), 0);
    std::vector<char> is_cut(size(), 0);
    for (const Segment& s : segments()) {
      leads_on[s.from] = 1;
      if (wanted[s.from] || wanted[s.to] || runs_inside(search, place_[s.from], place_[s.to]))
        has_axis[s.from] = 1;
      else
        is_cut[s.to] = 1;
    }
    bool all_stay = true;
    for (std::size_t j = 0; j < size(); ++j) {
      if (!is_bone_[j] || wanted[j] || has_axis[j]) continue;
      if (!leads_on[j] && runs_inside(search, place_[j], tip_of(j))) continue;
      is_bone_[j] = 0;
      all_stay = false;
    }
    is_cut_ = std::move(is_cut);
    return all_stay;
  }

  // Joints that end a chain and whose skin lies around another bone of their parent's.
  void drop_twists(const std::vector<char>& wanted) {
    is_twist_.assign(size(), 0);
    const std::vector<Segment> all = segments();
    std::vector<char> leads_on(size(), 0);
    for (const Segment& s : all) leads_on[s.from] = 1;
    for (std::size_t j = 0; j < size(); ++j) {
      if (!is_bone_[j] || leads_on[j] || wanted[j]) continue;
      const std::int32_t parent = bone_above(j);
      for (const Segment& s : all) {
        if (static_cast<std::int32_t>(s.from) != parent || s.to == j) continue;
        if (lies_around(j, place_[s.from], place_[s.to])) is_twist_[j] = 1;
      }
    }
    for (std::size_t j = 0; j < size(); ++j)
      if (is_twist_[j]) is_bone_[j] = 0;
  }

  // Whether a joint's skin lies around a segment: its middle is much nearer to it than the skin itself.
  bool lies_around(std::size_t joint, const Vector3d& from, const Vector3d& to) const {
    double sum = 0.0, area = 0.0;
    for (std::size_t v = 0; v < parts_.size(); ++v)
      for (const auto& [j, w] : parts_[v]) {
        if (j != joint) continue;
        sum += w * areas_[v].area * segment_distance(surface_.vertices[v], from, to);
        area += w * areas_[v].area;
      }
    const double along = (middle_[joint] - from).dot(to - from) / (to - from).squaredNorm();
    return along > 0.0 && along < 1.0 && 2.0 * area * segment_distance(middle_[joint], from, to) < sum;
  }

  void write_bones() {
    const auto index = [](std::size_t joint) { return static_cast<std::int32_t>(joint); };
    ends_chain_.assign(size(), 0);
    for (std::size_t j = 0; j < size(); ++j) ends_chain_[j] = is_bone_[j];
    for (const Segment& s : segments()) {
      ends_chain_[s.from] = 0;
      if (is_cut_[s.to]) continue;
      choice_.bones.push_back(
          {place_[s.from], place_[s.to], {index(s.from), bone_above(s.from), index(s.to)}});
    }
    for (std::size_t j = 0; j < size(); ++j)
      if (ends_chain_[j]) choice_.bones.push_back({place_[j], tip_of(j), {index(j), bone_above(j), -1}});
  }

  void write_uses() {
    const std::vector<char> kinematic = named(settings_.kinematic, "skeleton.kinematic", true);
    const std::vector<char> simulated = named(settings_.simulated, "skeleton.simulated", true);
    const std::vector<char> only = named(settings_.only, "skeleton.only", true);
    const std::vector<char> only_itself = named(settings_.only, "skeleton.only", false);
    for (std::size_t j = 0; j < size(); ++j) {
      JointReport& joint = choice_.report[j];
      joint.is_bone = is_bone_[j] != 0;
      joint.ends_chain = ends_chain_[j] != 0;
      const std::int32_t bone = is_bone_[j] ? static_cast<std::int32_t>(j) : bone_above(j);
      const bool is_left_out = !settings_.only.empty() && !only[j];
      joint.is_kinematic =
          !simulated[j] && (is_left_out || kinematic[j] || (!only_itself[j] && follows(j, bone)));
      choice_.joints.push_back({joint.name, joint.parent, bone, joint.is_kinematic});
    }
  }

  bool follows(std::size_t j, std::int32_t bone) const {
    if (is_bone_[j]) return ends_chain_[j] != 0;
    const JointReport& joint = choice_.report[j];
    if (is_twist_[j]) return false;
    const bool is_large = joint.share >= settings_.least_share;
    // A root whose axis lies outside: what it moves is trunk.
    if (bone < 0) return !is_large;
    const bool on_end = ends_chain_[static_cast<std::size_t>(bone)] != 0;
    return joint.openness < least_open_flesh || (on_end && !is_large);
  }

  const scene::Character& character_;
  const scene::SkeletonSettings& settings_;
  const std::string& source_;
  scene::SurfaceMesh surface_;
  BoneChoice choice_;
  std::vector<Vector3d> place_;   // of a joint, m
  std::vector<Vector3d> middle_;  // of a joint's skin, m
  PartsWithBelow parts_;
  std::vector<VertexArea> areas_;
  std::vector<char> is_bone_, ends_chain_, is_twist_;
  std::vector<char> is_cut_;  // the bone that leads to this joint runs outside the skin
  double shortest_ = 0.0;
};

}  // namespace

BoneChoice choose_bones(const scene::Character& character, const scene::SkeletonSettings& settings,
                        double scale, const std::string& source) {
  return Chooser(character, settings, scale, source).run();
}

}  // namespace fascicle::build
