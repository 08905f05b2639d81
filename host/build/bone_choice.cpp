#include "host/build/bone_choice.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "host/build/bind_place.h"
#include "host/build/bone_axis.h"
#include "host/build/bone_reasons.h"
#include "host/build/joint_skin.h"
#include "host/build/message.h"
#include "host/build/skin_inside.h"
#include "host/build/surface_search.h"
#include "host/build/turns.h"

namespace fascicle::build {

namespace {

// Bones shorter than this part of the skeleton's extent are points.
constexpr double point_of_extent = 1e-6;

// A joint continues a bone above it if it moves at least this share of that bone's skin: a neck's head, but
// not a breast.
constexpr double goes_on_share = 0.5;
constexpr double most_open_going_on = 0.75;
// Users are told if joints that are too small for bones move more than this share of the skin.
constexpr double most_of_small_joints = 0.5;
// A root outside the skin that moves less than this share of it is a control.
constexpr double control_share = 5e-3;
// How far outside, as a share of the skeleton's extent.
constexpr double control_distance = 0.02;
// Joints below the same parent, or below parents that are alike, are alike if their openness differs by at
// most this much and their shares by at most this part of the larger.
constexpr double alike_openness = 0.05, alike_share = 0.1;
// A joint that a clip turns by this much against its parent is meant to be seen turning: its skin is not
// flesh that only lies on a trunk.
constexpr double most_turn_of_flesh = 20.0 * std::numbers::pi / 180.0;
// A joint that ends a chain continues in another if their skins meet this far out (in units of its distance
// to the middle of its own skin) and at most this far off that axis (as a share of the distance along it),
// and if the other's skin has at least this share of the area of the joint's own skin.
constexpr double meets_beyond = 1.2, meets_aside = 0.6, meets_area = 0.1;

class Chooser {
 public:
  Chooser(const rig::Character& character, const scene::SkeletonSettings& settings, double scale,
          const std::string& source, const std::vector<char>& is_left_out)
      : character_(character),
        settings_(settings),
        source_(source),
        surface_(character.surface),
        choice_(),
        place_(character.skeleton.size(), Vector3d::Zero()) {
    for (Vector3d& p : surface_.vertices) p *= scale;
    if (!is_left_out.empty())
      std::erase_if(surface_.triangles, [&](const auto& t) { return is_left_out[t[0]] != 0; });
    std::optional<Vector3d> low, high;
    for (std::size_t j = 0; j < place_.size(); ++j) {
      if (!character.skeleton[j].skins) continue;
      place_[j] = bind_place(character.skeleton[j], scale, source);
      low = low ? Vector3d(low->cwiseMin(place_[j])) : place_[j];
      high = high ? Vector3d(high->cwiseMax(place_[j])) : place_[j];
    }
    extent_ = low ? (*high - *low).norm() : 0.0;
    shortest_ = point_of_extent * extent_;
  }

  BoneChoice run() {
    measure();
    wanted_ = named(settings_.bones, "skeleton.bones", false);
    refused_ = named(settings_.not_bones, "skeleton.not_bones", false);
    const SurfaceSearch search(surface_);
    const SkinInside inside(surface_);
    take_fitting(search, inside);
    take_alike();
    take_ends_of_limbs();
    take_leading();
    meetings_ = meetings_of(surface_, character_);
    // Dropping a joint makes other joints ends and gives others new parents.
    do {
      find_ways_over();
    } while (!drop_outside(inside));
    drop_twists();
    write_bones(inside);
    write_uses();
    write_reasons();
    write_warning();
    return std::move(choice_);
  }

 private:
  std::size_t size() const { return place_.size(); }

  void measure() {
    skin_ = skin_of_joints(surface_, character_);
    turns_ = turns_in_clips(character_);
    for (std::size_t j = 0; j < size(); ++j) {
      JointReport joint;
      joint.name = character_.skeleton[j].name;
      joint.parent = character_.skeleton[j].parent;
      const SkinPiece& below = skin_.below[j];
      if (below.area > 0.0) {
        joint.share = below.area / skin_.whole;
        joint.openness = below.normal.norm() / below.area;
      }
      choice_.report.push_back(std::move(joint));
    }
  }

  bool can_be_bone(std::size_t j) const {
    const JointReport& joint = choice_.report[j];
    return character_.skeleton[j].skins && !refused_[j] && joint.share > 0.0 &&
           joint.share >= settings_.least_share && !is_control_[j];
  }

  void take_fitting(const SurfaceSearch& search, const SkinInside& inside) {
    is_bone_.resize(size());
    is_control_.resize(size());
    why_.assign(size(), "");
    for (std::size_t j = 0; j < size(); ++j) {
      if (!character_.skeleton[j].skins) continue;
      const std::int32_t parent = character_.skeleton[j].parent;
      const bool is_root = parent < 0 || !character_.skeleton[static_cast<std::size_t>(parent)].skins ||
                           is_control_[static_cast<std::size_t>(parent)];
      is_control_[j] = is_root && skin_.own[j].area < control_share * skin_.whole &&
                       !inside.contains(place_[j]) &&
                       search.nearest(place_[j]).distance > control_distance * extent_;
      if (wanted_[j])
        why_[j] = "requested";
      else if (can_be_bone(j) && choice_.report[j].openness <= most_open_limb)
        why_[j] = "its skin closes around it";
      is_bone_[j] = !refused_[j] && !why_[j].empty();
    }
  }

  bool are_alike(std::size_t a, std::size_t b) const {
    const JointReport &one = choice_.report[a], &other = choice_.report[b];
    if (a == b || std::abs(one.openness - other.openness) > alike_openness ||
        std::abs(one.share - other.share) > alike_share * std::max(one.share, other.share))
      return false;
    const std::int32_t p = character_.skeleton[a].parent, q = character_.skeleton[b].parent;
    if (p == q || p < 0 || q < 0) return p == q;
    return are_alike(static_cast<std::size_t>(p), static_cast<std::size_t>(q));
  }

  // Left and right: joints that are slightly too small or too open on one side only.
  void take_alike() {
    for (std::size_t j = 0; j < size(); ++j) {
      if (is_bone_[j] || refused_[j] || is_control_[j] || !character_.skeleton[j].skins) continue;
      for (std::size_t k = 0; k < size(); ++k) {
        if (!is_bone_[k] || wanted_[k] || !are_alike(j, k)) continue;
        is_bone_[j] = 1;
        why_[j] = "is like " + choice_.report[k].name;
        break;
      }
    }
  }

  // A short limb with an upper and a lower joint that are both too open: the lower one is its end, if neither
  // it nor any joint between it and a bone that leads on closes around an axis.
  void take_ends_of_limbs() {
    const std::vector<char> leads_on = joints_that_lead_on();
    for (std::size_t j = size(); j-- > 0;) {
      if (is_bone_[j] || !can_be_bone(j) || choice_.report[j].openness > least_open_flesh) continue;
      const std::int32_t parent = character_.skeleton[j].parent, above = bone_above(j);
      if (parent == above || above < 0 || !leads_on[static_cast<std::size_t>(above)]) continue;
      if (!can_be_bone(static_cast<std::size_t>(parent)) || has_bone_below(j)) continue;
      is_bone_[j] = 1;
      why_[j] = "ends the limb of " + choice_.report[static_cast<std::size_t>(parent)].name;
    }
  }

  bool has_bone_below(std::size_t joint) const {
    for (std::size_t j = 0; j < size(); ++j)
      if (is_bone_[j])
        for (std::int32_t k = character_.skeleton[j].parent; k >= 0;
             k = character_.skeleton[static_cast<std::size_t>(k)].parent)
          if (k == static_cast<std::int32_t>(joint)) return true;
    return false;
  }

  // Joints between bones are bones, and so are joints that continue a bone with most of its skin.
  void take_leading() {
    for (std::size_t j = size(); j-- > 0;) {
      if (!is_bone_[j]) continue;
      for (std::int32_t k = character_.skeleton[j].parent; k >= 0;
           k = character_.skeleton[static_cast<std::size_t>(k)].parent) {
        const auto above = static_cast<std::size_t>(k);
        if (is_bone_[above] || !can_be_bone(above)) continue;
        is_bone_[above] = 1;
        why_[above] = "leads to " + character_.skeleton[j].name;
      }
    }
    for (std::size_t j = 0; j < size(); ++j) {
      if (is_bone_[j] || !can_be_bone(j) || choice_.report[j].openness > most_open_going_on) continue;
      const std::int32_t above = bone_above(j);
      if (above < 0) continue;
      const JointReport& parent = choice_.report[static_cast<std::size_t>(above)];
      if (choice_.report[j].share < goes_on_share * parent.share) continue;
      is_bone_[j] = 1;
      why_[j] = "continues " + parent.name + " with most of its skin";
    }
  }

  // The joints with these names, with all their descendants if `and_below`.
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

  // The nearest ancestor that is a bone, or -1.
  std::int32_t bone_above(std::size_t joint) const {
    std::int32_t parent = character_.skeleton[joint].parent;
    while (parent >= 0 && !is_bone_[static_cast<std::size_t>(parent)])
      parent = character_.skeleton[static_cast<std::size_t>(parent)].parent;
    return parent;
  }

  // Bones with a length, each from a joint to the next below it; leads_on marks the joints they start from.
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

  Vector3d tip_of(std::size_t joint, const Vector3d& begin) const {
    if (!(choice_.report[joint].share > 0.0)) return begin;
    return tip_of_chain(surface_, skin_, joint, begin, shortest_);
  }

  std::vector<char> joints_that_lead_on() const {
    std::vector<char> leads_on(size(), 0);
    for (const Segment& s : segments()) leads_on[s.from] = 1;
    return leads_on;
  }

  // Where a chain ends in the skeleton but continues in space: a shank whose foot is a separate IK target.
  void find_ways_over() {
    const std::vector<char> leads_on = joints_that_lead_on();
    over_.clear();
    is_met_.assign(size(), 0);
    std::vector<Meeting> by_area = meetings_;
    std::stable_sort(by_area.begin(), by_area.end(),
                     [](const Meeting& a, const Meeting& b) { return a.area > b.area; });
    for (const Meeting& meeting : by_area) {
      const std::size_t from = meeting.from, to = meeting.to;
      if (!is_bone_[from] || leads_on[from] || is_met_[from] || refused_[to] ||
          !character_.skeleton[to].skins)
        continue;
      if (skin_.below[to].area < meets_area * skin_.own[from].area) continue;
      const Vector3d way = meeting.middle - place_[from], axis = skin_.own[from].middle - place_[from];
      const double length = axis.norm();
      if (!(length > shortest_) || way.dot(axis) < meets_beyond * length * length) continue;
      const Vector3d along = way.dot(axis) / (length * length) * axis;
      if ((way - along).norm() > meets_aside * along.norm()) continue;
      over_.push_back(meeting);
      is_met_[from] = is_met_[to] = 1;
      is_bone_[to] = 1;
      why_[to] = "takes over from " + character_.skeleton[from].name + " where their skins meet";
    }
  }

  // Drops the joints whose axes all run outside the skin; true if there were none.
  bool drop_outside(const SkinInside& inside) {
    std::vector<char> leads_on(size(), 0), has_axis(size(), 0);
    std::vector<char> is_cut(size(), 0);
    for (const Segment& s : segments()) {
      leads_on[s.from] = 1;
      if (wanted_[s.from] || wanted_[s.to] || runs_inside(inside, place_[s.from], place_[s.to]))
        has_axis[s.from] = 1;
      else
        is_cut[s.to] = 1;
    }
    bool all_stay = true;
    for (std::size_t j = 0; j < size(); ++j) {
      if (!is_bone_[j] || wanted_[j] || has_axis[j] || is_met_[j]) continue;
      if (!leads_on[j] && runs_inside(inside, place_[j], tip_of(j, place_[j]))) continue;
      is_bone_[j] = 0;
      why_[j] = "its axis runs outside the skin";
      refused_[j] = 1;
      all_stay = false;
    }
    is_cut_ = std::move(is_cut);
    return all_stay;
  }

  // Drops joints that end a chain and whose skin lies around another bone of their parent.
  void drop_twists() {
    is_twist_.assign(size(), 0);
    const std::vector<Segment> all = segments();
    const std::vector<char> leads_on = joints_that_lead_on();
    for (std::size_t j = 0; j < size(); ++j) {
      if (!is_bone_[j] || leads_on[j] || wanted_[j] || is_met_[j]) continue;
      const std::int32_t parent = bone_above(j);
      for (const Segment& s : all) {
        if (static_cast<std::int32_t>(s.from) != parent || s.to == j) continue;
        if (!lies_around(surface_, skin_, j, place_[s.from], place_[s.to])) continue;
        is_twist_[j] = 1;
        why_[j] = "its skin lies around the bone of " + character_.skeleton[s.from].name;
      }
    }
    for (std::size_t j = 0; j < size(); ++j)
      if (is_twist_[j]) is_bone_[j] = 0;
  }

  static std::int32_t index(std::size_t joint) { return static_cast<std::int32_t>(joint); }

  void write_bones(const SkinInside& inside) {
    ends_chain_.assign(size(), 0);
    std::vector<char> is_reached(size(), 0);
    for (std::size_t j = 0; j < size(); ++j) ends_chain_[j] = is_bone_[j];
    std::vector<Bone>& bones = choice_.bones;
    for (const Segment& s : segments()) {
      ends_chain_[s.from] = 0;
      if (is_cut_[s.to]) continue;
      is_reached[s.to] = 1;
      bones.push_back({place_[s.from], place_[s.to], {index(s.from), bone_above(s.from), index(s.to)}});
    }
    std::vector<Vector3d> begin = place_;
    for (const Meeting& over : over_) {
      ends_chain_[over.from] = 0;
      bones.push_back(
          {place_[over.from], over.middle, {index(over.from), bone_above(over.from), index(over.to)}});
      if (ends_chain_[over.to])
        begin[over.to] = over.middle;
      else if (runs_inside(inside, over.middle, place_[over.to]))
        bones.push_back({over.middle, place_[over.to], {index(over.to), index(over.from), -1}});
      is_reached[over.to] = 1;
    }
    // Limbs attached to a root outside the skin get a bone from the adjacent bone.
    for (const Meeting& meeting : meetings_) {
      const std::size_t from = meeting.from, to = meeting.to;
      if (!is_bone_[from] || !is_bone_[to] || is_reached[to] || ends_chain_[from]) continue;
      if (!((place_[to] - place_[from]).norm() > shortest_)) continue;
      if (!runs_inside(inside, place_[from], place_[to])) continue;
      is_reached[to] = 1;
      bones.push_back({place_[from], place_[to], {index(from), bone_above(from), index(to)}});
    }
    for (std::size_t j = 0; j < size(); ++j)
      if (ends_chain_[j]) bones.push_back({begin[j], tip_of(j, begin[j]), {index(j), bone_above(j), -1}});
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
      const std::int32_t bone = is_bone_[j] ? index(j) : bone_above(j);
      const bool is_left_out = !settings_.only.empty() && !only[j];
      joint.is_kinematic =
          !simulated[j] && (is_left_out || kinematic[j] || (!only_itself[j] && follows(j, bone)));
      choice_.joints.push_back(
          {joint.name, joint.parent, bone, joint.is_kinematic, simulated[j] || !joint.is_bone});
    }
  }

  // A rig with hundreds of joints beside each other has none that is large enough for a bone.
  void write_warning() {
    const std::vector<char> kinematic = named(settings_.kinematic, "skeleton.kinematic", true);
    double area = 0.0;
    std::set<std::string> roots;
    for (std::size_t j = 0; j < size(); ++j) {
      const JointReport& joint = choice_.report[j];
      if (joint.is_bone || !joint.is_kinematic || kinematic[j] || refused_[j] || is_control_[j]) continue;
      if (!(joint.share > 0.0) || joint.share >= settings_.least_share) continue;
      area += skin_.own[j].area;
      std::size_t root = j;
      while (character_.skeleton[root].parent >= 0)
        root = static_cast<std::size_t>(character_.skeleton[root].parent);
      roots.insert("\"" + character_.skeleton[root].name + "\"");
    }
    if (!(area > most_of_small_joints * skin_.whole) || !settings_.only.empty()) return;
    choice_.warning = small_joints_warning(area / skin_.whole, settings_.least_share, roots);
  }

  void write_reasons() {
    for (std::size_t j = 0; j < size(); ++j) {
      JointDecision decision{
          .why = why_[j], .is_excluded = refused_[j] != 0, .is_control = is_control_[j] != 0};
      for (const Meeting& over : over_)
        if (over.from == j) decision.leads_to.push_back(character_.skeleton[over.to].name);
      choice_.report[j].reason = reason_of(choice_.report[j], decision, settings_.least_share);
    }
  }

  bool follows(std::size_t j, std::int32_t bone) const {
    if (is_bone_[j]) return ends_chain_[j] != 0;
    const JointReport& joint = choice_.report[j];
    if (is_twist_[j]) return false;
    const bool is_large = joint.share >= settings_.least_share;
    // A root whose axis lies outside: its flesh is trunk.
    if (bone < 0) return !is_large;
    const bool on_end = ends_chain_[static_cast<std::size_t>(bone)] != 0;
    return joint.openness < least_open_flesh || (on_end && !is_large) || turns_[j] > most_turn_of_flesh;
  }

  const rig::Character& character_;
  const scene::SkeletonSettings& settings_;
  const std::string& source_;
  mesh::SurfaceMesh surface_;
  BoneChoice choice_;
  std::vector<Vector3d> place_;  // per joint, m
  SkinOfJoints skin_;
  std::vector<char> wanted_, refused_, is_control_;
  std::vector<char> is_bone_, ends_chain_, is_twist_, is_met_;
  std::vector<char> is_cut_;  // the bone that leads to this joint runs outside the skin
  std::vector<Meeting> meetings_, over_;
  std::vector<double> turns_;             // of each joint in the clips, radians
  std::vector<std::string> why_;          // why a joint is a bone or not
  double extent_ = 0.0, shortest_ = 0.0;  // m
};

}  // namespace

BoneChoice choose_bones(const rig::Character& character, const scene::SkeletonSettings& settings,
                        double scale, const std::string& source, const std::vector<char>& is_left_out) {
  return Chooser(character, settings, scale, source, is_left_out).run();
}

}  // namespace fascicle::build
