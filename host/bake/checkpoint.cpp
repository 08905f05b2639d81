#include "host/bake/checkpoint.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <system_error>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "host/bake/look.h"
#include "host/base/errors.h"
#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/scene/scene_json.h"

namespace fascicle::bake {

using scene::Json;

namespace fs = std::filesystem;

namespace {

constexpr std::string_view checkpoint_magic = "FASCCKPT";
constexpr std::uint32_t checkpoint_version = 4;

void append_floats(std::string& out, const std::vector<float>& values) {
  base::append_bytes(out, std::uint64_t{values.size()});
  base::append_array(out, std::span<const float>(values));
}

// Takes values off the front of a file's bytes; every length is checked against what is left.
class Parser {
 public:
  Parser(std::string_view bytes, const fs::path& path) : bytes_(bytes), path_(&path) {}
  template <class T>
  T value() {
    T result;
    std::memcpy(&result, take(sizeof result).data(), sizeof result);
    return result;
  }
  std::string_view take(std::uint64_t count) {
    if (count > bytes_.size()) damaged();
    const std::string_view front = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return front;
  }
  std::vector<float> floats() {
    const auto count = value<std::uint64_t>();
    if (count > bytes_.size() / sizeof(float)) damaged();
    const std::string_view raw = take(count * sizeof(float));
    std::vector<float> values(count);
    if (count > 0) std::memcpy(values.data(), raw.data(), raw.size());
    return values;
  }
  [[noreturn]] void damaged() const {
    throw BakeError(path_->string() + ": the checkpoint is damaged; start again with --overwrite");
  }

 private:
  std::string_view bytes_;
  const fs::path* path_;
};

}  // namespace

std::string checkpoint_text(const Checkpoint& checkpoint) {
  const std::string identity = scene::dump(Json(checkpoint.identity));
  const model::State& state = checkpoint.state;
  std::string bytes(checkpoint_magic);
  base::append_bytes(bytes, checkpoint_version);
  base::append_bytes(bytes, static_cast<std::uint32_t>(identity.size()));
  bytes += identity;
  base::append_bytes(bytes, state.frame);
  base::append_bytes(bytes, state.origin);
  append_floats(bytes, state.positions);
  append_floats(bytes, state.velocities);
  append_floats(bytes, state.rotations);
  append_floats(bytes, state.skinned);
  append_floats(bytes, state.skinned_velocities);
  append_floats(bytes, state.positions_before);
  append_floats(bytes, state.velocities_before);
  base::append_bytes(bytes, state.step_before);
  for (const std::vector<float>& skinned : checkpoint.skinned) append_floats(bytes, skinned);
  const std::uint64_t checksum = XXH3_64bits(bytes.data(), bytes.size());
  base::append_bytes(bytes, checksum);
  return bytes;
}

Checkpoint parse_checkpoint(std::string_view bytes, const fs::path& path) {
  Parser parser(bytes, path);
  if (bytes.size() < checkpoint_magic.size() + sizeof(std::uint64_t)) parser.damaged();
  const std::size_t length = bytes.size() - sizeof(std::uint64_t);
  std::uint64_t checksum = 0;
  std::memcpy(&checksum, bytes.data() + length, sizeof checksum);
  parser = Parser(bytes.substr(0, length), path);
  if (parser.take(checkpoint_magic.size()) != checkpoint_magic ||
      XXH3_64bits(bytes.data(), length) != checksum)
    parser.damaged();
  if (parser.value<std::uint32_t>() != checkpoint_version)
    throw BakeError(path.string() +
                    ": a checkpoint of another version of fascicle; start again with --overwrite");
  Checkpoint checkpoint;
  const auto identity_bytes = parser.value<std::uint32_t>();
  const Json identity = Json::parse(parser.take(identity_bytes), nullptr, false);
  if (identity.is_discarded()) parser.damaged();
  try {
    checkpoint.identity = identity.get<Identity>();
  } catch (const Json::exception&) {
    parser.damaged();
  }
  model::State& state = checkpoint.state;
  state.frame = parser.value<std::uint64_t>();
  state.origin = parser.value<std::array<double, 3>>();
  state.positions = parser.floats();
  state.velocities = parser.floats();
  state.rotations = parser.floats();
  state.skinned = parser.floats();
  state.skinned_velocities = parser.floats();
  state.positions_before = parser.floats();
  state.velocities_before = parser.floats();
  state.step_before = parser.value<double>();
  for (std::vector<float>& skinned : checkpoint.skinned) skinned = parser.floats();
  return checkpoint;
}

void write_checkpoint(const fs::path& path, const Checkpoint& checkpoint) {
  base::write_whole(path, checkpoint_text(checkpoint));
}

std::optional<Checkpoint> read_checkpoint(const fs::path& path) {
  if (!fs::exists(path)) return std::nullopt;
  const base::File file(path, base::FileMode::read);
  std::string bytes(file.size(), '\0');
  if (!file.read_at(0, bytes))
    throw BakeError(path.string() + ": the checkpoint is damaged; start again with --overwrite");
  return parse_checkpoint(bytes, path);
}

void check_checkpoint(const Checkpoint& checkpoint, const model::Model& model, std::uint64_t frames,
                      const fs::path& path) {
  const auto damaged = [&](const std::string& what) {
    return BakeError(path.string() + ": the checkpoint is damaged (" + what +
                     "); start again with --overwrite");
  };
  const model::State& state = checkpoint.state;
  if (state.frame > frames)
    throw damaged("frame " + base::number_text(state.frame) + " of " + base::number_text(frames));
  if (!std::all_of(state.origin.begin(), state.origin.end(),
                   [](double value) { return std::isfinite(value); }))
    throw damaged("its origin is not finite");
  try {
    model::check_state(model, state);
  } catch (const std::invalid_argument& error) {
    throw damaged(error.what());
  }
  if (!has_look(model)) return;
  const std::size_t floats = std::size_t{3} * model.vertex_count;
  // Of frame 0 there is no frame before.
  for (std::size_t k = state.frame == 0 ? 1 : 0; k < checkpoint.skinned.size(); ++k)
    if (checkpoint.skinned[k].size() != floats) throw damaged("its skinned positions are of another body");
}

bool is_checkpoint(const fs::path& path) {
  try {
    std::array<char, 8> bytes{};
    return base::File(path, base::FileMode::read).read_at(0, bytes) &&
           std::string_view(bytes.data(), bytes.size()) == checkpoint_magic;
  } catch (const base::InputError&) {
    return false;
  } catch (const std::system_error&) {
    return false;
  }
}

std::uint64_t checkpoint_bytes(const model::Model& model) {
  // Positions, velocities, rotations, the skinned positions that only a skeleton has, now and of two frames,
  // what an implicit run keeps of the substep before, and the skinned velocities where some vertex is
  // carried; the rest is the identity.
  const std::uint64_t floats = (model.has_skeleton() ? 19u : 10u) + (model.is_implicit() ? 6u : 0u);
  return (floats * model.vertex_count + 3 * model.carried.size()) * sizeof(float) + 1024;
}

}  // namespace fascicle::bake
