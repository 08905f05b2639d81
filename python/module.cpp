// The module, its exceptions and callbacks.
#include "python/module.h"

#include <exception>

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

// fascicle.Error and its subclasses are defined in Python: see fascicle/_errors.py.
void raise_error(std::exception_ptr thrown) {
  try {
    std::rethrow_exception(std::move(thrown));
  } catch (const fascicle::error& error) {
    const py::object raised = py::module_::import("fascicle._errors")
                                  .attr("error_of")(static_cast<int>(error.status()), error.what());
    PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(raised.ptr())), raised.ptr());
  }
}

}  // namespace

fascicle::log_function log_to(const py::object& log) {
  if (log.is_none()) return {};
  return [&log](fascicle_severity severity, const std::string& message) {
    const py::gil_scoped_acquire acquired;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    log(text_of(severity), py::reinterpret_steal<py::str>(PyUnicode_DecodeUTF8(
                               message.data(), static_cast<Py_ssize_t>(message.size()), "replace")));
  };
}

fascicle::progress_function progress_to(const py::object& progress) {
  return [&progress](fascicle_phase phase, std::uint64_t done, std::uint64_t total) {
    const py::gil_scoped_acquire acquired;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (progress.is_none()) return true;
    const py::object answer = progress(text_of(phase), done, total);
    return answer.is_none() || py::cast<bool>(answer);
  };
}

}  // namespace fascicle_python

PYBIND11_MODULE(_fascicle, module) {
  namespace py = pybind11;
  namespace fp = fascicle_python;
  module.doc() = "The compiled half of fascicle; import fascicle.";
  py::register_local_exception_translator([](std::exception_ptr thrown) {
    if (thrown) fp::raise_error(std::move(thrown));
  });
  fp::add_scene(module);
  fp::add_device(module);
  fp::add_bake(module);
  fp::add_model(module);
  fp::add_solver(module);
  module.attr("version") = fascicle::version();
  module.attr("solver_version") = fascicle_solver_version();
}
