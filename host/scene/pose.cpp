#include "host/scene/pose.h"

#include <charconv>

#include "host/scene/pose_interpolation.h"

namespace fascicle::scene {
const Clip* find_clip(const Character& character, const std::string& name) {
  const std::vector<Clip>& clips = character.clips;
  if (name.empty()) return clips.empty() ? nullptr : &clips.front();
  for (const Clip& clip : clips) {
    if (clip.name == name) return &clip;
  }
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  if (error == std::errc() && end == name.data() + name.size() && index < clips.size()) return &clips[index];
  std::string text = "the character has no clip `" + name + "`";
  if (clips.empty()) throw SceneError(text + ", nor any other; leave the clip out");
  text += "; it has ";
  for (std::size_t i = 0; i < clips.size(); ++i) {
    text += (i == 0 ? "" : ", ") + std::to_string(i) + " `" + clips[i].name + "`";
  }
  throw SceneError(text);
}

std::string clip_name(const Scene& scene) {
  const auto* character = std::get_if<Character>(&scene.geometry);
  const Clip* clip = character != nullptr ? find_clip(*character, scene.clip) : nullptr;
  return clip != nullptr ? clip->name : std::string();
}

std::vector<Eigen::Matrix4d> joint_transforms_at(const Character& character, const Clip* clip, double time) {
  const std::size_t count = character.skeleton.size();
  std::vector<Eigen::Matrix4d> local(count);
  for (std::size_t j = 0; j < count; ++j) local[j] = character.skeleton[j].rest_local;
  if (clip != nullptr) {
    struct Parts {
      Vector3d translation, scale;
      Eigen::Vector4d rotation;
      bool moved = false;
    };
    std::vector<Parts> parts(count);
    for (const Channel& channel : clip->channels) {
      const Joint& joint = character.skeleton[channel.joint];
      Parts& p = parts[channel.joint];
      if (!p.moved) p = {joint.rest_translation, joint.rest_scale, joint.rest_rotation, true};
      const Eigen::Vector4d value = sample(channel, time);
      switch (channel.path) {
        case ChannelPath::translation:
          p.translation = value.head<3>();
          break;
        case ChannelPath::scale:
          p.scale = value.head<3>();
          break;
        case ChannelPath::rotation:
          p.rotation = value;
          break;
      }
    }
    for (std::size_t j = 0; j < count; ++j) {
      if (parts[j].moved) local[j] = local_transform(parts[j].translation, parts[j].rotation, parts[j].scale);
    }
  }
  for (std::size_t j = 0; j < count; ++j) {
    const std::int32_t parent = character.skeleton[j].parent;
    const Eigen::Matrix4d& above = parent < 0 ? character.root : local[static_cast<std::size_t>(parent)];
    local[j] = (above * local[j]).eval();
  }
  return local;
}

std::vector<Eigen::Matrix4d> pose_at(const Character& character, const Clip* clip, double time) {
  std::vector<Eigen::Matrix4d> pose = joint_transforms_at(character, clip, time);
  for (std::size_t j = 0; j < pose.size(); ++j)
    pose[j] = (pose[j] * character.skeleton[j].inverse_bind).eval();
  return pose;
}

}  // namespace fascicle::scene
