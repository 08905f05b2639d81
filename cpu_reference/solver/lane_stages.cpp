#include "cpu_reference/solver/lane_stages.h"

#include <algorithm>
#include <array>
#include <utility>

namespace fascicle::cpu_reference {

namespace {

constexpr std::array<std::pair<Simd, const char*>, 6> names{{{Simd::automatic, "auto"},
                                                             {Simd::scalar, "scalar"},
                                                             {Simd::baseline, "baseline"},
                                                             {Simd::sse4, "sse4"},
                                                             {Simd::avx2, "avx2"},
                                                             {Simd::avx512, "avx512"}}};

bool machine_has(Simd level) {
#if defined(__x86_64__) || defined(__i386__)
  if (level == Simd::sse4) return __builtin_cpu_supports("sse4.1") != 0;
  if (level == Simd::avx2) return __builtin_cpu_supports("avx2") != 0;
  if (level == Simd::avx512)
    return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
           __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512vl") != 0;
#endif
  return level == Simd::scalar || level == Simd::baseline;
}

const LaneStages* compiled_stages(Simd level) {
  switch (level) {
    case Simd::baseline:
      return baseline_lane_stages();
    case Simd::sse4:
      return sse4_lane_stages();
    case Simd::avx2:
      return avx2_lane_stages();
    case Simd::avx512:
      return avx512_lane_stages();
    case Simd::automatic:
    case Simd::scalar:
      break;
  }
  return nullptr;
}

template <class Values>
const typename Values::value_type* data_or_null(const Values& values) {
  return values.empty() ? nullptr : values.data();
}

}  // namespace

const char* name_of(Simd level) {
  return std::find_if(names.begin(), names.end(), [&](const auto& entry) { return entry.first == level; })
      ->second;
}

std::optional<Simd> simd_named(std::string_view name) {
  for (const auto& [level, its_name] : names)
    if (name == its_name) return level;
  return std::nullopt;
}

std::vector<Simd> available_simd() {
  std::vector<Simd> found{Simd::scalar};
  for (const Simd level : {Simd::baseline, Simd::sse4, Simd::avx2, Simd::avx512})
    if (lane_stages(level) != nullptr) found.push_back(level);
  return found;
}

const LaneStages* lane_stages(Simd level) {
  if (level == Simd::automatic) level = available_simd().back();
  return machine_has(level) ? compiled_stages(level) : nullptr;
}

LaneInput lane_input(const model::Model& model, const Slices& slices, const SubstepInput& in,
                     Fields& fields) {
  LaneInput out{.vertex_count = model.vertex_count,
                .first_row = slices.first_row.data(),
                .full_rows = slices.full_rows.data(),
                .degree = slices.degree.data(),
                .taken_degree = slices.taken_degree.data(),
                .is_held = slices.is_held.data(),
                .layer = slices.layer.data(),
                .reach = slices.reach.data(),
                .near_ring = data_or_null(slices.near_ring),
                .taken_parts = slices.taken_parts.data(),
                .given_parts = slices.given_parts.data(),
                .far_ring = slices.far_ring.data(),
                .taken = slices.taken.data(),
                .given = slices.given.data(),
                .arrays = {},
                .muscle_count = model.muscle_count,
                .force_count = model.force_count,
                .has_skeleton = model.has_skeleton(),
                .limit_count = static_cast<std::uint32_t>(model.limit.size()),
                .listed_limit = nullptr,
                .step = in.step,
                .implicit = in.implicit,
                .responses = in.responses.data(),
                .bones = in.bones.data(),
                .muscles = in.muscles.data(),
                .forces = in.forces.data(),
                .decay = in.decay.data(),
                .vertices = fields.vertices.data(),
                .regions = fields.regions.data(),
                .velocities = fields.velocities.data(),
                .predicted = fields.predicted.data(),
                .goals = fields.goals.data(),
                .skinned = fields.skinned.data(),
                .skinned_velocities = fields.skinned_velocities.data(),
                .gravity = fields.gravity.data(),
                .tied = data_or_null(fields.tied),
                .iterate_before = fields.iterate_before.data(),
                .positions_before = fields.positions_before.data(),
                .velocities_before = fields.velocities_before.data(),
                .skinned_before = fields.skinned_before.data(),
                .lack = fields.lack.data(),
                .some_lack = fields.some_lack.data()};
  std::size_t k = 0;
  base::for_each_row(model::model_arrays, [&](const auto& row) {
    if constexpr (model::is_array_row<std::decay_t<decltype(row)>>)
      out.arrays[k] = data_or_null(model.*row.member);
    ++k;
  });
  return out;
}

}  // namespace fascicle::cpu_reference
