// Converts between numpy arrays and the library's memory without copies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include <pybind11/numpy.h>

#include "python/module.h"

namespace fascicle_python {

// A read-only n x 3 array over `data`, which `owner` keeps alive.
py::array points_view(const float* data, std::size_t count, const py::object& owner);

// The numbers of `out`, which must be a writable, aligned, contiguous float32 array of `count` x 3; None: of
// a new one. Raises ValueError that says which condition is not met.
py::array_t<float> points_to_fill(const std::optional<py::array>& out, std::size_t count);

// Arguments are converted to such arrays, which the library can read; an array that is one is not copied.
inline constexpr int plain_array =
    py::array::c_style | py::array::forcecast | py::detail::npy_api::NPY_ARRAY_ALIGNED_;
using Poses = py::array_t<double, plain_array>;
// The numbers of joints x 4 x 4 or, if `many`, also of substeps x joints x 4 x 4. None is the pose of a body
// without a skeleton. Raises ValueError.
std::span<const double> pose_numbers(const std::optional<Poses>& poses, std::size_t joint_count, bool many);

// "(3, 4, 4)"
std::string shape_text(const py::array& array);

}  // namespace fascicle_python

namespace pybind11::detail {

template <class T>
struct pyobject_caster<array_t<T, fascicle_python::plain_array>> {
  using type = array_t<T, fascicle_python::plain_array>;
  PYBIND11_TYPE_CASTER(type, handle_type_name<type>::name);

  bool load(handle source, bool) {
    auto& numpy = npy_api::get();
    constexpr int flags = npy_api::NPY_ARRAY_ENSUREARRAY_ | fascicle_python::plain_array;
    value = reinterpret_steal<type>(
        numpy.PyArray_FromAny_(source.ptr(), dtype::of<T>().release().ptr(), 0, 0, flags, nullptr));
    if (value) return true;
    // By these numpy says that it is no such array. pybind11's own caster also hides the others, MemoryError.
    if (!PyErr_ExceptionMatches(PyExc_TypeError) && !PyErr_ExceptionMatches(PyExc_ValueError))
      throw error_already_set();
    PyErr_Clear();
    return false;
  }
};

}  // namespace pybind11::detail
