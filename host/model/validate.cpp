#include "host/model/validate.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace fascicle::model {

namespace {

// Keeps one frame's stage outputs, in the order shown.
class Recorder : public Probe {
 public:
  struct Shown {
    Where where;
    std::vector<float> values;
  };
  void on_stage(const Where& where, std::span<const float> values) override {
    shown_.push_back({where, {values.begin(), values.end()}});
  }
  const std::vector<Shown>& shown() const { return shown_; }
  void clear() { shown_.clear(); }

 private:
  std::vector<Shown> shown_;
};

// Orders floats as integers: neighbours differ by one, -0 and +0 are one apart.
std::int64_t ordered(float x) {
  const auto u = std::bit_cast<std::uint32_t>(x);
  return (u & 0x80000000u) != 0 ? -std::int64_t{u & 0x7fffffffu} - 1 : std::int64_t{u};
}

std::optional<Difference> compare(const Where& where, std::uint32_t width, std::span<const float> a,
                                  std::span<const float> b) {
  Difference difference{.where = where};
  if (a.size() != b.size()) {
    difference.item = static_cast<std::uint32_t>(std::min(a.size(), b.size()) / width);
    difference.a = static_cast<float>(a.size());
    difference.b = static_cast<float>(b.size());
    difference.ulp = std::numeric_limits<std::uint64_t>::max();
    return difference;
  }
  for (std::size_t k = 0; k < a.size(); ++k) {
    if (std::bit_cast<std::uint32_t>(a[k]) == std::bit_cast<std::uint32_t>(b[k])) continue;
    difference.item = static_cast<std::uint32_t>(k / width);
    difference.component = static_cast<std::uint32_t>(k % width);
    difference.a = a[k];
    difference.b = b[k];
    difference.ulp = ulp_distance(a[k], b[k]);
    return difference;
  }
  return std::nullopt;
}

}  // namespace

std::uint64_t ulp_distance(float a, float b) {
  if (std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b)) return 0;
  if (std::isnan(a) || std::isnan(b)) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(std::abs(ordered(a) - ordered(b)));
}

std::optional<Difference> first_difference(Solver& a, Solver& b, const DriveSource& drives,
                                           std::uint64_t frames,
                                           const std::function<void(std::uint64_t)>& on_frame) {
  Recorder stages_a, stages_b;
  const Read everything{.positions = true, .velocities = true, .surface = true};
  for (std::uint64_t k = 1; k <= frames; ++k) {
    const Drive drive = drives(k);
    stages_a.clear();
    stages_b.clear();
    a.submit(drive, everything, &stages_a);
    b.submit(drive, everything, &stages_b);
    const Frame frame_a = a.collect(), frame_b = b.collect();
    const std::size_t count = std::max(stages_a.shown().size(), stages_b.shown().size());
    for (std::size_t s = 0; s < count; ++s) {
      // A stage that only one of them showed counts as a difference in its first value.
      static const Recorder::Shown nothing{};
      const auto& shown_a = s < stages_a.shown().size() ? stages_a.shown()[s] : nothing;
      const auto& shown_b = s < stages_b.shown().size() ? stages_b.shown()[s] : nothing;
      Where where = &shown_a == &nothing ? shown_b.where : shown_a.where;
      where.frame = k;
      if (auto difference = compare(where, stage_width(where.stage), shown_a.values, shown_b.values))
        return difference;
    }
    const Where last{.frame = k, .substep = drive.substeps - 1, .stage = Stage::integrate};
    if (auto difference = compare(last, 3, frame_a.positions, frame_b.positions)) return difference;
    if (auto difference = compare(last, 3, frame_a.velocities, frame_b.velocities)) return difference;
    const Where end{.frame = k, .substep = drive.substeps - 1, .stage = Stage::embed};
    if (auto difference = compare(end, 3, frame_a.surface, frame_b.surface)) return difference;
    if (on_frame) on_frame(k);
  }
  return std::nullopt;
}

std::uint64_t position_hash(const Frame& frame) {
  return XXH3_64bits(frame.positions.data(), frame.positions.size() * sizeof(float));
}

Distance distance_to(const Model& model, Solver& solver, Solver& reference, const DriveSource& drives,
                     std::uint64_t frames) {
  Distance distance;
  double sum = 0.0;
  for (std::uint64_t k = 1; k <= frames; ++k) {
    const Drive drive = drives(k);
    const Read positions{.positions = true};
    solver.submit(drive, positions);
    reference.submit(drive, positions);
    const Frame a = solver.collect(), b = reference.collect();
    for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
      double squared = 0.0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double d =
            static_cast<double>(a.positions[3 * i + c]) - static_cast<double>(b.positions[3 * i + c]);
        squared += d * d;
      }
      sum += squared;
      // Negated so that a NaN counts as the largest distance.
      if (const double d = std::sqrt(squared) * model.unit; !(d <= distance.largest)) {
        distance.largest = std::isnan(d) ? std::numeric_limits<double>::infinity() : d;
        distance.frame = k;
        distance.vertex = i;
      }
    }
  }
  const double count = static_cast<double>(frames) * static_cast<double>(model.vertex_count);
  distance.rms = count > 0 ? std::sqrt(sum / count) * model.unit : 0.0;
  return distance;
}

}  // namespace fascicle::model
