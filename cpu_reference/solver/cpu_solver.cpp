#include "cpu_reference/solver/cpu_solver.h"

#include <algorithm>
#include <array>
#include <deque>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cpu_reference/solver/collide_reach.h"
#include "cpu_reference/solver/contact_search.h"
#include "cpu_reference/solver/lane_stages.h"
#include "cpu_reference/solver/slices.h"
#include "cpu_reference/solver/stages.h"
#include "cpu_reference/solver/sweeps.h"
#include "cpu_reference/solver/thread_pool.h"
#include "host/model/implicit.h"
#include "host/model/substep_plan.h"

namespace fascicle::cpu_reference {

namespace {

using model::Block;
using model::Drive;
using model::Frame;
using model::Kernel;
using model::Model;
using model::Probe;
using model::Read;
using model::Stage;
using model::State;

// A set of numbers below a count, in order of insertion.
struct Numbers {
  explicit Numbers(std::uint32_t count) : is_listed(count, 0) {}
  void add(std::uint32_t number) {
    if (is_listed[number] != 0) return;
    is_listed[number] = 1;
    list.push_back(number);
  }
  void clear() {
    for (const std::uint32_t number : list) is_listed[number] = 0;
    list.clear();
  }

  std::vector<std::uint32_t> list;
  std::vector<char> is_listed;
};

class CpuSolver : public model::Solver {
 public:
  CpuSolver(const Model& model, const model::SolverOptions& options, unsigned threads, Simd simd,
            SolverMemory* memory)
      : model_(model), options_(options) {
    check_options(model, options);
    plan_ = substep_plan(model, options, false);
    probed_plan_ = substep_plan(model, options, true);
    if (simd != Simd::scalar) lanes_ = lane_stages(simd);
    if (simd != Simd::scalar && simd != Simd::automatic && lanes_ == nullptr)
      throw std::invalid_argument(std::string("this machine has no ") + name_of(simd) + " instructions");
    size_fields(model, fields_);
    // Loads the state before making the slices, so that a State and the slices are never in memory together.
    CpuSolver::load(model::rest_state(model));
    if (lanes_ != nullptr) {
      slices_ = make_slices(model, fields_.memory);
      fill_constants(model, slices_, fields_);
    }
    if (model.has_contact())
      contacts_.emplace(
          model, (lanes_ != nullptr ? lanes_ : baseline_lane_stages())->contact,
          memory != nullptr ? memory->contact.of(model) : std::make_shared<const ContactRest>(model));
    // Last, as it adapts to the memory that is left.
    pool_.emplace(threads);
    if (lanes_ != nullptr && options.rotation == model::Rotation::qcp)
      sweeps_ = make_sweeps(model, slices_, pool_->size());
  }

  void submit(const Drive& drive, Read what, Probe* probe) override {
    check_drive(model_, drive);
    for (std::uint32_t s = 0; s < drive.substeps;) {
      for (const model::Cut& cut : drive.cuts)
        if (cut.substep == s) set_history(model::carried(model_, save(), drive.h, cut));
      // If one block is the whole substep, a sweep runs several of them.
      if (!probe && plan_.size() == 1 && is_swept(plan_.front()))
        s = sweep_substeps(drive, s);
      else
        substep(drive, s++, probe);
    }
    if (what.surface || probe) run(Kernel::embed, SubstepInput{});
    ++frame_;
    origin_ = drive.origin;
    if (probe) probe->on_stage({frame_, drive.substeps - 1, Stage::embed}, output(Stage::embed));
    Frame frame;
    frame.index = frame_;
    frame.origin = origin_;
    if (what.positions) frame.positions = positions();
    if (what.velocities) frame.velocities = vectors(fields_.velocities);
    if (what.surface) frame.surface = fields_.surface;
    if (what.skinned) frame.skinned = vectors(fields_.skinned);
    done_.push_back(std::move(frame));
  }

  Frame collect() override {
    if (done_.empty()) throw std::logic_error("collect: no frame was submitted");
    Frame frame = std::move(done_.front());
    done_.pop_front();
    return frame;
  }

  State save() const override {
    State state{.frame = frame_,
                .origin = origin_,
                .positions = positions(),
                .velocities = vectors(fields_.velocities),
                .rotations = all(std::array{rotations_of(fields_)}),
                .skinned = vectors(fields_.skinned),
                .skinned_velocities = vectors(fields_.skinned_velocities)};
    if (step_before_ == 0.0) return state;
    state.positions_before = vectors(fields_.positions_before);
    state.velocities_before = vectors(fields_.velocities_before);
    state.step_before = step_before_;
    return state;
  }

  void load(const State& state) override {
    check_state(model_, state);
    frame_ = state.frame;
    set_history(state);
    done_.clear();
  }

 private:
  // Fields of an explicit substep that only a probe reads.
  void make_fields_between_stages() {
    for (Floats* field : {&fields_.predicted, &fields_.goals}) field->resize(fields_.velocities.size());
  }

  std::vector<float> all(std::span<const Column> columns) const {
    return gathered(model_.vertex_count, columns);
  }
  // The vectors of a field; empty if it is not kept.
  std::vector<float> vectors(const Floats& field) const {
    return field.empty() ? std::vector<float>() : all(std::array{vectors_of(field)});
  }
  std::vector<float> positions() const { return all(std::array{positions_of(fields_)}); }

  void set_history(const State& state) {
    origin_ = state.origin;
    scatter(state.positions, 3, fields_.vertices, vertex_stride, 0);
    scatter(state.velocities, 3, fields_.velocities, vector_stride, 0);
    scatter(state.rotations, 4, fields_.regions, region_stride, rotation_place);
    scatter(state.skinned, 3, fields_.skinned, vector_stride, 0);
    fields_.skinned_before = fields_.skinned;
    scatter(state.skinned_velocities, 3, fields_.skinned_velocities, vector_stride, 0);
    step_before_ = state.step_before;
    if (!model_.is_implicit()) return;
    const bool has_before = !state.positions_before.empty();
    scatter(has_before ? state.positions_before : state.positions, 3, fields_.positions_before, vector_stride,
            0);
    scatter(has_before ? state.velocities_before : state.velocities, 3, fields_.velocities_before,
            vector_stride, 0);
  }

  // Without a previous substep, the previous values are the current ones.
  void forget_history() {
    scatter(positions(), 3, fields_.positions_before, vector_stride, 0);
    fields_.velocities_before = fields_.velocities;
    step_before_ = 0.0;
  }

  void run(std::uint32_t count, ModelStage stage, const SubstepInput& in) {
    pool_->run(count, [&](std::uint32_t first, std::uint32_t last) {
      stage(model_, in, fields_, {first, last});
    });
  }

  KernelCode code_in(Kernel kernel) const { return code_of(kernel, model_, options_.rotation); }

  // Runs a kernel over all its items: in lanes if this solver can, else one by one.
  void run(Kernel kernel, const SubstepInput& in) {
    const KernelCode code = code_in(kernel);
    if (lanes_ == nullptr || code.in_lanes == nullptr) {
      run(item_count(model_, access_of(kernel).items), code.one_by_one, in);
      return;
    }
    const LaneInput input = lane_input(model_, slices_, in, fields_);
    pool_->run(slices_.count, [&](std::uint32_t first, std::uint32_t last) {
      (lanes_->*code.in_lanes)(input, {first, last});
    });
  }

  bool is_swept(const Block& block) const {
    const auto is_in_lanes = [&](const model::Step& step) {
      return code_in(step.kernel).in_lanes != nullptr;
    };
    return !sweeps_.empty() && swept_steps(block) &&
           std::all_of(block.steps.begin(), block.steps.end(), is_in_lanes);
  }

  // A block's steps, as one pass of a sweep.
  Pass pass_of(const Block& block, const SubstepInput& in) {
    const model::SweptSteps steps = *swept_steps(block);
    const auto lanes = [&](Kernel kernel) { return lanes_->*code_in(kernel).in_lanes; };
    return {lane_input(model_, slices_, in, fields_), steps.skin ? lanes(*steps.skin) : nullptr,
            lanes(steps.region), lanes(steps.move)};
  }

  // At most as many passes as the sweeps have.
  void sweep(std::span<const Pass> passes) {
    pool_->run(static_cast<std::uint32_t>(sweeps_.tiles.size()),
               [&](std::uint32_t first, std::uint32_t last) {
                 for (std::uint32_t k = first; k < last; ++k) run_tile(sweeps_.tiles[k], passes);
               });
    if (sweeps_.joints.empty()) return;
    for (std::size_t p = 0; p < passes.size(); ++p) {
      const auto run_all = [&](Range Part::*which, LaneStage stage) {
        if (stage == nullptr) return;
        pool_->run(slices_of_joints(sweeps_, p, which), [&](std::uint32_t first, std::uint32_t last) {
          run_joints(sweeps_, p, which, {first, last}, stage, passes[p].in);
        });
      };
      run_all(&Part::regions, passes[p].region);
      run_all(&Part::vertices, passes[p].skin);
      run_all(&Part::vertices, passes[p].move);
    }
  }

  SubstepInput input_of(const Drive& drive, std::uint32_t s) const {
    SubstepInput in;
    in.step = model::first_substep(model_, drive);
    in.bones = drive.bones.subspan(std::size_t{s} * model_.joint_count, model_.joint_count);
    in.muscles = drive.muscles.subspan(std::size_t{s} * model_.muscle_count, model_.muscle_count);
    in.forces = drive.forces.subspan(std::size_t{s} * model_.force_count, model_.force_count);
    in.colliders = drive.colliders.subspan(std::size_t{s} * model_.collider_count, model_.collider_count);
    in.decay = drive.decay;
    in.mueller = options_.rotation == model::Rotation::mueller2016;
    return in;
  }

  // Runs explicit substeps from this one on, as many as fit in one sweep; returns the next one.
  std::uint32_t sweep_substeps(const Drive& drive, std::uint32_t first) {
    std::uint32_t end = std::min(drive.substeps, first + sweeps_.passes());
    for (const model::Cut& cut : drive.cuts)
      if (cut.substep > first) end = std::min(end, cut.substep);
    std::vector<Pass> passes;
    for (std::uint32_t s = first; s < end; ++s)
      passes.push_back(pass_of(plan_.front(), begun_substep(drive, s)));
    sweep(passes);
    return end;
  }

  // The substep's input, after making positions relative to the frame's origin and room for its skinned
  // positions.
  SubstepInput begun_substep(const Drive& drive, std::uint32_t s) {
    SubstepInput in = input_of(drive, s);
    reaches_ = reaches_of(in.colliders);
    in.reaches = reaches_;
    if (s == 0 && drive.origin_shift != std::array<float, 3>{0, 0, 0})
      pool_->run(model_.vertex_count, [&](std::uint32_t first, std::uint32_t last) {
        rebase(in, fields_, {first, last});
      });
    if (model_.has_skeleton()) std::swap(fields_.skinned, fields_.skinned_before);
    return in;
  }

  void substep(const Drive& drive, std::uint32_t s, Probe* probe) {
    SubstepInput in = begun_substep(drive, s);
    model::Where where{.frame = frame_ + 1, .substep = s};
    if (probe && !model_.is_implicit()) make_fields_between_stages();
    if (model_.is_implicit()) take_step(in, drive.h);
    const std::vector<model::Relaxation>& relaxations = tables_.relaxations[step_before_ == drive.h ? 1 : 0];
    const auto show = [&](std::optional<Stage> stage) {
      if (!probe || !stage) return;
      where.stage = *stage;
      probe->on_stage(where, output(*stage));
    };
    for (const Block& block : probe ? probed_plan_ : plan_) {
      if (block.steps.front().kernel == Kernel::contact_bound) {
        contacts_->find(fields_, *pool_);
      } else if (block.repeat == Block::Repeat::limit_passes) {
        limit_volumes(in);
      } else if (!probe && is_swept(block)) {
        sweep_block(block, in, relaxations);
      } else {
        for (std::uint32_t k = 0; k < block.times; ++k) {
          if (block.repeat == Block::Repeat::iterations) {
            where.iteration = k;
            relax_by(in, relaxations[k]);
          }
          for (const model::Step& step : block.steps) {
            if (ContactSearch::runs(step.kernel))
              contacts_->run(step.kernel, in, fields_, *pool_);
            else
              run(step.kernel, in);
            show(step.shown);
          }
        }
        where.iteration = 0;
      }
      show(block.shown);
    }
    if (model_.is_implicit()) step_before_ = drive.h;
  }

  // Sets the implicit integrator's input for a substep of h seconds.
  void take_step(SubstepInput& in, double h) {
    if (step_before_ != h) forget_history();
    if (tables_.h != h) tables_ = model::implicit_tables(model_, options_, h);
    in.implicit = model::implicit_step(model_, tables_, step_before_ == h);
    in.responses = std::span<const shader::Response>(tables_.responses)
                       .subspan(in.implicit.first_response, model_.vertex_count);
  }

  static void relax_by(SubstepInput& in, const model::Relaxation& relaxation) {
    in.implicit.gain = relaxation.gain;
    in.implicit.omega = relaxation.omega;
  }

  void sweep_block(const Block& block, SubstepInput& in, std::span<const model::Relaxation> relaxations) {
    std::vector<Pass> passes;
    for (std::uint32_t k = 0; k < block.times; ++k) {
      if (block.repeat == Block::Repeat::iterations) relax_by(in, relaxations[k]);
      passes.push_back(pass_of(block, in));
      if (passes.size() < sweeps_.passes() && k + 1 < block.times) continue;
      sweep(passes);
      passes.clear();
    }
  }

  // A stage's output in the layout of stage_width.
  std::vector<float> output(Stage stage) const {
    std::vector<Column> columns;
    for (const model::Field field : shown_by(stage))
      for (const Column& column : columns_of(fields_, field)) columns.push_back(column);
    return gathered(item_count(model_, items_of(stage)), columns);
  }

  // Runs a stage over the listed items.
  void run(const std::vector<std::uint32_t>& items, ModelStage stage, const SubstepInput& in) {
    pool_->run(static_cast<std::uint32_t>(items.size()), [&](std::uint32_t first, std::uint32_t last) {
      for (std::uint32_t k = first; k < last; ++k) stage(model_, in, fields_, {items[k], items[k] + 1});
    });
  }

  // The limits that lack volume, among those listed, or among all without a list.
  std::vector<std::uint32_t> lacking(const std::vector<std::uint32_t>* listed, const SubstepInput& in) {
    const auto count = static_cast<std::uint32_t>(listed ? listed->size() : model_.limit.size());
    if (lanes_ != nullptr) {
      LaneInput input = lane_input(model_, slices_, in, fields_);
      input.limit_count = count;
      input.listed_limit = listed ? listed->data() : nullptr;
      pool_->run(slice_count(count), [&](std::uint32_t first, std::uint32_t last) {
        lanes_->lack(input, {first, last});
      });
    } else if (listed) {
      run(*listed, &lack, in);
    } else {
      run(count, &lack, in);
    }
    std::vector<std::uint32_t> found;
    for (std::uint32_t slice = 0; slice < slice_count(count); ++slice) {
      if (lanes_ != nullptr && fields_.some_lack[slice] == 0) continue;
      for (std::uint32_t k = slice * slice_size; k < std::min(count, (slice + 1) * slice_size); ++k) {
        const std::uint32_t t = listed ? (*listed)[k] : k;
        if (fields_.lack[t] > 0.0f) found.push_back(t);
      }
    }
    // Lanes compare with the plain least volume. A tetrahedron that already lacked volume at the start lacks
    // no more than they find.
    if (lanes_ != nullptr) {
      run(found, &lack, in);
      std::erase_if(found, [&](std::uint32_t t) { return !(fields_.lack[t] > 0.0f); });
    }
    return found;
  }

  // Runs all passes of stage limit. After the first, only tetrahedra that can have changed are tested: those
  // at corners that moved. If none lacks volume, further passes would change nothing.
  void limit_volumes(const SubstepInput& in) {
    std::vector<std::uint32_t> crushed = lacking(nullptr, in);
    if (crushed.empty()) return;
    Numbers corners(model_.vertex_count), near(static_cast<std::uint32_t>(model_.limit.size()));
    for (std::uint32_t pass = 0; pass < shader::limit_passes && !crushed.empty(); ++pass) {
      corners.clear();
      fields_.terms.resize(12 * crushed.size());
      std::uint32_t place = 0;
      for (const std::uint32_t t : crushed) {
        fields_.term_place[t] = place++;
        const shader::Limit& l = model_.limit[t];
        for (const std::uint32_t i : {l.corner_a, l.corner_b, l.corner_c, l.corner_d}) corners.add(i);
      }
      run(corners.list, &crowd, in);
      run(crushed, &push, in);
      run(corners.list, &limit, in);
      near.clear();
      for (const std::uint32_t i : corners.list) {
        if (model_.is_kinematic(i)) continue;
        for (std::uint32_t e = model_.limit_offset[i]; e < model_.limit_offset[i + 1]; ++e)
          near.add(model_.limit_entry[e] / 4);
      }
      crushed = lacking(&near.list, in);
    }
  }

  const Model& model_;
  model::SolverOptions options_;
  std::optional<ThreadPool> pool_;
  model::SubstepPlan plan_, probed_plan_;
  const LaneStages* lanes_ = nullptr;  // null: items one by one
  HugePages pages_;
  Fields fields_{LineAllocator<float>(pages_)};
  Slices slices_;                          // if lanes_ is set
  Sweeps sweeps_;                          // empty: stage by stage
  std::optional<ContactSearch> contacts_;  // if the model has contact
  std::vector<ColliderReach> reaches_;     // of the substep's colliders
  model::ImplicitTables tables_;
  double step_before_ = 0.0;  // s: length of the substep that began at positions_before; 0: none
  std::uint64_t frame_ = 0;
  std::array<double, 3> origin_{0, 0, 0};
  std::deque<Frame> done_;
};

}  // namespace

std::unique_ptr<model::Solver> make_cpu_solver(const Model& model, const model::SolverOptions& options,
                                               unsigned threads, Simd simd, SolverMemory* memory) {
  return std::make_unique<CpuSolver>(model, options, threads, simd, memory);
}

}  // namespace fascicle::cpu_reference
