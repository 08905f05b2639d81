// The Python module `fascicle._fascicle`: what its files share. It sits on the public API alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

#include <fascicle/fascicle.hpp>
#include <pybind11/pybind11.h>

namespace fascicle_python {

namespace py = pybind11;

void add_scene(py::module_& module);   // Scene, formats(), builtin_scenes()
void add_bake(py::module_& module);    // BakeResult, bake()
void add_device(py::module_& module);  // Device
void add_model(py::module_& module);   // Model
void add_solver(py::module_& module);  // Solver, after Device and Model

// Runs `work` without the interpreter's lock. Ctrl-C in a terminal ends helper processes too: what they
// failed of is then the interrupt, and KeyboardInterrupt is raised in place of their error.
template <class Work>
auto without_lock(const Work& work) {
  try {
    const py::gil_scoped_release released;
    return work();
  } catch (const fascicle::error&) {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    throw;
  }
}

// Callbacks for the wrapper. `log` is called with (severity, message) and may be None; `progress` is called
// with (phase, done, total), may be None, and ends the work by False or by an exception. Both see signals.
// The objects must outlive the functions, which take the interpreter's lock themselves.
fascicle::log_function log_to(const py::object& log);
fascicle::progress_function progress_to(const py::object& progress);

inline std::optional<std::string> path_text(const std::optional<std::filesystem::path>& path) {
  return path ? std::optional<std::string>(path->string()) : std::nullopt;
}

// One call at a time: for handles that are used by one thread at a time. Lives and dies under the
// interpreter's lock, so that a plain bool is enough. Throws std::runtime_error where another call is in it.
class Occupied {
 public:
  Occupied(bool& busy, const char* what) : busy_(busy) {
    if (busy)
      throw std::runtime_error(std::string(what) + " is at work in another call; wait until it is done");
    busy = true;
  }
  ~Occupied() { busy_ = false; }
  Occupied(const Occupied&) = delete;
  Occupied& operator=(const Occupied&) = delete;

 private:
  bool& busy_;
};

struct Device {
  fascicle::device device;
  bool busy = false;
};

}  // namespace fascicle_python
