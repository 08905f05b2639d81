// Encoding a frame for the session's pages.
#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <utility>

#include "host/formats/surface.h"
#include "host/model/overlap.h"
#include "host/studio/session.h"

namespace fascicle::studio {

namespace {

// The blocks of points that pages asked for, each computed once.
class FramePoints {
 public:
  FramePoints(Motion& motion, const ShownFrame& shown, model::OverlapMeter* meter)
      : motion_(motion), model_(*shown.model), frame_(*shown.frame), meter_(meter) {}

  // Empty if the frame has no such block.
  const std::vector<float>& of(Block block) {
    std::optional<std::vector<float>>& kept =
        made_[static_cast<std::size_t>(std::countr_zero(bit_of(block)))];
    if (!kept) kept = make(block);
    return *kept;
  }

  // The available blocks among these bits.
  std::vector<BlockPoints> held(std::uint16_t blocks) {
    std::vector<BlockPoints> list;
    for (unsigned bit = 0; bit < block_names.size(); ++bit) {
      const auto block = static_cast<Block>(1u << bit);
      if ((blocks & bit_of(block)) == 0) continue;
      if (const std::vector<float>& points = of(block); !points.empty()) list.push_back({block, points});
    }
    return list;
  }

 private:
  std::vector<float> world(std::span<const float> positions) const {
    return formats::world_positions(positions, model_.unit, frame_.origin);
  }
  std::vector<float> make(Block block) {
    switch (block) {
      case Block::surface:
        return model_.surface_count() == 0 ? std::vector<float>()
                                           : world(formats::embed(model_, frame_.positions));
      case Block::ghost:
        if (model_.surface_count() == 0 || frame_.skinned.empty()) return {};
        return world(formats::embed(model_, frame_.skinned));
      case Block::vertices:
        return world(frame_.positions);
      case Block::ghost_vertices:
        return world(frame_.skinned);
      case Block::joints:
        return motion_.joints();
      case Block::contact:
        return depths();
      case Block::solids:
        return solids();
    }
    return {};
  }
  // For each solid, its centre and the end points of its axes, 1 m long.
  std::vector<float> solids() {
    std::vector<float> points;
    for (const scene::Solid& solid : motion_.solids())
      for (int axis = -1; axis < 3; ++axis)
        for (int a = 0; a < 3; ++a)
          points.push_back(static_cast<float>(solid.center[a] + (axis < 0 ? 0.0 : solid.axes(a, axis))));
    return points;
  }
  std::vector<float> depths() const {
    if (meter_ == nullptr) return {};
    std::vector<float> points(3 * std::size_t{model_.vertex_count}, 0.0f);
    for (std::size_t i = 0; i < points.size(); i += 3) points[i] = -1.0f;
    for (const model::PointOverlap& overlap : meter_->points(frame_.positions))
      points[3 * std::size_t{model_.contact[overlap.point].vertex}] = static_cast<float>(overlap.depth);
    return points;
  }

  Motion& motion_;
  const model::Model& model_;
  const model::Frame& frame_;
  model::OverlapMeter* meter_;
  std::array<std::optional<std::vector<float>>, block_names.size()> made_;
};

}  // namespace

// On the player's thread.
void Session::show(Motion& motion, const ShownFrame& shown) {
  struct Wanted {
    std::uint16_t blocks, beside_blocks;
    auto operator<=>(const Wanted&) const = default;
  };
  std::map<PageId, Wanted> wanted;
  FrameNumbers numbers = shown.numbers;
  Server* server = nullptr;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [page, state] : pages_) wanted[page] = {state.blocks, state.beside_blocks};
    numbers.body = body_number_;
    server = server_;
    tell_applied(numbers);
  }
  if (wanted.empty() || server == nullptr) return;
  if (meter_body_ != numbers.body) meter_.reset();
  meter_body_ = numbers.body;
  const bool wants_contact = std::any_of(wanted.begin(), wanted.end(), [](const auto& one) {
    return (one.second.blocks & bit_of(Block::contact)) != 0;
  });
  if (wants_contact && !meter_ && shown.model->has_contact()) meter_.emplace(*shown.model);
  FramePoints points(motion, shown, meter_ ? &*meter_ : nullptr);
  const std::optional<ShownFrame> beside = frame_beside(motion);
  std::optional<FramePoints> points_beside;
  FrameNumbers numbers_beside;
  if (beside) {
    points_beside.emplace(beside_->motion(), *beside, nullptr);
    numbers_beside = beside->numbers;
    numbers_beside.sequence = numbers.sequence;
  }
  std::map<Wanted, SharedBytes> encoded;
  for (const auto& [page, of_page] : wanted) {
    SharedBytes& bytes = encoded[of_page];
    if (!bytes) {
      std::string whole = encode_frame(numbers, points.held(of_page.blocks));
      if (points_beside)
        whole += encode_frame(numbers_beside, points_beside->held(of_page.beside_blocks), FrameOf::beside);
      bytes = std::make_shared<const std::string>(std::move(whole));
    }
    const std::lock_guard lock(mutex_);
    if (server_ != nullptr) server_->offer(page, bytes);
  }
}

}  // namespace fascicle::studio
