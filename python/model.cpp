// Models, and their arrays as numpy arrays.
#include <cstring>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "python/module.h"

namespace fascicle_python {
namespace {

using Path = std::filesystem::path;

std::shared_ptr<fascicle::model> build_model(const fascicle::scene& scene, const std::optional<Path>& mesher,
                                             const std::optional<Path>& cache, const py::object& progress,
                                             const py::object& log) {
  const py::object function = progress_function_of(progress);
  const fascicle::build_options options{path_text(mesher), path_text(cache), log_to(log),
                                        progress_to(function)};
  auto model = without_lock([&] { return std::make_shared<fascicle::model>(scene, options); });
  end_progress(function);
  return model;
}

py::dtype dtype_of(const fascicle_array& array) {
  switch (array.type) {
    case FASCICLE_FLOAT32:
      return py::dtype::of<float>();
    case FASCICLE_FLOAT64:
      return py::dtype::of<double>();
    case FASCICLE_UINT32:
      return py::dtype::of<std::uint32_t>();
    case FASCICLE_UINT8:
    case FASCICLE_TEXT:
      return py::dtype::of<std::uint8_t>();
    case FASCICLE_RECORDS:
      break;
  }
  return py::dtype("V" + std::to_string(array.item_bytes));
}

py::list texts_of(const fascicle_array& array) {
  py::list texts;
  const char* data = static_cast<const char*>(array.data);
  for (std::size_t at = 0; at < array.count;) {
    const std::string_view text(data + at);
    texts.append(name_object(text));
    at += text.size() + 1;
  }
  return texts;
}

py::dict arrays_of(const std::shared_ptr<fascicle::model>& model) {
  if (!model) throw py::type_error("self is None; it must be a fascicle.Model");
  const py::object self = py::cast(model);
  py::dict all;
  for (const fascicle_array& array : model->arrays()) {
    if (array.type == FASCICLE_TEXT) {
      all[array.name] = texts_of(array);
      continue;
    }
    py::array view(dtype_of(array), {static_cast<py::ssize_t>(array.count)}, {}, array.data, self);
    view.attr("setflags")(py::arg("write") = false);
    all[array.name] = view;
  }
  return all;
}

fascicle_type type_of(const py::array& array, const std::string& name) {
  const char kind = array.dtype().kind();
  const py::ssize_t size = array.itemsize();
  if (kind == 'f' && size == 4) return FASCICLE_FLOAT32;
  if (kind == 'f' && size == 8) return FASCICLE_FLOAT64;
  if (kind == 'u' && size == 4) return FASCICLE_UINT32;
  if ((kind == 'u' || kind == 'b') && size == 1) return FASCICLE_UINT8;
  if (kind == 'V') return FASCICLE_RECORDS;
  throw py::type_error("array \"" + name + "\" is of " + py::str(array.dtype()).cast<std::string>() +
                       "; a model has float32, float64, uint32, uint8 and records");
}

// The library takes texts up to a NUL. Raises TypeError, BadArgument.
std::string text_of(py::handle text, const std::string& what) {
  if (!py::isinstance<py::str>(text))
    throw py::type_error(what + " is of the type " + Py_TYPE(text.ptr())->tp_name + "; it must be a str");
  std::string bytes = name_bytes(text);
  if (bytes.find('\0') != std::string::npos)
    throw fascicle::error(FASCICLE_BAD_ARGUMENT, what + " holds a NUL character");
  return bytes;
}

// An object as an array. numpy raises ValueError or TypeError for what is none; any other exception, such as
// MemoryError, is the caller's.
py::array array_of(py::handle value, const std::string& name) {
  try {
    py::array array(py::module_::import("numpy").attr("asarray")(value, py::arg("order") = "C"));
    if (py::cast<bool>(array.dtype().attr("isnative"))) return array;
    return array.attr("astype")(array.dtype().attr("newbyteorder")("="));
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_ValueError) && !error.matches(PyExc_TypeError)) throw;
    throw py::type_error("array \"" + name + "\" is no array");
  }
}

std::shared_ptr<fascicle::model> of_arrays(const py::dict& arrays) {
  std::deque<std::string> texts;  // strings that `list` points into
  std::vector<py::array> kept;
  std::vector<fascicle_array> list;
  // A copy, because the caller's objects may change the dict when they become arrays.
  const auto unchanging = py::reinterpret_steal<py::dict>(PyDict_Copy(arrays.ptr()));
  if (!unchanging) throw py::error_already_set();
  for (const auto& [key, value] : unchanging) {
    const std::string& name = texts.emplace_back(text_of(key, "the name of an array"));
    if (py::isinstance<py::list>(value)) {
      std::string& bytes = texts.emplace_back();
      for (const py::handle text : value) bytes += text_of(text, "a text of array \"" + name + "\"") + '\0';
      list.push_back({name.c_str(), FASCICLE_TEXT, 1, bytes.size(), bytes.data()});
      continue;
    }
    const py::array array = array_of(value, name);
    list.push_back({name.c_str(), type_of(array, name), static_cast<std::size_t>(array.itemsize()),
                    static_cast<std::size_t>(array.size()), array.data()});
    kept.push_back(array);
  }
  return without_lock([&] { return std::make_shared<fascicle::model>(list); });
}

constexpr const char* model_text = R"(A body as flat arrays, shared by solvers.

Model(scene) fills the body with tetrahedra, divides it into layers, computes fibres and chooses substeps. It takes from
a second to minutes.

    mesher    the program fascicle-mesher; None: found beside the library, in its prefix or on PATH
    cache     folder for filled bodies; "": none; None: the program's default
    progress  called with ("build", 0, 0) repeatedly; returning False or raising ends the build. True: a line on stderr
    log       called with ("detail", "info" or "warning", message). The default is Python's logging under the name
              "fascicle"; None: no messages

A model is immutable, so threads may share it. Raises BadInput if the scene cannot be built, Cancelled if progress
returned False, and KeyboardInterrupt on Ctrl-C.)";

constexpr const char* arrays_text = R"(The model's arrays by name, as in host/model/model.h.

A dict of one-dimensional, read-only arrays over the model's own memory, without a copy: float32, float64,
uint32, uint8 (booleans) or records as bytes (V8, ...). Names, such as those of layers, are lists of str.
In working units.)";

constexpr const char* of_arrays_text = R"(A model from your own arrays, in the form of `arrays`.

The arrays are copied, and every size, index, range and symmetry is checked, because solvers rely on them. Omitted
arrays are empty. Such a model has no scene: step it with Solver.step_drive. Raises BadArgument or BadInput.)";

}  // namespace

void add_model(py::module_& module) {
  using namespace py::literals;
  using fascicle::model;
  const py::none none;
  const py::object to_logging = py::module_::import("fascicle._progress").attr("log_to_logging");
  py::class_<model, std::shared_ptr<model>> type(module, "Model", model_text);
  type.attr("__module__") = "fascicle";
  define_init(type, &build_model, "scene"_a, py::kw_only(), "mesher"_a = none, "cache"_a = none,
              "progress"_a = none, py::arg_v("log", to_logging, "log_to_logging"), "Builds a scene's model.");
  type.def_static("of_arrays", &of_arrays, "arrays"_a, of_arrays_text)
      .def_property_readonly("vertex_count", &model::vertex_count, "Vertices of the body.")
      .def_property_readonly("tetrahedron_count", &model::tetrahedron_count, "Tetrahedra of the body.")
      .def_property_readonly("surface_vertex_count", &model::surface_vertex_count,
                             "Vertices of the render mesh, in the file's order; 0 without one.")
      .def_property_readonly("joint_count", &model::joint_count, "Joints of a pose.")
      .def_property_readonly("substeps", &model::substeps,
                             "Substeps per frame; 0 for a model from arrays, whose drives give it.")
      .def_property_readonly("arrays", &arrays_of, arrays_text)
      .def("__repr__", [](const model& self) {
        return "<fascicle.Model, " + std::to_string(self.vertex_count()) + " vertices>";
      });
}

}  // namespace fascicle_python
