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
#include "host/bake/sealed_file.h"
#include "host/base/errors.h"
#include "host/base/json_text.h"
#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/scene/scene_json.h"

namespace fascicle::bake {

using scene::Json;

namespace fs = std::filesystem;

namespace {

constexpr std::string_view checkpoint_magic = "FASCCKPT";
constexpr std::uint32_t checkpoint_version = 4;

// The file in pieces, without copying the arrays: a bake writes many checkpoints of megabytes each.
class Pieces {
 public:
  explicit Pieces(const CheckpointView& checkpoint);
  std::span<const std::string_view> all() const { return pieces_; }

 private:
  // Appends bytes between the arrays.
  template <class T>
  void add(const T& value) {
    base::append_bytes(between_, value);
  }
  void add(const std::vector<float>& values) {
    add(std::uint64_t{values.size()});
    arrays_.push_back({between_.size(), values});
  }
  void cut();

  struct Array {
    std::size_t at;  // offset into those bytes
    std::span<const float> values;
  };
  std::string between_;
  std::vector<Array> arrays_;
  std::vector<std::string_view> pieces_;
};

Pieces::Pieces(const CheckpointView& checkpoint) {
  const std::string identity = scene::dump(Json(checkpoint.identity));
  const model::State& state = checkpoint.state;
  between_ = checkpoint_magic;
  add(checkpoint_version);
  add(static_cast<std::uint32_t>(identity.size()));
  between_ += identity;
  add(state.frame);
  add(state.origin);
  for (const std::vector<float>* array :
       {&state.positions, &state.velocities, &state.rotations, &state.skinned, &state.skinned_velocities,
        &state.positions_before, &state.velocities_before})
    add(*array);
  add(state.step_before);
  for (const std::vector<float>& skinned : checkpoint.skinned) add(skinned);
  cut();
  XXH3_state_t hash;
  XXH3_64bits_reset(&hash);
  for (const std::string_view piece : pieces_) XXH3_64bits_update(&hash, piece.data(), piece.size());
  add(XXH3_64bits_digest(&hash));
  cut();
}

// Rebuilds all pieces, because between_ may have been reallocated.
void Pieces::cut() {
  pieces_.clear();
  const std::string_view between = between_;
  std::size_t begin = 0;
  for (const Array& array : arrays_) {
    pieces_.push_back(between.substr(begin, array.at - begin));
    pieces_.push_back(base::bytes_of(array.values));
    begin = array.at;
  }
  pieces_.push_back(between.substr(begin));
}

// Takes values off the front of a file's bytes; checks every length against what is left.
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
  const Pieces pieces(view_of(checkpoint));
  std::string bytes;
  for (const std::string_view piece : pieces.all()) bytes += piece;
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
                    ": another version of fascicle wrote this checkpoint; start again with --overwrite");
  Checkpoint checkpoint;
  const auto identity_bytes = parser.value<std::uint32_t>();
  const Json identity = Json::parse(base::shallow_json(parser.take(identity_bytes)), nullptr, false);
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

void write_checkpoint(const fs::path& path, const CheckpointView& checkpoint) {
  base::write_whole(path, Pieces(checkpoint).all());
}

std::optional<Checkpoint> read_checkpoint(const fs::path& path) {
  if (!fs::exists(path)) return std::nullopt;
  return parse_checkpoint(read_sealed(base::File(path, base::FileMode::read), checkpoint_magic), path);
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
  // Frame 0 has no frame before it.
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
  // Positions, velocities, rotations; with a skeleton the skinned positions, now and in two frames; for an
  // implicit run the state before the last substep; skinned velocities if some vertex is carried.
  constexpr std::uint64_t identity = 4096;  // of the built-in scenes: about 2000
  const std::uint64_t floats = (model.has_skeleton() ? 19u : 10u) + (model.is_implicit() ? 6u : 0u);
  return (floats * model.vertex_count + 3 * model.carried.size()) * sizeof(float) + identity;
}

}  // namespace fascicle::bake
