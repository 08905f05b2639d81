#include "host/api/saved_state.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "host/bake/checkpoint.h"
#include "host/base/content_hash.h"

namespace fascicle::api {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::string_view magic = "FASCSTP2";

constexpr std::size_t hash_digits = 32;

struct Head {
  std::uint64_t frame, driven, pose_numbers;
  double time;
};

constexpr std::size_t joint_numbers = 16;

std::string hash_of(std::string_view bytes) {
  base::ContentHash hash;
  hash.add(bytes);
  return hash.text();
}

[[noreturn]] void refuse_state(const std::string& why) {
  throw bake::BakeError("the solver's state cannot be used: " + why);
}

// The hash keeps out damage, not a forger.
void check_values(const SavedState& saved, const model::Model& model) {
  try {
    model::check_state(model, saved.state);
  } catch (const std::invalid_argument& error) {
    refuse_state(error.what());
  }
  const bool is_finite =
      std::isfinite(saved.time) &&
      std::ranges::all_of(saved.state.origin, [](double x) { return std::isfinite(x); }) &&
      std::ranges::all_of(saved.pose, [](const Eigen::Matrix4d& joint) { return joint.allFinite(); });
  if (!is_finite) refuse_state("its time, origin or pose is not finite");
}

}  // namespace

std::string saved_state_bytes(const SavedState& saved, const bake::Identity& identity) {
  const Head head{saved.frame, static_cast<std::uint64_t>(saved.driven), joint_numbers * saved.pose.size(),
                  saved.time};
  std::string bytes(reinterpret_cast<const char*>(&head), sizeof head);
  for (const Eigen::Matrix4d& joint : saved.pose)
    bytes.append(reinterpret_cast<const char*>(joint.data()), joint_numbers * sizeof(double));
  bytes += bake::checkpoint_text({identity, saved.state});
  return std::string(magic) + hash_of(bytes) + bytes;
}

SavedState parse_saved_state(std::string_view bytes, const StateOwner& owner) {
  if (!bytes.starts_with(magic)) refuse_state("the bytes are not from fascicle_solver_save of this version");
  bytes.remove_prefix(magic.size());
  const std::string_view hash = bytes.substr(0, hash_digits);
  bytes.remove_prefix(hash.size());
  Head head{};
  if (hash != hash_of(bytes) || bytes.size() < sizeof head) refuse_state("the bytes are damaged or cut off");
  std::memcpy(&head, bytes.data(), sizeof head);
  bytes.remove_prefix(sizeof head);
  if (head.pose_numbers > bytes.size() / sizeof(double) ||
      head.driven > static_cast<std::uint64_t>(Driven::by_drives))
    refuse_state("the bytes are damaged");
  SavedState saved;
  saved.frame = head.frame;
  saved.driven = static_cast<Driven>(head.driven);
  saved.time = head.time;
  const std::uint64_t joints = saved.driven == Driven::by_poses ? owner.model.joint_count : 0;
  if (head.pose_numbers != joint_numbers * joints) refuse_state("it is from another model");
  if (saved.driven != Driven::no && saved.driven != Driven::by_drives && !owner.has_scene)
    refuse_state("it is from another model");
  saved.pose.resize(joints);
  for (Eigen::Matrix4d& joint : saved.pose) {
    std::memcpy(joint.data(), bytes.data(), joint_numbers * sizeof(double));
    bytes.remove_prefix(joint_numbers * sizeof(double));
  }
  bake::Checkpoint found = bake::parse_checkpoint(bytes, "the solver's state");
  if (const std::string text = text_of(bake::differences(found.identity, owner.identity)); !text.empty())
    refuse_state("it is from another model or solver: " + text);
  saved.state = std::move(found.state);
  check_values(saved, owner.model);
  return saved;
}

}  // namespace fascicle::api
