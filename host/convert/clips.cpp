// Clips: converts the keys of assimp's channels to tracks of whole nodes.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <unordered_map>

#include "host/convert/character.h"

namespace fascicle::convert {
namespace {

Eigen::Vector3d vector_of(const aiVector3D& v) {
  return {double{v.x}, double{v.y}, double{v.z}};
}

Eigen::Quaterniond value_of(const aiQuatKey& key) {
  const Eigen::Quaterniond q(double{key.mValue.w}, double{key.mValue.x}, double{key.mValue.y},
                             double{key.mValue.z});
  return q.norm() > 0.0 ? q.normalized() : Eigen::Quaterniond::Identity();
}
Eigen::Vector3d value_of(const aiVectorKey& key) {
  return vector_of(key.mValue);
}

Eigen::Quaterniond between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b, double share) {
  return a.slerp(share, b);
}
Eigen::Vector3d between(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double share) {
  return a + share * (b - a);
}

// The value at a time in ticks; `otherwise` if there are no keys.
template <typename Key, typename Value>
Value sample(const Key* keys, unsigned count, double time, const Value& otherwise) {
  if (count == 0 || keys == nullptr) return otherwise;
  const Key* const end = keys + count;
  const Key* const after =
      std::upper_bound(keys, end, time, [](double t, const Key& key) { return t < key.mTime; });
  if (after == keys) return value_of(keys[0]);
  if (after == end) return value_of(end[-1]);
  const double span = after->mTime - after[-1].mTime;
  return between(value_of(after[-1]), value_of(*after), span > 0.0 ? (time - after[-1].mTime) / span : 0.0);
}

Parts sample(const aiNodeAnim& channel, double time, const Parts& rest) {
  return {.translation = sample(channel.mPositionKeys, channel.mNumPositionKeys, time, rest.translation),
          .rotation = sample(channel.mRotationKeys, channel.mNumRotationKeys, time, rest.rotation),
          .scale = sample(channel.mScalingKeys, channel.mNumScalingKeys, time, rest.scale)};
}

void add_times(const aiNodeAnim& channel, std::set<double>& times) {
  const auto add = [&](const auto* keys, unsigned count) {
    for (unsigned k = 0; k < count; ++k)
      if (std::isfinite(keys[k].mTime)) times.insert(keys[k].mTime);
  };
  add(channel.mPositionKeys, channel.mNumPositionKeys);
  add(channel.mRotationKeys, channel.mNumRotationKeys);
  add(channel.mScalingKeys, channel.mNumScalingKeys);
}

// What of the file's timeline a clip shows, in ticks.
struct Span {
  double first = -std::numeric_limits<double>::infinity();
  double last = std::numeric_limits<double>::infinity();
};

// Keys outside lead to a value at the border. Assimp passes on some of them: the first key of each curve of a
// rotation, all keys of blend shapes, and its own keys at time 0 of the file.
void keep_within(const Span& span, std::set<double>& times) {
  if (times.empty()) return;
  const bool begins_before = *times.begin() < span.first;
  const bool ends_after = *times.rbegin() > span.last;
  times.erase(times.begin(), times.lower_bound(span.first));
  times.erase(times.upper_bound(span.last), times.end());
  if (begins_before) times.insert(span.first);
  if (ends_after) times.insert(span.last);
}

constexpr double most_samples = 1e6;

// A chain rotates about pivots, so a node moves on an arc between two keys, and its linear keys must sample
// that arc.
void fill_gaps(std::set<double>& times) {
  if (times.empty() || *times.rbegin() - *times.begin() > most_samples) return;
  std::set<double> between_keys;
  for (auto after = std::next(times.begin()); after != times.end(); ++after) {
    const double from = *std::prev(after), span = *after - from;
    const double steps = std::ceil(span - 1e-3);  // one per frame
    for (double k = 1.0; k < steps; k += 1.0) between_keys.insert(from + span * k / steps);
  }
  times.merge(between_keys);
}

// The channels of a node's links, or of the node itself, by name.
using Channels = std::unordered_map<std::string, const aiNodeAnim*>;

// Assimp 5.2 multiplies a whole channel by the node's post-rotation instead of its inverse, but gets it right
// when it splits the node into links. Applying the inverse twice corrects this. Other versions were not
// examined; CMakeLists.txt excludes them.
Eigen::Quaterniond twice_undone(const Node& node) {
  for (const Link& link : node.chain)
    if (link.component == "PostRotation") {
      const Eigen::Quaterniond undone = parts_of(link.matrix).rotation;
      return undone * undone;
    }
  return Eigen::Quaterniond::Identity();
}

Track whole_track(const Node& node, const aiNodeAnim& channel, double seconds, const Span& span) {
  Track track;
  std::set<double> times;
  add_times(channel, times);
  keep_within(span, times);
  const Parts rest = parts_of(node.local);
  const Eigen::Quaterniond undone = twice_undone(node);
  for (const double time : times) {
    track.times.push_back(time * seconds);
    track.values.push_back(sample(channel, time, rest));
    track.values.back().rotation = (track.values.back().rotation * undone).normalized();
  }
  return track;
}

// A link's channel is only used for the component that the link represents.
Matrix link_at(const Link& link, const aiNodeAnim& channel, double time) {
  Parts parts = parts_of(link.matrix);
  const Parts sampled = sample(channel, time, parts);
  if (link.component.find("Rotation") != std::string::npos &&
      link.component.find("Pivot") == std::string::npos &&
      link.component.find("Offset") == std::string::npos) {
    parts.rotation = sampled.rotation;
  } else if (link.component == "Scaling") {
    parts.scale = sampled.scale;
  } else {
    parts.translation = sampled.translation;
  }
  return matrix_of(parts);
}

Track chained_track(const Node& node, const Channels& channels, double seconds, const Span& span) {
  Track track;
  std::set<double> times;
  std::vector<const aiNodeAnim*> of_link;
  for (const Link& link : node.chain) {
    const auto found = channels.find(link.name);
    of_link.push_back(found == channels.end() ? nullptr : found->second);
    if (of_link.back() != nullptr) add_times(*of_link.back(), times);
  }
  keep_within(span, times);
  fill_gaps(times);
  for (const double time : times) {
    Matrix local = Matrix::Identity();
    for (std::size_t i = 0; i < node.chain.size(); ++i)
      local =
          (local * (of_link[i] == nullptr ? node.chain[i].matrix : link_at(node.chain[i], *of_link[i], time)))
              .eval();
    track.times.push_back(time * seconds);
    track.values.push_back(parts_of(local));
  }
  return track;
}

// The name is "Mesh*0", as in FBX, or the node's name.
std::size_t node_of(const Character& character, const aiMeshMorphAnim& channel) {
  std::string name = channel.mName.C_Str();
  name.resize(std::min(name.find('*'), name.size()));
  const auto found = character.by_name.find(name);
  if (found != character.by_name.end())
    for (const std::size_t n : found->second)
      for (const aiMesh* mesh : character.nodes[n].meshes)
        if (mesh->mNumAnimMeshes > 0) return n;
  return character.nodes.size();
}

// A key may list only some shapes; the others are interpolated between their own keys.
ShapeTrack shape_track(const aiMeshMorphAnim& channel, std::size_t shapes, double seconds, const Span& span) {
  std::vector<std::map<double, double>> keys(shapes);
  std::set<double> times;
  for (unsigned k = 0; k < channel.mNumKeys; ++k) {
    const aiMeshMorphKey& key = channel.mKeys[k];
    if (!std::isfinite(key.mTime)) continue;
    for (unsigned i = 0; i < key.mNumValuesAndWeights; ++i)
      if (key.mValues[i] < shapes && std::isfinite(key.mWeights[i])) {
        keys[key.mValues[i]][key.mTime] = key.mWeights[i];
        times.insert(key.mTime);
      }
  }
  keep_within(span, times);
  ShapeTrack track;
  for (const double time : times) {
    track.times.push_back(time * seconds);
    track.weights.emplace_back();
    for (const std::map<double, double>& of_shape : keys) {
      const auto after = of_shape.lower_bound(time);
      double weight = 0.0;
      if (after != of_shape.end() && (after->first == time || after == of_shape.begin())) {
        weight = after->second;
      } else if (after == of_shape.end()) {
        weight = of_shape.empty() ? 0.0 : of_shape.rbegin()->second;
      } else {
        const auto before = std::prev(after);
        const double share = (time - before->first) / (after->first - before->first);
        weight = before->second + share * (after->second - before->second);
      }
      track.weights.back().push_back(weight);
    }
  }
  return track;
}

// `lost`: names of channels that have no mesh.
void add_shape_tracks(const aiAnimation& animation, double seconds, const Span& span,
                      const Character& character, Clip& clip, std::set<std::string>& lost) {
  for (unsigned c = 0; c < animation.mNumMorphMeshChannels; ++c) {
    const std::size_t node = node_of(character, *animation.mMorphMeshChannels[c]);
    if (node == character.nodes.size()) {
      lost.insert(animation.mMorphMeshChannels[c]->mName.C_Str());
      continue;
    }
    std::size_t shapes = 0;
    for (const aiMesh* mesh : character.nodes[node].meshes)
      shapes = std::max(shapes, std::size_t{mesh->mNumAnimMeshes});
    ShapeTrack track = shape_track(*animation.mMorphMeshChannels[c], shapes, seconds, span);
    track.node = node;
    if (!track.times.empty()) clip.shapes.push_back(std::move(track));
  }
}

// Makes a clip start at its first key.
void begin_at_zero(Clip& clip) {
  double first = std::numeric_limits<double>::infinity();
  for (const Track& track : clip.tracks) first = std::min(first, track.times.front());
  for (const ShapeTrack& track : clip.shapes) first = std::min(first, track.times.front());
  for (Track& track : clip.tracks)
    for (double& time : track.times) time -= first;
  for (ShapeTrack& track : clip.shapes)
    for (double& time : track.times) time -= first;
}

// Collada has one timeline, and assimp makes each animation on it a clip, which may move a single joint. It
// joins only animations with one channel each.
void join_clips(Character& character) {
  std::vector<Clip> result;
  std::set<std::size_t> moved, shaped;  // by the first clip
  const std::size_t none = character.nodes.size();
  std::size_t moved_again = none;
  for (Clip& clip : character.clips) {
    std::size_t again = none;
    for (const Track& track : clip.tracks)
      if (moved.count(track.node) > 0) again = track.node;
    for (const ShapeTrack& track : clip.shapes)
      if (shaped.count(track.node) > 0) again = track.node;
    if (again != none) {
      moved_again = std::min(moved_again, again);
      result.push_back(std::move(clip));
      continue;
    }
    for (const Track& track : clip.tracks) moved.insert(track.node);
    for (const ShapeTrack& track : clip.shapes) shaped.insert(track.node);
    if (result.empty()) {
      result.push_back(std::move(clip));
      continue;
    }
    Clip& first = result.front();
    first.tracks.insert(first.tracks.end(), std::make_move_iterator(clip.tracks.begin()),
                        std::make_move_iterator(clip.tracks.end()));
    first.shapes.insert(first.shapes.end(), std::make_move_iterator(clip.shapes.begin()),
                        std::make_move_iterator(clip.shapes.end()));
  }
  character.clips = std::move(result);
  if (moved_again != none)
    character.notes.push_back("several animations move `" + character.nodes[moved_again].name +
                              "`; the first clip has only the first of them, and the others are clips of "
                              "their own");
}

}  // namespace

void add_clips(Character& character, const Source& source) {
  std::set<std::string> lost_shapes;
  for (unsigned a = 0; a < character.scene->mNumAnimations; ++a) {
    const aiAnimation& animation = *character.scene->mAnimations[a];
    constexpr double usual_rate = 25.0;  // used if the file does not say; assimp's convention
    const double seconds = 1.0 / (animation.mTicksPerSecond > 0.0 ? animation.mTicksPerSecond : usual_rate);
    Channels channels;
    for (unsigned c = 0; c < animation.mNumChannels; ++c)
      channels.emplace(animation.mChannels[c]->mNodeName.C_Str(), animation.mChannels[c]);
    // Assimp takes an FBX clip's start and end from its stack or from the keys of its nodes. If these have no
    // keys either, its duration is negative and its times mean nothing.
    const bool begins_at_key = !source.is_fbx || animation.mDuration < 0.0;
    Span of_nodes;
    if (!begins_at_key) of_nodes = {0.0, animation.mDuration};
    Span of_shapes = of_nodes;
    if (!source.has_spans || animation.mDuration == 0.0) of_shapes.last = Span().last;
    Clip clip;
    clip.name = animation.mName.C_Str();
    for (std::size_t n = 0; n < character.nodes.size(); ++n) {
      const Node& node = character.nodes[n];
      if (find_node(character, node.name) != n) continue;
      const auto whole = channels.find(node.name);
      Track track = whole != channels.end() ? whole_track(node, *whole->second, seconds, of_nodes)
                                            : chained_track(node, channels, seconds, of_nodes);
      track.node = n;
      if (!track.times.empty()) clip.tracks.push_back(std::move(track));
    }
    add_shape_tracks(animation, seconds, of_shapes, character, clip, lost_shapes);
    if (source.is_fbx && begins_at_key) begin_at_zero(clip);
    character.clips.push_back(std::move(clip));
  }
  if (!source.is_fbx) {
    if (!source.has_several_clips)
      join_clips(character);
    else if (character.clips.size() > 1)
      character.notes.push_back(
          "the file names several clips, and which animations they have is not read: each "
          "animation is a clip of its own. Export each clip into a file of its own");
    for (Clip& clip : character.clips) begin_at_zero(clip);
  }
  if (lost_shapes.empty()) return;
  const std::string others =
      lost_shapes.size() == 1 ? "" : " and " + std::to_string(lost_shapes.size() - 1) + " more";
  character.notes.push_back("no mesh has the blend shapes that clips move as `" + *lost_shapes.begin() + "`" +
                            others);
}

}  // namespace fascicle::convert
