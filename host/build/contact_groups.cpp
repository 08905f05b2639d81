#include "host/build/contact_groups.h"

#include <algorithm>
#include <cstddef>
#include <string>

#include "host/base/nearest_name.h"
#include "host/build/message.h"

namespace fascicle::build {

namespace {

// The share of a vertex's weights that assigns it to a joint, the default of JointSet; and how far below that
// rounding may put it.
constexpr double joint_share = 0.5, share_slack = 1e-9;
// Flesh painted below this meets nothing.
constexpr double least_contact_paint = 0.5;

// The flesh that a name refers to. A name shared by a joint, a layer, an object or a material refers to
// all of them.
class NamedFlesh {
 public:
  NamedFlesh(const scene::Scene& scene, const std::vector<std::uint32_t>& layer, Measures& measures)
      : scene_(scene), layer_(layer), measures_(measures) {}

  // One flag per vertex.
  std::vector<char> of(const std::string& name, const std::string& key) const {
    std::vector<char> is_its(layer_.size(), 0);
    bool is_known = false;
    const auto add_where = [&](const auto& is_there) {
      is_known = true;
      for (std::size_t i = 0; i < is_its.size(); ++i)
        if (is_there(i)) is_its[i] = 1;
    };
    const Body& body = measures_.body();
    if (std::any_of(body.joints.begin(), body.joints.end(),
                    [&](const JointUse& joint) { return joint.name == name; })) {
      const std::vector<double> share =
          measures_.shares_of(joints_named(body, {name}, true, key, scene_.source));
      add_where([&](std::size_t i) { return share[i] >= joint_share - share_slack; });
    }
    for (std::uint32_t l = 0; l < scene_.layers.size(); ++l)
      if (scene_.layers[l].name == name) add_where([&](std::size_t i) { return layer_[i] == l; });
    const auto is_named = [&](const rig::SurfacePart& part) {
      return part.object == name || part.material == name;
    };
    if (std::any_of(body.parts.begin(), body.parts.end(), is_named)) {
      const std::vector<std::uint32_t>& part = measures_.nearest_parts();
      add_where([&](std::size_t i) { return is_named(body.parts[part[i]]); });
    }
    if (!is_known) refuse(name, key);
    return is_its;
  }

 private:
  [[noreturn]] void refuse(const std::string& name, const std::string& key) const {
    const Body& body = measures_.body();
    std::vector<std::string> names;
    for (const JointUse& joint : body.joints) names.push_back(joint.name);
    for (const scene::Layer& layer : scene_.layers) names.push_back(layer.name);
    for (const rig::SurfacePart& part : body.parts) {
      names.push_back(part.object);
      names.push_back(part.material);
    }
    fail(scene_.source, key + ": no joint, layer, object or material is called \"" + name + '"' +
                            base::nearest_name_hint(name, names) + "; `fascicle inspect` lists them");
  }

  const scene::Scene& scene_;
  const std::vector<std::uint32_t>& layer_;
  Measures& measures_;
};

}  // namespace

ContactGroups contact_groups(const scene::Scene& scene, const std::vector<std::uint32_t>& layer,
                             Measures& measures, Report& report) {
  const std::string key = "contact.ignore";
  const NamedFlesh flesh(scene, layer, measures);
  ContactGroups result;
  const auto meets_nothing_where = [&](const auto& is_there) {
    result.meets_nothing.resize(layer.size(), 0);
    for (std::size_t i = 0; i < layer.size(); ++i)
      if (is_there(i)) result.meets_nothing[i] = 1;
  };
  const auto flesh_of = [&](const std::string& name) {
    std::vector<char> is_its = flesh.of(name, key);
    if (std::none_of(is_its.begin(), is_its.end(), [](char flag) { return flag != 0; }))
      warn(report, key + ": \"" + name + "\" has no flesh, so it has no contact to ignore");
    return is_its;
  };

  std::vector<std::string> names;
  const auto group_of = [&](const std::string& name) {
    const auto at = std::find(names.begin(), names.end(), name);
    const auto group = static_cast<std::size_t>(at - names.begin());
    if (at != names.end()) return group;
    if (names.size() == scene::most_ignored_names)
      fail(scene.source, key + ": its pairs have more than " + std::to_string(scene::most_ignored_names) +
                             " names; name joints further up, which include those below them");
    names.push_back(name);
    result.groups.resize(layer.size(), 0);
    const std::vector<char> is_its = flesh_of(name);
    for (std::size_t i = 0; i < layer.size(); ++i)
      if (is_its[i] != 0) result.groups[i] |= 1U << group;
    return group;
  };
  for (const std::vector<std::string>& entry : scene.contact.ignore) {
    if (entry.size() == 1) {
      const std::vector<char> is_its = flesh_of(entry[0]);
      meets_nothing_where([&](std::size_t i) { return is_its[i] != 0; });
      continue;
    }
    const std::size_t a = group_of(entry[0]), b = group_of(entry[1]);
    result.ignored[a] |= 1U << b;
    result.ignored[b] |= 1U << a;
  }

  const Body& body = measures.body();
  if (!scene.contact.self && body.members.size() > 1) {
    result.meets_others_only = true;
    if (names.size() + body.members.size() > scene::most_ignored_names)
      fail(scene.source,
           "contact.self: if it is false, the characters and the names in pairs of contact.ignore must be at "
           "most " +
               std::to_string(scene::most_ignored_names) + " together; set contact.self = true");
    result.groups.resize(layer.size(), 0);
    for (std::size_t i = 0; i < layer.size(); ++i)
      result.groups[i] |= 1U << (names.size() + member_of(body, i));
    for (std::size_t k = names.size(); k < names.size() + body.members.size(); ++k)
      result.ignored[k] = 1U << k;
  }

  // Carriers within a prop would hide how deep flesh lies in it.
  std::vector<char> hides(layer.size(), 0);
  for (std::size_t i = 0; i < layer.size() && !body.members.empty(); ++i)
    hides[i] = holding_of(body, i) == Holding::carrier && body.members[member_of(body, i)].is_rigid;
  if (std::find(hides.begin(), hides.end(), 1) != hides.end())
    meets_nothing_where([&](std::size_t i) { return hides[i] != 0; });

  for (std::uint32_t l = 0; l < scene.layers.size(); ++l)
    if (!scene.layers[l].contact) meets_nothing_where([&](std::size_t i) { return layer[i] == l; });
  if (!scene.contact.attribute.empty()) {
    const std::vector<double>& painted =
        measures.painted(scene.contact.attribute, "contact.attribute", scene.source);
    meets_nothing_where([&](std::size_t i) { return painted[i] < least_contact_paint; });
  }
  return result;
}

}  // namespace fascicle::build
