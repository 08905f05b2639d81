// The module, its exceptions and callbacks.
#include "python/module.h"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <thread>

#include <unistd.h>

namespace fascicle_python {
namespace {

const char* text_of(fascicle_severity severity) {
  switch (severity) {
    case FASCICLE_DETAIL:
      return "detail";
    case FASCICLE_INFO:
      return "info";
    case FASCICLE_WARNING:
      return "warning";
  }
  return "info";
}

const char* text_of(fascicle_phase phase) {
  switch (phase) {
    case FASCICLE_PHASE_BUILD:
      return "build";
    case FASCICLE_PHASE_LEAD_IN:
      return "lead-in";
    case FASCICLE_PHASE_FRAMES:
      return "frames";
  }
  return "frames";
}

// An object that Python has just made; raises its exception if it has not.
template <class Object>
Object made(PyObject* object) {
  if (object == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<Object>(object);
}

// fascicle.Error and its subclasses are defined in Python: see fascicle/_errors.py. pybind11 itself raises
// RuntimeError for an argument within an argument that is of another type.
void raise_error(std::exception_ptr thrown) {
  try {
    std::rethrow_exception(std::move(thrown));
  } catch (const py::cast_error& error) {
    PyErr_SetString(PyExc_TypeError, error.what());
  } catch (const fascicle::error& error) {
    const py::object raised =
        py::module_::import("fascicle._errors")
            .attr("error_of")(static_cast<int>(error.status()), text_object(error.what()));
    PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(raised.ptr())), raised.ptr());
  }
}

// What the interpreter's end waits for. After it, the process destroys what the library's threads use.
struct Ending {
  std::atomic<std::size_t> taking = 0;   // callbacks that run, and threads that take the lock back
  std::atomic<std::size_t> at_work = 0;  // calls that run without the lock
  std::atomic<bool> has_begun = false;
  std::atomic<std::thread::id> of{};  // the thread that ends the interpreter, and may always take the lock
};

Ending& ending() {
  static Ending only;
  return only;
}

// This thread's share of both.
struct Own {
  std::size_t taking = 0, at_work = 0;
};

Own& own() {
  static thread_local Own only;
  return only;
}

// For this thread.
bool is_over() {
  const Ending& end = ending();
  return end.has_begun && end.of != std::this_thread::get_id();
}

// For this thread, unless it is in a callback, for which the end waits.
bool is_over_outside() {
  return is_over() && own().taking == 0;
}

// Counts first, so that an end that begins meanwhile either waits for this thread or is seen by it.
bool begin_to_take(bool (*is_refused)()) {
  ++ending().taking;
  if (is_refused()) {
    --ending().taking;
    return false;
  }
  ++own().taking;
  return true;
}

void end_taking() {
  --own().taking;
  --ending().taking;
}

[[noreturn]] void wait_until_the_process_ends() {
  for (;;) pause();
}

// A callback may end the interpreter: the end does not wait for its own thread.
bool others_are_at_work() {
  return ending().taking != own().taking || ending().at_work != own().at_work;
}

// Ends the process with its status before it destroys what threads still use.
void leave_them_their_objects(int status, void* /*unused*/) {
  if (!others_are_at_work()) return;
  std::fflush(nullptr);
  std::_Exit(status);
}

void wait_for_those_at_work() {
  // A callback may hang, or a call not notice that it is cancelled.
  constexpr std::chrono::seconds patience(10);
  const py::gil_scoped_release released;
  ending().of = std::this_thread::get_id();
  ending().has_begun = true;
  const auto late = std::chrono::steady_clock::now() + patience;
  while (others_are_at_work() && std::chrono::steady_clock::now() < late)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  if (others_are_at_work()) on_exit(leave_them_their_objects, nullptr);
}

}  // namespace

Turn::Turn() : has_it_(begin_to_take(is_over)) {
  if (has_it_) state_ = PyGILState_Ensure();
}

Turn::~Turn() {
  if (!has_it_) return;
  PyGILState_Release(state_);
  end_taking();
}

Unlocked::Unlocked() {
  ++own().at_work;
  ++ending().at_work;
  state_ = PyEval_SaveThread();
  if (!is_over_outside()) return;
  --own().at_work;
  --ending().at_work;
  wait_until_the_process_ends();
}

Unlocked::~Unlocked() {
  --own().at_work;
  --ending().at_work;
  if (!begin_to_take(is_over_outside)) wait_until_the_process_ends();
  PyEval_RestoreThread(state_);
  end_taking();
}

void Turn::end_at_exit(py::module_& module) {
  module.attr("_end") = py::cpp_function(wait_for_those_at_work);
  // A fork has none of the other threads, nor the one that ends the interpreter.
  module.attr("_forget") = py::cpp_function([] {
    ending().has_begun = false;
    ending().taking = own().taking;
    ending().at_work = own().at_work;
  });
  py::module_::import("atexit").attr("register")(module.attr("_end"));
  py::module_::import("os").attr("register_at_fork")(py::arg("after_in_child") = module.attr("_forget"));
}

py::str text_object(std::string_view text) {
  return made<py::str>(PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "replace"));
}

py::str name_object(std::string_view bytes) {
  return made<py::str>(
      PyUnicode_DecodeUTF8(bytes.data(), static_cast<Py_ssize_t>(bytes.size()), "surrogateescape"));
}

std::string name_bytes(py::handle text) {
  return std::string(made<py::bytes>(PyUnicode_AsEncodedString(text.ptr(), "utf-8", "surrogateescape")));
}

py::object path_object(const std::string& path) {
  return made<py::object>(
      PyUnicode_DecodeFSDefaultAndSize(path.data(), static_cast<Py_ssize_t>(path.size())));
}

fascicle::log_function log_to(const py::object& log) {
  if (log.is_none()) return {};
  return [&log](fascicle_severity severity, const std::string& message) {
    const Turn turn;
    if (!turn) return;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    log(text_of(severity), text_object(message));
  };
}

fascicle::progress_function progress_to(const py::object& progress) {
  return [&progress](fascicle_phase phase, std::uint64_t done, std::uint64_t total) {
    const Turn turn;
    if (!turn) return false;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (progress.is_none()) return true;
    const py::object answer = progress(text_of(phase), done, total);
    if (answer.is_none()) return true;
    const int goes_on = PyObject_IsTrue(answer.ptr());
    if (goes_on < 0) throw py::error_already_set();
    return goes_on != 0;
  };
}

py::object progress_function_of(const py::object& progress) {
  return py::module_::import("fascicle._progress").attr("progress_function")(progress);
}

void end_progress(const py::object& function) {
  py::module_::import("fascicle._progress").attr("end_line")(function);
}

}  // namespace fascicle_python

PYBIND11_MODULE(_fascicle, module) {
  namespace py = pybind11;
  namespace fp = fascicle_python;
  module.doc() = "The compiled half of fascicle; import fascicle.";
  py::register_local_exception_translator([](std::exception_ptr thrown) {
    if (thrown) fp::raise_error(std::move(thrown));
  });
  fp::Turn::end_at_exit(module);
  fp::add_scene(module);
  fp::add_device(module);
  fp::add_bake(module);
  fp::add_model(module);
  fp::add_solver(module);
  module.attr("version") = fascicle::version();
  module.attr("solver_version") = fascicle_solver_version();
}
