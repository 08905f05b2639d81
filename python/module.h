// The Python module `fascicle._fascicle`: declarations shared by its files. Uses only the public API.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <fascicle/fascicle.hpp>
#include <pybind11/pybind11.h>

namespace fascicle_python {

namespace py = pybind11;

struct BakeResult;
struct Device;
struct Solver;

// The classes of this module: their arguments are loaded by the casters below.
template <class T>
inline constexpr bool is_python_class = false;
template <>
inline constexpr bool is_python_class<fascicle::scene> = true;
template <>
inline constexpr bool is_python_class<fascicle::model> = true;
template <>
inline constexpr bool is_python_class<BakeResult> = true;
template <>
inline constexpr bool is_python_class<Device> = true;
template <>
inline constexpr bool is_python_class<Solver> = true;

// An object whose __init__() has not finished holds no value, and pybind11 would make one of uninitialised
// memory. Raises TypeError for such an object of the class that `type` describes.
inline void must_be_made(py::handle object, const py::detail::type_info* type) {
  if (!object || type == nullptr || PyType_IsSubtype(Py_TYPE(object.ptr()), type->type) == 0) return;
  py::detail::values_and_holders parts(reinterpret_cast<py::detail::instance*>(object.ptr()));
  auto part = parts.find(type);
  if (part != parts.end() && !part->holder_constructed())
    throw py::type_error("__init__() of this object has not finished, or has failed");
}

// A name in a scene or a model. It may hold bytes that are not UTF-8, because file names may: in a str they
// are lone surrogates, as in Python's own file names, so that the str can be given back.
struct Name {
  std::string bytes;
};
py::str name_object(std::string_view bytes);
// The inverse, for a str. Raises UnicodeEncodeError, a ValueError, for other lone surrogates.
std::string name_bytes(py::handle text);

}  // namespace fascicle_python

// Every file of the module sees these before it takes an argument.
namespace pybind11::detail {

template <class T>
class type_caster<T, std::enable_if_t<fascicle_python::is_python_class<T>>> : public type_caster_base<T> {
 public:
  bool load(handle source, bool convert) {
    // None would become a null pointer, which no function of the module takes.
    if (!source || source.is_none()) return false;
    fascicle_python::must_be_made(source, this->typeinfo);
    return type_caster_base<T>::load(source, convert);
  }
};

template <class T>
requires fascicle_python::is_python_class<T>
class type_caster<std::shared_ptr<T>> : public copyable_holder_caster<T, std::shared_ptr<T>> {
 public:
  bool load(handle source, bool convert) {
    fascicle_python::must_be_made(source, this->typeinfo);
    return copyable_holder_caster<T, std::shared_ptr<T>>::load(source, convert);
  }
};

template <>
class type_caster<fascicle_python::Name> {
 public:
  PYBIND11_TYPE_CASTER(fascicle_python::Name, const_name("str"));

  bool load(handle source, bool) {
    if (!isinstance<str>(source)) return false;
    value.bytes = fascicle_python::name_bytes(source);
    return true;
  }
  static handle cast(const fascicle_python::Name& given, return_value_policy, handle) {
    return fascicle_python::name_object(given.bytes).release();
  }
};

}  // namespace pybind11::detail

namespace fascicle_python {

// Defines __init__ as py::init(make) does. While `make` runs, a callback or another thread may call __init__
// of the same object: the first to finish makes the object, and pybind11 would overwrite it with the second.
template <class Class, class Made, class... Arguments, class... Extra>
void define_init(Class& type, Made (*make)(Arguments...), const Extra&... extra) {
  const auto init = [make](py::detail::value_and_holder& self, Arguments... arguments) {
    Made made = make(std::forward<Arguments>(arguments)...);
    if (self.holder_constructed()) throw py::type_error("__init__() ran twice at once");
    py::detail::initimpl::construct<Class>(self, std::move(made), Py_TYPE(self.inst) != self.type->type);
  };
  type.def("__init__", init, py::detail::is_new_style_constructor(), extra...);
}

void add_scene(py::module_& module);   // Scene, formats(), builtin_scenes()
void add_bake(py::module_& module);    // BakeResult, bake()
void add_device(py::module_& module);  // Device
void add_model(py::module_& module);   // Model
void add_solver(py::module_& module);  // Solver, after Device and Model

// A thread of the library that wants the interpreter lock (GIL). A daemon thread may be at work while the
// interpreter ends: it would then be ended in the middle of a C++ call, which aborts the process. From the
// interpreter's atexit() on, no thread that is at work gets the lock: callbacks cancel the work, and the call
// does not return, nor does one that starts then. Calls within a callback still do. The interpreter waits
// until the work has ended, or for 10 s; what is then still at work keeps its objects until the process ends.
class Turn {
 public:
  Turn();  // acquires the lock if it may
  ~Turn();
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  explicit operator bool() const { return has_it_; }

  static void end_at_exit(py::module_& module);

 private:
  bool has_it_ = false;
  PyGILState_STATE state_{};
};

// Gives the lock away for a call of the library, and takes it again; does not come back if the interpreter
// has begun to end, unless the call is within a callback.
class Unlocked {
 public:
  Unlocked();
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  PyThreadState* state_;
};

// The library's messages may hold bytes that are not UTF-8, because file names may: people see a mark
// instead.
py::str text_object(std::string_view text);
py::object path_object(const std::string& path);

// Runs `work` without the lock. After Ctrl-C in a terminal, the failure of a helper process may be due to it:
// raises KeyboardInterrupt instead of the error.
template <class Work>
auto without_lock(const Work& work) {
  try {
    const Unlocked unlocked;
    return work();
  } catch (const fascicle::error&) {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    throw;
  }
}

// Callbacks for the wrapper. `log` is called with (severity, message) and may be None; `progress` is called
// with (phase, done, total), may be None, and ends the work by returning False or raising. Both check for
// signals. The objects must outlive the functions, which acquire the GIL themselves.
fascicle::log_function log_to(const py::object& log);
fascicle::progress_function progress_to(const py::object& progress);
// The function for an argument `progress`, which may also be True (a bar) or False: see
// fascicle/_progress.py.
py::object progress_function_of(const py::object& progress);
// Ends the bar's line, if `function` is a bar, after work that has no frames.
void end_progress(const py::object& function);

inline std::optional<std::string> path_text(const std::optional<std::filesystem::path>& path) {
  return path ? std::optional<std::string>(path->string()) : std::nullopt;
}

// Rejects concurrent calls on handles that only one thread may use at a time. Created and destroyed with the
// GIL held, so that a plain bool is enough. Throws std::runtime_error during another call.
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
