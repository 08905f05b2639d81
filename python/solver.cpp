// Levels 2 and 3: solvers.
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include <pybind11/stl.h>

#include "python/arrays.h"
#include "python/module.h"

namespace fascicle_python {

struct Solver {
  fascicle::solver solver;
  std::size_t joints = 0;
  std::size_t views = 0;  // arrays over this frame's memory that are still in use
  bool busy = false;
};

namespace {

using Handle = std::shared_ptr<Solver>;

// Runs work that moves the solver to another frame, which invalidates the current frame's memory.
template <class Work>
void move_on(Solver& self, const Work& work) {
  if (self.views > 0)
    throw py::buffer_error(
        "the solver cannot go on: " + std::to_string(self.views) +
        " arrays over its memory are in use; del them, or take copies by .copy(). An interactive "
        "session also holds the last value that it showed, in _ or Out");
  const Occupied occupied(self.busy, "the solver");
  without_lock([&] { work(self.solver); });
}

Handle make_solver(const fascicle::model& model, const std::shared_ptr<Device>& device,
                   const std::optional<std::string>& rotation, const std::optional<std::uint32_t>& iterations,
                   const std::optional<double>& viscosity) {
  const fascicle::solver_options options{rotation, iterations, viscosity};
  const auto joints = static_cast<std::size_t>(model.joint_count());
  if (!device)
    return without_lock([&] {
      return std::make_shared<Solver>(Solver{fascicle::solver(model, options), joints});
    });
  const Occupied occupied(device->busy, "the device");
  return without_lock([&] {
    return std::make_shared<Solver>(Solver{fascicle::solver(model, device->device, options), joints});
  });
}

fascicle_frame frame_of(Solver& self) {
  const Occupied occupied(self.busy, "the solver");
  return self.solver.frame();
}

// The owner of a view, which counts it until it is destroyed.
py::object counted(const Handle& self) {
  auto owner = std::make_unique<Handle>(self);
  py::capsule capsule(owner.get(), [](void* kept) {
    const std::unique_ptr<Handle> last(static_cast<Handle*>(kept));
    --(*last)->views;
  });
  ++(*owner.release())->views;
  return capsule;
}

template <const float* fascicle_frame::*points, std::size_t fascicle_frame::*count>
py::array view(const Handle& self) {
  if (!self) throw py::type_error("self is None; it must be a fascicle.Solver");
  const fascicle_frame frame = frame_of(*self);
  return points_view(frame.*points, frame.*points == nullptr ? 0 : frame.*count, counted(self));
}

template <auto copy, std::size_t fascicle_frame::*count>
py::array world(Solver& self, const std::optional<py::array>& out) {
  const std::size_t n = frame_of(self).*count;
  py::array_t<float> filled = points_to_fill(out, n);
  fascicle::check(copy(self.solver.get(), filled.mutable_data(), 3 * n));
  return filled;
}

void start_pose(Solver& self, const std::optional<Poses>& joints) {
  const std::span<const double> numbers = pose_numbers(joints, self.joints, false);
  move_on(self, [&](fascicle::solver& solver) { solver.start_pose(numbers); });
}

void step_pose(Solver& self, const std::optional<Poses>& joints, std::optional<double> time, bool jumps) {
  if (time && std::isnan(*time)) throw fascicle::error(FASCICLE_BAD_ARGUMENT, "time is NaN");
  const std::span<const double> numbers = pose_numbers(joints, self.joints, true);
  move_on(self,
          [&](fascicle::solver& solver) { solver.step_pose(numbers, time.value_or(std::nan("")), jumps); });
}

py::array clip_pose(Solver& self, std::uint64_t frame) {
  const Occupied occupied(self.busy, "the solver");
  py::array_t<double> joints(std::vector<py::ssize_t>{static_cast<py::ssize_t>(self.joints), 4, 4});
  fascicle::check(
      fascicle_solver_clip_pose(self.solver.get(), frame, joints.mutable_data(), 16 * self.joints));
  return joints;
}

using Floats = std::optional<py::array_t<float, plain_array>>;

std::pair<const float*, std::size_t> items(const Floats& array, py::ssize_t width, const char* name) {
  if (!array) return {nullptr, 0};
  const bool fits = width == 1 ? array->ndim() == 1 : array->ndim() == 2 && array->shape(1) == width;
  if (!fits)
    throw py::value_error(std::string(name) + " has the shape " + shape_text(*array) + "; it must be (n" +
                          (width == 1 ? ",)" : ", " + std::to_string(width) + ")"));
  return {array->data(), static_cast<std::size_t>(array->shape(0))};
}

void step_drive(Solver& self, double h, std::uint32_t substeps, const std::array<double, 3>& origin,
                const std::array<float, 3>& origin_shift, const std::array<float, 3>& gravity,
                const Floats& bones, const Floats& muscles, const Floats& forces, const Floats& decay,
                const Floats& colliders) {
  fascicle_drive drive = fascicle_drive_default();
  drive.substeps = substeps;
  drive.h = h;
  for (std::size_t a = 0; a < 3; ++a) {
    drive.origin[a] = origin[a];
    drive.origin_shift[a] = origin_shift[a];
    drive.gravity[a] = gravity[a];
  }
  std::tie(drive.bones, drive.bone_count) = items(bones, 16, "bones");
  std::tie(drive.muscles, drive.muscle_count) = items(muscles, 5, "muscles");
  std::tie(drive.forces, drive.force_count) = items(forces, 4, "forces");
  std::tie(drive.decay, drive.decay_count) = items(decay, 1, "decay");
  std::tie(drive.colliders, drive.collider_count) = items(colliders, 32, "colliders");
  move_on(self, [&](fascicle::solver& solver) { solver.step_drive(drive); });
}

py::bytes save_state(Solver& self) {
  const Occupied occupied(self.busy, "the solver");
  std::size_t size = 0;
  fascicle::check(fascicle_solver_save(self.solver.get(), nullptr, 0, &size));
  const auto bytes =
      py::reinterpret_steal<py::bytes>(PyBytes_FromStringAndSize(nullptr, static_cast<Py_ssize_t>(size)));
  if (!bytes) throw py::error_already_set();
  fascicle::check(fascicle_solver_save(self.solver.get(), PyBytes_AS_STRING(bytes.ptr()), size, &size));
  return bytes;
}

void load_state(Solver& self, const py::bytes& state) {
  const std::string_view bytes(state);
  move_on(self, [&](fascicle::solver& solver) { solver.load(std::as_bytes(std::span(bytes))); });
}

constexpr const char* solver_text = R"(A body in motion, at rest before frame 0.

    model       the model to move
    device      the device to run on; None opens "auto" for this solver
    rotation    "qcp" or "mueller2016"; None: the scene's
    iterations  of an implicit substep; None: as many as the scene's own substeps need (longer ones need more)
    viscosity   s, of an implicit model; None: the scene's, 0 for a model from arrays

The arrays `positions`, `velocities` and `surface` are the solver's own memory, not copies. While one of them
is in use, stepping raises BufferError. Delete them (del), or make copies.
Only one thread may use a solver at a time; a call from a second thread raises RuntimeError. The solver releases
the GIL while it works.)";

constexpr const char* start_clip_text =
    R"(Moves to frame 0 of the scene's clip, after preroll and settling, with the
same bits as a bake. `progress` is called with ("lead-in", frames done, 0) before each frame; returning False or
raising ends the work. True is a bar on stderr.)";

constexpr const char* start_pose_text = R"(Starts at rest in a pose: frame 0, at the scene's start time.

    joints  float64, (joints, 4, 4), in the order of Scene.joint_names: the affine map from the joint's own
            space to the world, in the metres of the character's file. None without a skeleton)";

constexpr const char* step_pose_text = R"(Steps a frame of 1/fps to a pose.

    joints  float64, (joints, 4, 4), as for start_pose; or (substeps, joints, 4, 4), one pose for each of
            Model.substeps. Between frames the maps are interpolated linearly: give substeps if joints rotate
            by more than about ten degrees per frame. Aligned, contiguous float64 is not copied
    time    s, at the end of the frame; forces and contractions are evaluated there. None: advances by 1/fps
    jumps   True: a teleport, which carries the flesh along without any effect on its motion)";

constexpr const char* step_drive_text =
    R"(Steps a frame with a solver's raw inputs, in working units (`unit` metres).

    h             s, length of a substep
    substeps      of the frame, 1 to 1000; the arrays below hold substeps x the model's number of items
    origin        m: the point that this frame's positions are relative to
    origin_shift  origin minus the previous frame's, working units
    gravity       working units / s^2
    bones         float32, (n, 16): a 3 x 4 map row by row, its change of gravity, 0
    muscles       float32, (n, 5): tau, swell, twist
    forces        float32, (n, 4): the vector, 0
    decay         float32, (layers,): exp(-damping h)
    colliders     float32, (n, 32): two maps, shape and friction, as in fascicle/solver.h)";

void add_views(py::class_<Solver, Handle>& type) {
  using namespace py::literals;
  type.def_property_readonly(
          "positions", &view<&fascicle_frame::positions, &fascicle_frame::vertex_count>,
          "float32, (vertices, 3), read-only, no copy: working units about `origin`. A place "
          "in the world is origin + unit * position.")
      .def_property_readonly("velocities", &view<&fascicle_frame::velocities, &fascicle_frame::vertex_count>,
                             "float32, (vertices, 3), read-only, no copy: working units / s.")
      .def_property_readonly(
          "surface", &view<&fascicle_frame::surface, &fascicle_frame::surface_vertex_count>,
          "float32, (surface vertices, 3), read-only, no copy: working units about `origin`, "
          "in the file's vertex order; (0, 3) without a surface. Its triangles are the model's array "
          "surface_triangle.")
      .def("world_positions", &world<fascicle_solver_positions, &fascicle_frame::vertex_count>,
           "out"_a = py::none(),
           "float32, (vertices, 3): metres in the world. Fills and returns `out` if it is given.")
      .def("world_surface", &world<fascicle_solver_surface, &fascicle_frame::surface_vertex_count>,
           "out"_a = py::none(),
           "float32, (surface vertices, 3): metres in the world, in the file's vertex order, without its "
           "blend "
           "shapes. Fills and returns `out` if it is given.");
}

}  // namespace

void add_solver(py::module_& module) {
  using namespace py::literals;
  const py::none none;
  const std::array<double, 3> no_origin{};
  const std::array<float, 3> zero{};
  py::class_<Solver, Handle> type(module, "Solver", solver_text);
  type.attr("__module__") = "fascicle";
  define_init(type, &make_solver, "model"_a, "device"_a = none, py::kw_only(), "rotation"_a = none,
              "iterations"_a = none, "viscosity"_a = none, "Creates a solver, at rest.");
  type.def(
          "start_clip",
          [](Solver& self, const py::object& progress) {
            const py::object function = progress_function_of(progress);
            move_on(self, [&](fascicle::solver& solver) { solver.start_clip(progress_to(function)); });
            end_progress(function);
          },
          "progress"_a = none, start_clip_text)
      .def(
          "step_clip",
          [](Solver& self) { move_on(self, [](fascicle::solver& solver) { solver.step_clip(); }); },
          "Steps to the clip's next frame; after its end, its last pose is held.")
      .def("start_pose", &start_pose, "joints"_a = none, start_pose_text)
      .def("step_pose", &step_pose, "joints"_a = none, py::kw_only(), "time"_a = none, "jumps"_a = false,
           step_pose_text)
      .def("clip_pose", &clip_pose, "frame"_a,
           "float64, (joints, 4, 4): the clip's pose at the end of a frame, to modify and pass to step_pose.")
      .def("step_drive", &step_drive, py::kw_only(), "h"_a, "substeps"_a = 1, "origin"_a = no_origin,
           "origin_shift"_a = zero, "gravity"_a = zero, "bones"_a = none, "muscles"_a = none,
           "forces"_a = none, "decay"_a = none, "colliders"_a = none, step_drive_text)
      .def_property_readonly(
          "frame", [](Solver& self) { return frame_of(self).index; }, "The number of the current frame.")
      .def_property_readonly(
          "unit", [](Solver& self) { return frame_of(self).unit; }, "Metres per working unit.")
      .def_property_readonly(
          "origin",
          [](Solver& self) {
            const fascicle_frame frame = frame_of(self);
            return py::array_t<double>(3, frame.origin);
          },
          "float64, (3,): m in the world, the point that this frame's positions are relative to. A copy.")
      .def_property_readonly(
          "position_hash",
          [](Solver& self) {
            const Occupied occupied(self.busy, "the solver");
            return self.solver.position_hash();
          },
          "16 hex digits, as the program prints it: equal hashes, equal bits.")
      .def_property_readonly(
          "device", [](Solver& self) { return text_object(self.solver.device_text()); },
          "The device that it runs on, in one line for people, with the reason if \"auto\" chose it.")
      .def("save", &save_state, "The complete state as bytes.")
      .def("load", &load_state, "state"_a,
           "Continues from saved bytes with the same bits, in a solver of the same model, on any exact "
           "device.");
  add_views(type);
}

}  // namespace fascicle_python
