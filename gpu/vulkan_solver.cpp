#include "gpu/vulkan_solver.h"

#include <deque>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "gpu/device_impl.h"
#include "gpu/frame_recorder.h"
#include "gpu/frame_slot.h"
#include "gpu/vulkan_solver_experiments.h"

namespace fascicle::gpu {
namespace {

using model::Drive;
using model::Frame;
using model::Model;
using model::Probe;
using model::Read;
using model::Stage;
using model::State;

std::vector<PlannedBuffer> checked_plan(const Model& model, const DeviceInfo& info) {
  std::vector<PlannedBuffer> plan = plan_buffers(model);
  check_plan(plan, info);
  return plan;
}

// After a DeviceError from any call the solver's state is not defined; it can be destroyed.
class VulkanSolver : public model::Solver {
 public:
  VulkanSolver(Device& device, const Model& model, const model::SolverOptions& options,
               const Experiments& experiments)
      : device_(device.impl()),
        model_(model),
        plan_(checked_plan(model, device.info())),
        with_barriers_(!experiments.leave_out_barriers),
        kernels_(device_, model, options, experiments.alter_module),
        buffers_(device_, model),
        pace_(device.info().software) {
    VulkanSolver::load(model::initial_state(model, rest_pose(model), model.rest_origin));
    warm_up();
  }

  ~VulkanSolver() override {
    try {
      device_.wait_idle();
    } catch (const DeviceError&) {  // a lost device has nothing left in flight
    }
  }
  VulkanSolver(const VulkanSolver&) = delete;
  VulkanSolver& operator=(const VulkanSolver&) = delete;

  void submit(const Drive& drive, Read what, Probe* probe) override {
    check_drive(model_, drive);
    FrameSlot& slot = free_slot();
    slot.prepare(drive, what, model_.vertex_count, model_.surface_count());
    slot.index = frame_ + 1;
    slot.origin = drive.origin;
    FrameRecorder recorder(device_, slot, pace_, with_barriers_);
    recorder.upload_drive();
    shader::Substep substep = first_substep(drive);
    if (drive.origin_shift != std::array<float, 3>{0, 0, 0})
      recorder.dispatch(StageKernel::rebase, swapped_, substep, model_.vertex_count);
    for (std::uint32_t s = 0; s < drive.substeps; ++s) {
      record_substep(recorder, substep, {slot.index, s, Stage::skin}, probe);
      substep.first_bone += model_.joint_count;
      substep.first_muscle += model_.muscle_count;
      substep.first_force += model_.force_count;
    }
    if (what.surface || probe) {
      recorder.dispatch(StageKernel::embed, swapped_, substep, model_.surface_count());
      if (probe) {
        recorder.wait();
        probe->on_stage({slot.index, drive.substeps - 1, Stage::embed},
                        read(shader::buffer_surface, 3 * std::size_t{model_.surface_count()}));
      }
    }
    recorder.read_results();
    recorder.finish();
    pending_.push_back(&slot);
    free_.pop_back();
    frame_ = slot.index;
    origin_ = drive.origin;
  }

  Frame collect() override {
    if (pending_.empty()) throw std::logic_error("collect: no frame was submitted");
    FrameSlot* slot = pending_.front();
    Frame frame = slot->finish(pace_);
    pending_.pop_front();
    free_.push_back(slot);
    return frame;
  }

  State save() const override {
    const std::size_t n = model_.vertex_count;
    State state;
    state.frame = frame_;
    state.origin = origin_;
    narrow(read(shader::buffer_position, 4 * n), state.positions);
    narrow(read(shader::buffer_velocity, 4 * n), state.velocities);
    state.rotations = read(shader::buffer_rotation, 4 * n);
    if (model_.has_skeleton()) narrow(read(skinned_buffer(), 4 * n), state.skinned);
    return state;
  }

  void load(const State& state) override {
    check_state(model_, state);
    while (!pending_.empty()) {
      pending_.front()->finish(pace_);
      free_.push_back(pending_.front());
      pending_.pop_front();
    }
    frame_ = state.frame;
    origin_ = state.origin;
    swapped_ = false;
    write(shader::buffer_position, widened(state.positions));
    write(shader::buffer_velocity, widened(state.velocities));
    write(shader::buffer_rotation, state.rotations);
    if (model_.has_skeleton()) write(skinned_buffer(), widened(state.skinned));
  }

 private:
  // Bones that leave every vertex where it is at rest.
  static std::vector<shader::Bone> rest_pose(const Model& model) {
    return std::vector<shader::Bone>(model.joint_count, shader::Bone{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  }

  // Drivers compile at the first dispatch, tens of milliseconds a kernel; it is done here, over no items, so
  // that it neither makes the first frame late nor spoils its timing.
  void warm_up() {
    const std::vector<float> decay(model_.layers.size());
    Drive drive;
    drive.decay = decay;
    FrameSlot& slot = free_slot();
    slot.prepare(drive, {}, 0, 0);
    std::vector<StageKernel> used{StageKernel::region, StageKernel::update};
    if (model_.has_skeleton()) used.push_back(StageKernel::skin);
    if (model_.surface_count() > 0) used.push_back(StageKernel::embed);
    for (const StageKernel kernel : used) {
      CommandBuffer commands(device_, slot.pool);
      commands.barrier();
      commands.dispatch(kernels_[kernel], slot.set(kernel, false), shader::Push{}, 1);
      commands.submit_and_wait();
    }
  }

  shader::Substep first_substep(const Drive& drive) const {
    shader::Substep substep{};
    substep.h = static_cast<float>(drive.h);
    substep.inverse_h = static_cast<float>(1.0 / drive.h);
    substep.gravity_x = drive.gravity[0];
    substep.gravity_y = drive.gravity[1];
    substep.gravity_z = drive.gravity[2];
    substep.shift_x = drive.origin_shift[0];
    substep.shift_y = drive.origin_shift[1];
    substep.shift_z = drive.origin_shift[2];
    substep.vertex_count = model_.vertex_count;
    substep.surface_count = model_.surface_count();
    substep.joint_count = model_.joint_count;
    return substep;
  }

  void record_substep(FrameRecorder& recorder, const shader::Substep& substep, model::Where where,
                      Probe* probe) {
    const auto run = [&](StageKernel kernel) {
      recorder.dispatch(kernel, swapped_, substep, model_.vertex_count);
    };
    if (model_.has_skeleton()) {
      swapped_ = !swapped_;
      run(StageKernel::skin);
    }
    if (!probe) {
      run(StageKernel::region);
      run(StageKernel::update);
      return;
    }
    const auto show = [&](Stage stage) {
      recorder.wait();
      where.stage = stage;
      probe->on_stage(where, shown(stage));
    };
    if (model_.has_skeleton()) show(Stage::skin);
    run(StageKernel::predict);
    show(Stage::predict);
    run(StageKernel::region);
    show(Stage::region);
    run(StageKernel::goal);
    show(Stage::goal);
    run(StageKernel::integrate);
    show(Stage::integrate);
  }

  // A stage's output in the layout of stage_width.
  std::vector<float> shown(Stage stage) const {
    const std::size_t n = model_.vertex_count;
    std::vector<float> values;
    if (stage == Stage::region) {
      const std::vector<float> transforms = read(shader::buffer_transform, 12 * n);
      const std::vector<float> rotations = read(shader::buffer_rotation, 4 * n);
      values.reserve(16 * n);
      for (std::size_t r = 0; r < n; ++r) {
        for (const std::size_t k : {0u, 1u, 2u, 4u, 5u, 6u, 8u, 9u, 10u, 3u, 7u, 11u})
          values.push_back(transforms[12 * r + k]);
        for (std::size_t k = 0; k < 4; ++k) values.push_back(rotations[4 * r + k]);
      }
    } else if (stage == Stage::integrate) {
      const std::vector<float> positions = read(shader::buffer_position, 4 * n);
      const std::vector<float> velocities = read(shader::buffer_velocity, 4 * n);
      values.reserve(6 * n);
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < 3; ++k) values.push_back(positions[4 * i + k]);
        for (std::size_t k = 0; k < 3; ++k) values.push_back(velocities[4 * i + k]);
      }
    } else {
      narrow(read(stage == Stage::skin      ? skinned_buffer()
                  : stage == Stage::predict ? shader::buffer_velocity
                                            : shader::buffer_goal,
                  4 * n),
             values);
    }
    return values;
  }

  std::uint32_t skinned_buffer() const {
    return swapped_ ? shader::buffer_skinned_before : shader::buffer_skinned;
  }

  std::vector<float> read(std::uint32_t number, std::size_t count) const {
    std::vector<float> values(count);
    read_buffer(device_, buffers_[number], std::as_writable_bytes(std::span(values)));
    return values;
  }
  void write(std::uint32_t number, const std::vector<float>& values) {
    write_buffer(device_, buffers_[number], std::as_bytes(std::span(values)));
  }

  // The last of free_; it stays there until its frame is under way.
  FrameSlot& free_slot() {
    if (free_.empty()) {
      slots_.push_back(std::make_unique<FrameSlot>(device_, kernels_, buffers_));
      free_.push_back(slots_.back().get());
    }
    return *free_.back();
  }

  Device::Impl& device_;
  const Model& model_;
  std::vector<PlannedBuffer> plan_;  // made first: refuses before anything is allocated
  bool with_barriers_;
  StageKernels kernels_;
  ModelBuffers buffers_;
  SubmissionPace pace_;
  std::vector<std::unique_ptr<FrameSlot>> slots_;
  std::vector<FrameSlot*> free_;
  std::deque<FrameSlot*> pending_;
  bool swapped_ = false;  // which of the two skinned buffers is the current one
  std::uint64_t frame_ = 0;
  std::array<double, 3> origin_{0, 0, 0};
};

}  // namespace

std::unique_ptr<model::Solver> make_vulkan_solver(Device& device, const Model& model,
                                                  const model::SolverOptions& options) {
  return make_vulkan_solver(device, model, options, Experiments{});
}

std::unique_ptr<model::Solver> make_vulkan_solver(Device& device, const Model& model,
                                                  const model::SolverOptions& options,
                                                  const Experiments& experiments) {
  return std::make_unique<VulkanSolver>(device, model, options, experiments);
}

}  // namespace fascicle::gpu
