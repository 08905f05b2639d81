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

// The numbers of `out`, which must be a writable, contiguous float32 array of `count` x 3; None: of a new
// one. Raises ValueError that says which condition is not met.
py::array_t<float> points_to_fill(const std::optional<py::array>& out, std::size_t count);

// Poses as contiguous float64; an array that already is one is not copied.
using Poses = py::array_t<double, py::array::c_style | py::array::forcecast>;
// The numbers of joints x 4 x 4 or, if `many`, also of substeps x joints x 4 x 4. None is the pose of a body
// without a skeleton. Raises ValueError.
std::span<const double> pose_numbers(const std::optional<Poses>& poses, std::size_t joint_count, bool many);

// "(3, 4, 4)"
std::string shape_text(const py::array& array);

}  // namespace fascicle_python
