#include "host/rig/pose.h"

#include <charconv>
#include <optional>

#include "host/base/errors.h"
#include "host/base/nearest_name.h"
#include "host/rig/pose_interpolation.h"

namespace fascicle::rig {
namespace {

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || (c & 0x80) != 0;
}

// Whether `text` ends with `end`, preceded by a separator.
template <class Separates>
bool ends_with_part(const std::string& text, const std::string& end, const Separates& separates) {
  return text.size() > end.size() && text.ends_with(end) && separates(text[text.size() - end.size() - 1]);
}

// Tries rules from strict to lenient; the first one that matches any clip decides.
std::vector<std::size_t> clips_called(const std::vector<Clip>& clips, const std::string& name) {
  const auto is_of_armature = [](char c) { return c == '|' || c == ':' || c == '/'; };
  const auto is_any = [](char c) { return !is_letter_or_digit(c); };
  std::vector<std::size_t> found;
  for (int way = 0; way < 6 && found.empty(); ++way) {
    const bool ignores_case = way % 2 == 1;
    const std::string wanted = ignores_case ? lower(name) : name;
    for (std::size_t i = 0; i < clips.size(); ++i) {
      const std::string has = ignores_case ? lower(clips[i].name) : clips[i].name;
      const bool answers = way < 2   ? has == wanted
                           : way < 4 ? ends_with_part(has, wanted, is_of_armature)
                                     : ends_with_part(has, wanted, is_any);
      if (answers) found.push_back(i);
    }
  }
  return found;
}

// What a clip's channels make of the joints that they move.
std::vector<std::optional<JointParts>> moved_parts(const Character& character, const Clip* clip,
                                                   double time) {
  std::vector<std::optional<JointParts>> moved(character.skeleton.size());
  if (clip == nullptr) return moved;
  for (const Channel& channel : clip->channels) {
    const Joint& joint = character.skeleton[channel.joint];
    std::optional<JointParts>& parts = moved[channel.joint];
    if (!parts) parts = JointParts{joint.rest_translation, joint.rest_scale, joint.rest_rotation};
    const Eigen::Vector4d value = sample(channel, time);
    switch (channel.path) {
      case ChannelPath::translation:
        parts->translation = value.head<3>();
        break;
      case ChannelPath::scale:
        parts->scale = value.head<3>();
        break;
      case ChannelPath::rotation:
        parts->rotation = value;
        break;
    }
  }
  return moved;
}

std::string list_of_clips(const std::vector<Clip>& clips) {
  std::string text;
  for (std::size_t i = 0; i < clips.size(); ++i)
    text += (i == 0 ? "" : ", ") + std::to_string(i) +
            (clips[i].name.empty() ? std::string(" (without a name)") : " `" + clips[i].name + "`");
  return text;
}

}  // namespace

const Clip* find_clip(const Character& character, const std::string& name) {
  const std::vector<Clip>& clips = character.clips;
  if (name.empty()) return clips.empty() ? nullptr : &clips.front();
  for (const Clip& clip : clips) {
    if (clip.name == name) return &clip;
  }
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  if (error == std::errc() && end == name.data() + name.size() && index < clips.size()) return &clips[index];
  const std::vector<std::size_t> found = clips_called(clips, name);
  if (found.size() == 1) return &clips[found.front()];
  if (found.size() > 1) {
    std::string several;
    for (const std::size_t i : found)
      several += (several.empty() ? "" : ", ") + std::to_string(i) + " `" + clips[i].name + "`";
    throw base::SceneError("`" + name + "` matches several clips: " + several +
                           "; give the number or the whole name");
  }
  if (clips.empty())
    throw base::SceneError("the character has no clip `" + name + "`; it has no clips. Leave the clip out");
  std::vector<std::string> names;
  for (const Clip& clip : clips) {
    names.push_back(clip.name);
    names.push_back(clip.name.substr(clip.name.find_last_of("|:/") + 1));
  }
  const std::string hint = base::nearest_name_hint(name, names);
  throw base::SceneError("the character has no clip `" + name + "`" +
                         (hint.empty() ? "; it has " : hint + " It has ") + list_of_clips(clips));
}

std::vector<Eigen::Matrix4d> joint_transforms_at(const Character& character, const Clip* clip, double time) {
  const std::vector<std::optional<JointParts>> moved = moved_parts(character, clip, time);
  std::vector<Eigen::Matrix4d> joints;
  joints.reserve(moved.size());
  for (std::size_t j = 0; j < moved.size(); ++j) {
    const Joint& joint = character.skeleton[j];
    const Eigen::Matrix4d& above =
        joint.parent < 0 ? character.root : joints[static_cast<std::size_t>(joint.parent)];
    const Eigen::Matrix4d local =
        moved[j] ? local_transform(moved[j]->translation, moved[j]->rotation, moved[j]->scale)
                 : joint.rest_local;
    joints.emplace_back(above * local);
  }
  return joints;
}

std::vector<JointParts> joint_parts_at(const Character& character, const Clip* clip, double time) {
  const std::vector<std::optional<JointParts>> moved = moved_parts(character, clip, time);
  std::vector<JointParts> parts;
  for (std::size_t j = 0; j < moved.size(); ++j)
    parts.push_back(moved[j] ? *moved[j] : joint_parts(character.skeleton[j].rest_local));
  return parts;
}

std::vector<Eigen::Matrix4d> pose_at(const Character& character, const Clip* clip, double time) {
  std::vector<Eigen::Matrix4d> pose = joint_transforms_at(character, clip, time);
  for (std::size_t j = 0; j < pose.size(); ++j)
    pose[j] = (pose[j] * character.skeleton[j].inverse_bind).eval();
  return pose;
}

}  // namespace fascicle::rig
