#include "gpu/vulkan_solver.h"

#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "gpu/device_impl.h"
#include "gpu/experiments.h"
#include "gpu/frame_recorder.h"
#include "gpu/frame_slot.h"
#include "host/model/implicit.h"
#include "host/model/substep_plan.h"

namespace fascicle::gpu {
namespace {

using model::Drive;
using model::Field;
using model::Frame;
using model::Model;
using model::Probe;
using model::Read;
using model::Stage;
using model::State;

// Rejects a model that does not fit, before anything is allocated.
const Model& checked(const Device::Impl& device, const Model& model, const model::SolverOptions& options) {
  check_options(model, options);
  check_plan(plan_buffers(model), most_frames_in_flight * readback_bytes(device, model), device.info());
  return model;
}

RecorderOptions recorder_options(const Experiments& experiments) {
  return {experiments.limits, !experiments.leave_out_barriers, experiments.on_submission,
          experiments.on_dispatch};
}

class VulkanSolver : public model::Solver {
 public:
  VulkanSolver(Device& device, const Model& model, const model::SolverOptions& options,
               const Experiments& experiments)
      : device_(device.impl()),
        model_(checked(device_, model, options)),
        recorder_options_(recorder_options(experiments)),
        on_new_slot_(experiments.on_new_slot),
        kernels_(
            device_, model, options,
            experiments.leave_out_float_controls ? spirv_exact::FloatControls{} : device_.float_controls(),
            experiments.tuning.value_or(tuning_for(device_.info())), experiments.alter_module),
        buffers_(device_, model),
        pace_(device.info().software),
        keep_pace_(experiments.keep_pace),
        options_(options),
        plan_(substep_plan(model, options, false)),
        probed_plan_(substep_plan(model, options, true)) {
    // A frame that has been submitted must be kept, so this may not fail then.
    free_.reserve(most_frames_in_flight);
    pending_.reserve(most_frames_in_flight);
    VulkanSolver::load(model::rest_state(model));
    warm_up();
  }

  ~VulkanSolver() override {
    try {
      device_.wait_idle();
    } catch (const DeviceError&) {  // a lost device has nothing in flight
    }
  }
  VulkanSolver(const VulkanSolver&) = delete;
  VulkanSolver& operator=(const VulkanSolver&) = delete;

  void submit(const Drive& drive, Read what, Probe* probe) override {
    check_drive(model_, drive);
    if (pending_.size() == most_frames_in_flight) finish_oldest();
    // Cuts are applied on the host.
    while (!drive.cuts.empty() && !pending_.empty()) finish_oldest();
    if (model_.is_implicit() && (step_before_ != drive.h || tables_.h != drive.h)) take_step(drive.h);
    FrameSlot& slot = free_slot();
    what.skinned = what.skinned && model_.has_skeleton();
    slot.prepare(drive, what, model_.vertex_count, model_.surface_count());
    slot.index = frame_ + 1;
    slot.origin = drive.origin;
    FrameRecorder recorder(device_, slot, pace_, recorder_options_);
    recorder.upload_drive();
    shader::Substep substep = model::first_substep(model_, drive);
    if (drive.origin_shift != std::array<float, 3>{0, 0, 0})
      recorder.dispatch(StageKernel::rebase, swapped_, substep, model_.vertex_count);
    for (std::uint32_t s = 0; s < drive.substeps; ++s) {
      for (const model::Cut& cut : drive.cuts)
        if (cut.substep == s) {
          recorder.wait();
          set_history(model::carried(model_, save(), drive.h, cut));
        }
      record_substep(recorder, substep, drive.h, {.frame = slot.index, .substep = s}, probe);
      substep.first_bone += model_.joint_count;
      substep.first_muscle += model_.muscle_count;
      substep.first_force += model_.force_count;
      substep.first_collider += model_.collider_count;
    }
    if (what.surface || probe) {
      recorder.dispatch(StageKernel::embed, swapped_, substep, model_.surface_count());
      if (probe) {
        recorder.wait();
        probe->on_stage({slot.index, drive.substeps - 1, Stage::embed}, shown(Stage::embed));
      }
    }
    recorder.read_results(swapped_);
    recorder.finish();
    pending_.push_back(&slot);
    free_.pop_back();
    frame_ = slot.index;
    origin_ = drive.origin;
  }

  Frame collect() override {
    if (done_.empty()) {
      if (pending_.empty()) throw std::logic_error("collect: no frame was submitted");
      finish_oldest();
    }
    Frame frame = std::move(done_.front());
    done_.pop_front();
    return frame;
  }

  State save() const override {
    State state;
    state.frame = frame_;
    state.origin = origin_;
    state.positions = read_triples(shader::buffer_position);
    state.velocities = read_triples(shader::buffer_velocity);
    state.rotations = read(shader::buffer_rotation, 4 * std::size_t{model_.vertex_count});
    if (model_.has_skeleton()) state.skinned = read_triples(skinned_buffer());
    if (!model_.carried.empty()) state.skinned_velocities = read_triples(shader::buffer_skinned_velocity);
    if (step_before_ == 0.0) return state;
    state.positions_before = read_triples(shader::buffer_position_before);
    state.velocities_before = read_triples(shader::buffer_velocity_before);
    state.step_before = step_before_;
    return state;
  }

  void load(const State& state) override {
    check_state(model_, state);
    while (!pending_.empty()) finish_oldest();
    done_.clear();
    frame_ = state.frame;
    swapped_ = false;
    set_history(state);
  }

 private:
  // Requires an idle device.
  void set_history(const State& state) {
    origin_ = state.origin;
    write(shader::buffer_position, widened(state.positions));
    write(shader::buffer_velocity, widened(state.velocities));
    write(shader::buffer_rotation, state.rotations);
    if (model_.has_skeleton()) write(skinned_buffer(), widened(state.skinned));
    if (!model_.carried.empty()) write(shader::buffer_skinned_velocity, widened(state.skinned_velocities));
    step_before_ = state.step_before;
    if (!model_.is_implicit()) return;
    // Without a previous substep, the previous values are the current ones.
    const bool has_before = !state.positions_before.empty();
    write(shader::buffer_position_before, widened(has_before ? state.positions_before : state.positions));
    write(shader::buffer_velocity_before, widened(has_before ? state.velocities_before : state.velocities));
  }

  // Prepares the implicit integrator for substeps of h seconds. Earlier substeps of another length are
  // dropped as history.
  void take_step(double h) {
    while (!pending_.empty()) finish_oldest();
    if (step_before_ != h && step_before_ != 0.0) {
      State state = save();
      state.positions_before.clear();
      state.velocities_before.clear();
      state.step_before = 0.0;
      set_history(state);
    }
    if (tables_.h == h) return;
    // If the write fails, the device may have the tables of either h, so they count as those of none.
    model::ImplicitTables tables = model::implicit_tables(model_, options_, h);
    tables_ = {};
    write_buffer(device_, buffers_[shader::buffer_response], std::as_bytes(std::span(tables.responses)));
    tables_ = std::move(tables);
  }

  // Waits for the oldest frame in flight and keeps it for collect().
  void finish_oldest() {
    FrameSlot* slot = pending_.front();
    SubmissionPace pace = pace_;
    done_.push_back(slot->finish(pace));
    if (!keep_pace_) pace_ = pace;
    pending_.erase(pending_.begin());
    free_.push_back(slot);
  }

  // Drivers compile at the first dispatch, which takes tens of milliseconds per kernel. Doing it here, over
  // no items, keeps it out of the first frame and its timing.
  void warm_up() {
    const std::vector<float> decay(model_.layers.size());
    Drive drive;
    drive.decay = decay;
    FrameSlot& slot = free_slot();
    slot.prepare(drive, {}, 0, 0);
    std::vector<StageKernel> used = kernels_of(plan_);
    if (model_.surface_count() > 0) used.push_back(StageKernel::embed);
    for (const StageKernel kernel : used) {
      CommandBuffer commands(device_, slot.pool);
      commands.barrier();
      commands.dispatch(kernels_[kernel], slot.set(kernel, false), shader::Push{}, 1);
      commands.submit_and_wait();
    }
  }

  void record_substep(FrameRecorder& recorder, const shader::Substep& substep, double h, model::Where where,
                      Probe* probe) {
    shader::ImplicitStep implicit{};
    std::span<const model::Relaxation> relaxations;
    if (model_.is_implicit()) {
      implicit = model::implicit_step(model_, tables_, step_before_ == h);
      relaxations = tables_.relaxations[step_before_ == h ? 1 : 0];
    }
    if (model_.has_skeleton()) swapped_ = !swapped_;
    const auto show = [&](std::optional<Stage> stage) {
      if (!probe || !stage) return;
      recorder.wait();
      where.stage = *stage;
      probe->on_stage(where, shown(*stage));
    };
    for (const model::Block& block : probe ? probed_plan_ : plan_) {
      for (std::uint32_t k = 0; k < block.times; ++k) {
        if (block.repeat == model::Block::Repeat::iterations) {
          where.iteration = k;
          implicit.omega = relaxations[k].omega;
          implicit.gain = relaxations[k].gain;
        }
        for (const model::Step& step : block.steps) {
          recorder.dispatch(step.kernel, swapped_, substep, item_count(model_, access_of(step.kernel).items),
                            implicit);
          show(step.shown);
        }
      }
      where.iteration = 0;
      show(block.shown);
    }
    if (model_.is_implicit()) step_before_ = h;
  }

  // A stage's output in the layout of stage_width.
  std::vector<float> shown(Stage stage) const {
    std::vector<float> values;
    std::size_t width = 0;
    for (const Field field : shown_by(stage)) {
      std::vector<float> more = shown(field);
      const std::size_t floats = row_of(field).floats;
      values = width == 0 ? std::move(more) : model::side_by_side(values, width, more, floats);
      width += floats;
    }
    return values;
  }

  // A field's items, each with the number of floats of its row.
  std::vector<float> shown(Field field) const {
    const model::FieldTraits& row = row_of(field);
    const std::size_t items = item_count(model_, row.items), stored = row.bytes / sizeof(float);
    const std::vector<float> values = read(buffer_of(field), stored * items);
    std::vector<float> floats;
    floats.reserve(row.floats * items);
    if (field == Field::transform) {
      for (std::size_t r = 0; r < items; ++r) {
        for (std::size_t k = 0; k < 3; ++k)
          for (std::size_t c = 0; c < 3; ++c) floats.push_back(values[4 * (k * items + r) + c]);
        for (std::size_t k = 0; k < 3; ++k) floats.push_back(values[4 * (k * items + r) + 3]);
      }
      return floats;
    }
    for (std::size_t i = 0; i < items; ++i)
      for (std::size_t k = 0; k < row.floats; ++k) floats.push_back(values[stored * i + k]);
    return floats;
  }

  // The buffer that holds a field in this substep. The explicit predict stage writes to velocities.
  std::uint32_t buffer_of(Field field) const {
    if (field == Field::skinned) return skinned_buffer();
    if (field == Field::predicted && !model_.is_implicit()) return shader::buffer_velocity;
    return row_of(field).buffer;
  }

  std::uint32_t skinned_buffer() const {
    return swapped_ ? shader::buffer_skinned_before : shader::buffer_skinned;
  }

  std::vector<float> read(std::uint32_t number, std::size_t count) const {
    std::vector<float> values(count);
    read_buffer(device_, buffers_[number], std::as_writable_bytes(std::span(values)));
    return values;
  }
  // x y z from a buffer with one vec4 per vertex.
  std::vector<float> read_triples(std::uint32_t number) const {
    std::vector<float> triples;
    narrow(read(number, 4 * std::size_t{model_.vertex_count}), triples);
    return triples;
  }
  void write(std::uint32_t number, const std::vector<float>& values) {
    write_buffer(device_, buffers_[number], std::as_bytes(std::span(values)));
  }

  // The last of free_; it stays in free_ until its frame is in flight.
  FrameSlot& free_slot() {
    if (free_.empty()) {
      slots_.push_back(std::make_unique<FrameSlot>(device_, kernels_, buffers_));
      free_.push_back(slots_.back().get());
      if (on_new_slot_) on_new_slot_();
    }
    return *free_.back();
  }

  Device::Impl& device_;
  const Model& model_;
  RecorderOptions recorder_options_;
  std::function<void()> on_new_slot_;
  StageKernels kernels_;
  ModelBuffers buffers_;
  SubmissionPace pace_;
  bool keep_pace_;
  model::SolverOptions options_;
  model::SubstepPlan plan_, probed_plan_;
  model::ImplicitTables tables_;  // implicit: tables for the step length last used
  double step_before_ = 0.0;      // s: of the last substep; 0 if it is no history
  std::vector<std::unique_ptr<FrameSlot>> slots_;
  std::vector<FrameSlot*> free_;
  std::vector<FrameSlot*> pending_;  // oldest first, at most most_frames_in_flight
  std::deque<Frame> done_;           // finished but not yet collected; older than all pending
  bool swapped_ = false;             // which of the two skinned buffers is the current one
  std::uint64_t frame_ = 0;
  std::array<double, 3> origin_{0, 0, 0};
};

}  // namespace

std::unique_ptr<model::Solver> make_vulkan_solver(Device& device, const Model& model,
                                                  const model::SolverOptions& options) {
  return make_experimental_solver(device, model, options, {});
}

std::unique_ptr<model::Solver> make_experimental_solver(Device& device, const Model& model,
                                                        const model::SolverOptions& options,
                                                        const Experiments& experiments) {
  return std::make_unique<VulkanSolver>(device, model, options, experiments);
}

}  // namespace fascicle::gpu
