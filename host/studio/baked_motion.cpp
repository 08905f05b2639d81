#include "host/studio/baked_motion.h"

#include <algorithm>
#include <charconv>
#include <exception>
#include <limits>
#include <sstream>
#include <string>
#include <utility>

#include "host/bake/outputs.h"
#include "host/base/csv.h"
#include "host/base/errors.h"
#include "host/base/file.h"
#include "host/model/validate.h"
#include "host/scene/scene.h"

namespace fascicle::studio {

namespace {

constexpr float not_known = std::numeric_limits<float>::quiet_NaN();

// Energy of each frame, J; not_known where metrics.csv has no number.
std::vector<float> energies_of(const std::filesystem::path& folder, std::uint64_t frames) {
  std::vector<float> energies(frames, not_known);
  try {
    const std::filesystem::path path = folder / bake::metrics_name;
    std::istringstream file(base::read_input_if_there(path, base::most_metrics_bytes).value_or(""));
    std::string line;
    if (!std::getline(file, line)) return energies;
    const std::vector<std::string> header = base::csv_columns(line, path);
    const auto found = std::find(header.begin(), header.end(), "kinetic_energy");
    if (found == header.end()) return energies;
    const auto column = static_cast<std::size_t>(found - header.begin());
    for (std::uint64_t k = 0; k < frames && std::getline(file, line); ++k) {
      const std::vector<std::string> fields = base::csv_fields(line);
      if (column >= fields.size()) continue;
      const std::string& text = fields[column];
      double value = 0.0;
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      if (error == std::errc() && end == text.data() + text.size()) energies[k] = static_cast<float>(value);
    }
  } catch (const std::runtime_error&) {
    // Frames can be shown without energies.
  }
  return energies;
}

}  // namespace

BakedMotion::BakedMotion(std::unique_ptr<pipeline::OpenBake> bake, const std::filesystem::path& folder)
    : bake_(std::move(bake)),
      measures_(bake_->model()),
      energies_(energies_of(folder, bake_->frame_count())) {
  const bool has_skeleton = bake_->model().has_skeleton();
  // If the scene's inputs are gone or have changed, the frames can still be shown.
  const auto go_without = [&](const std::exception& error) {
    if (has_skeleton) why_no_lag_ = error.what();
  };
  try {
    (void)bake_->scene();
    has_scene_ = true;
    has_skinning_ = has_skeleton;
  } catch (const scene::SceneError& error) {
    go_without(error);
  } catch (const base::BakeError& error) {
    go_without(error);
  }
  seek(0);
}

ShownFrame BakedMotion::seek(std::uint64_t frame) {
  now_ = bake_->frame(std::min(frame, frames()));
  if (has_skinning_) {
    pipeline::OpenBake::Skinned skinned = bake_->skinned(now_.index);
    // Relative to the frame's own origin.
    for (std::size_t k = 0; k < skinned.positions.size(); ++k)
      skinned.positions[k] +=
          static_cast<float>((skinned.origin[k % 3] - now_.origin[k % 3]) / bake_->model().unit);
    now_.skinned = std::move(skinned.positions);
  }
  return again();
}

ShownFrame BakedMotion::again() {
  ShownFrame shown{.model = &bake_->model(), .frame = &now_, .numbers = {}};
  shown.numbers.frame = static_cast<std::uint32_t>(now_.index);
  shown.numbers.time = bake_->start() + static_cast<double>(now_.index) / bake_->fps();
  shown.numbers.position_hash = model::position_hash(now_);
  measures_.fill(now_, shown.numbers);
  shown.numbers.energy = now_.index < energies_.size() ? energies_[now_.index] : not_known;
  return shown;
}

std::vector<float> BakedMotion::joints() {
  std::vector<float> places;
  if (!has_skinning_) return places;
  const double scale = bake_->scene().scale;
  for (const Eigen::Matrix4d& map : bake_->joints(now_.index))
    for (int a = 0; a < 3; ++a) places.push_back(static_cast<float>(scale * map(a, 3)));
  return places;
}

std::vector<scene::Solid> BakedMotion::solids() {
  return has_scene_ ? bake_->solids(now_.index) : std::vector<scene::Solid>();
}

}  // namespace fascicle::studio
