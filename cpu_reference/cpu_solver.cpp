#include "cpu_reference/cpu_solver.h"

#include <deque>
#include <stdexcept>
#include <utility>

#include "cpu_reference/stages.h"
#include "cpu_reference/thread_pool.h"
#include "host/model/implicit.h"

namespace fascicle::cpu_reference {

namespace {

using model::Drive;
using model::Frame;
using model::Model;
using model::Probe;
using model::Read;
using model::Stage;
using model::State;

class CpuSolver : public model::Solver {
 public:
  CpuSolver(const Model& model, const model::SolverOptions& options, unsigned threads)
      : model_(model), options_(options), pool_(threads) {
    check_options(model, options);
    const std::size_t n = model.vertex_count;
    fields_.predicted.resize(3 * n);
    fields_.transforms.resize(12 * n);
    fields_.goals.resize(3 * n);
    if (model.has_skeleton()) fields_.gravity.resize(3 * n);
    if (model.is_implicit()) {
      fields_.begun.resize(3 * n);
      fields_.iterate_before.resize(3 * n);
    }
    fields_.surface.resize(3 * std::size_t{model.surface_count()});
    CpuSolver::load(model::rest_state(model));
  }

  void submit(const Drive& drive, Read what, Probe* probe) override {
    check_drive(model_, drive);
    for (std::uint32_t s = 0; s < drive.substeps; ++s) substep(drive, s, probe);
    if (what.surface || probe) run(model_.surface_count(), &embed, SubstepInput{});
    ++frame_;
    origin_ = drive.origin;
    if (probe) probe->on_stage({frame_, drive.substeps - 1, Stage::embed}, fields_.surface);
    Frame frame;
    frame.index = frame_;
    frame.origin = origin_;
    if (what.positions) frame.positions = fields_.positions;
    if (what.velocities) frame.velocities = fields_.velocities;
    if (what.surface) frame.surface = fields_.surface;
    if (what.skinned) frame.skinned = fields_.skinned;
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
                .positions = fields_.positions,
                .velocities = fields_.velocities,
                .rotations = fields_.rotations,
                .skinned = fields_.skinned,
                .skinned_velocities = fields_.skinned_velocities};
    if (step_before_ == 0.0) return state;
    state.positions_before = fields_.positions_before;
    state.velocities_before = fields_.velocities_before;
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
  void set_history(const State& state) {
    origin_ = state.origin;
    fields_.positions = state.positions;
    fields_.velocities = state.velocities;
    fields_.rotations = state.rotations;
    fields_.skinned = state.skinned;
    fields_.skinned_before = state.skinned;
    fields_.skinned_velocities = state.skinned_velocities;
    step_before_ = state.step_before;
    if (!model_.is_implicit()) return;
    if (state.positions_before.empty()) {
      forget_history();
    } else {
      fields_.positions_before = state.positions_before;
      fields_.velocities_before = state.velocities_before;
    }
  }

  // The next substep has none before it: what it takes for that is where the body is.
  void forget_history() {
    fields_.positions_before = fields_.positions;
    fields_.velocities_before = fields_.velocities;
    step_before_ = 0.0;
  }

  using ModelStage = void (*)(const Model&, const SubstepInput&, Fields&, Range);
  void run(std::uint32_t count, ModelStage stage, const SubstepInput& in) {
    pool_.run(count, [&](std::uint32_t first, std::uint32_t last) {
      stage(model_, in, fields_, {first, last});
    });
  }

  SubstepInput input_of(const Drive& drive, std::uint32_t s) const {
    SubstepInput in;
    in.step = model::first_substep(model_, drive);
    in.bones = drive.bones.subspan(std::size_t{s} * model_.joint_count, model_.joint_count);
    in.muscles = drive.muscles.subspan(std::size_t{s} * model_.muscle_count, model_.muscle_count);
    in.forces = drive.forces.subspan(std::size_t{s} * model_.force_count, model_.force_count);
    in.decay = drive.decay;
    in.mueller = options_.rotation == model::Rotation::mueller2016;
    return in;
  }

  void substep(const Drive& drive, std::uint32_t s, Probe* probe) {
    for (const model::Cut& cut : drive.cuts)
      if (cut.substep == s) set_history(model::carried(model_, save(), drive.h, cut));
    const SubstepInput in = input_of(drive, s);
    const std::uint32_t n = model_.vertex_count;
    const model::Where where{.frame = frame_ + 1, .substep = s};
    const auto show = [&](Stage stage, std::span<const float> values) {
      if (probe) probe->on_stage({where.frame, where.substep, stage}, values);
    };
    if (s == 0 && drive.origin_shift != std::array<float, 3>{0, 0, 0})
      pool_.run(n, [&](std::uint32_t first, std::uint32_t last) { rebase(in, fields_, {first, last}); });
    if (model_.has_skeleton()) {
      std::swap(fields_.skinned, fields_.skinned_before);
      run(n, &skin, in);
      show(Stage::skin, model::side_by_side(fields_.skinned, 3, fields_.gravity, 3));
    }
    if (model_.is_implicit()) {
      implicit_substep(in, drive.h, where, probe);
      return;
    }
    if (!probe) {
      run(n, &region, in);
      run(n, &update, in);
      return;
    }
    run(n, &predict, in);
    show(Stage::predict, fields_.predicted);
    run(n, &region, in);
    show(Stage::region, model::side_by_side(fields_.transforms, 12, fields_.rotations, 4));
    run(n, &goal, in);
    show(Stage::goal, fields_.goals);
    run(n, &integrate, in);
    show(Stage::integrate, model::side_by_side(fields_.positions, 3, fields_.velocities, 3));
  }

  // From predict on.
  void implicit_substep(SubstepInput in, double h, model::Where where, Probe* probe) {
    const std::uint32_t n = model_.vertex_count;
    const auto show = [&](Stage stage, std::span<const float> values) {
      where.stage = stage;
      if (probe) probe->on_stage(where, values);
    };
    if (step_before_ != h) forget_history();
    if (tables_.h != h) tables_ = model::implicit_tables(model_, options_, h);
    in.implicit = model::implicit_step(model_, tables_, step_before_ == h);
    const std::vector<model::Relaxation>& relaxations = tables_.relaxations[step_before_ == h ? 1 : 0];
    in.responses =
        std::span<const shader::Response>(tables_.responses).subspan(in.implicit.first_response, n);
    run(n, &predict, in);
    show(Stage::predict, fields_.predicted);
    for (where.iteration = 0; where.iteration < relaxations.size(); ++where.iteration) {
      in.implicit.gain = relaxations[where.iteration].gain;
      in.implicit.omega = relaxations[where.iteration].omega;
      run(n, &region, in);
      if (!probe) {
        run(n, &iterate, in);
        continue;
      }
      show(Stage::region, model::side_by_side(fields_.transforms, 12, fields_.rotations, 4));
      run(n, &goal, in);
      show(Stage::goal, fields_.goals);
      run(n, &relax, in);
      show(Stage::relax, fields_.positions);
    }
    where.iteration = 0;
    run(n, &integrate, in);
    show(Stage::integrate, model::side_by_side(fields_.positions, 3, fields_.velocities, 3));
    step_before_ = h;
  }

  const Model& model_;
  model::SolverOptions options_;
  ThreadPool pool_;
  Fields fields_;
  model::ImplicitTables tables_;
  double step_before_ = 0.0;  // s: of the substep that positions_before are the beginning of; 0: none
  std::uint64_t frame_ = 0;
  std::array<double, 3> origin_{0, 0, 0};
  std::deque<Frame> done_;
};

}  // namespace

std::unique_ptr<model::Solver> make_cpu_solver(const Model& model, const model::SolverOptions& options,
                                               unsigned threads) {
  return std::make_unique<CpuSolver>(model, options, threads);
}

}  // namespace fascicle::cpu_reference
