#include "python/arrays.h"

#include <vector>

namespace fascicle_python {

std::string shape_text(const py::array& array) {
  std::string text;
  for (py::ssize_t k = 0; k < array.ndim(); ++k) text += (k > 0 ? ", " : "") + std::to_string(array.shape(k));
  return "(" + text + (array.ndim() == 1 ? ",)" : ")");
}

py::array points_view(const float* data, std::size_t count, const py::object& owner) {
  const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(count), 3};
  py::array_t<float> view(shape, data, owner);
  view.attr("setflags")(py::arg("write") = false);
  return view;
}

py::array_t<float> points_to_fill(const std::optional<py::array>& out, std::size_t count) {
  const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(count), 3};
  if (!out) return py::array_t<float>(shape);
  if (!py::isinstance<py::array_t<float, py::array::c_style>>(*out))
    throw py::value_error("out must be a contiguous array of float32");
  if ((out->flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) == 0)
    throw py::value_error("out is not aligned in memory; it must be an array as numpy.empty() makes it");
  if (out->ndim() != 2 || out->shape(0) != shape[0] || out->shape(1) != 3)
    throw py::value_error("out has the shape " + shape_text(*out) + "; it must be (" + std::to_string(count) +
                          ", 3)");
  if (!out->writeable()) throw py::value_error("out is read-only");
  return py::reinterpret_borrow<py::array_t<float>>(*out);
}

std::span<const double> pose_numbers(const std::optional<Poses>& poses, std::size_t joint_count, bool many) {
  if (!poses) {
    if (joint_count > 0)
      throw py::value_error("the body has a skeleton: joints must have the shape (" +
                            std::to_string(joint_count) + ", 4, 4)");
    return {};
  }
  const py::ssize_t n = poses->ndim(), joints = static_cast<py::ssize_t>(joint_count);
  const bool fits = (n == 3 || (many && n == 4 && poses->shape(0) > 0)) && poses->shape(n - 1) == 4 &&
                    poses->shape(n - 2) == 4 && poses->shape(n - 3) == joints;
  if (!fits)
    throw py::value_error("joints has the shape " + shape_text(*poses) + "; it must be (" +
                          std::to_string(joint_count) + ", 4, 4)" +
                          (many ? ", or one such pose for each substep" : ""));
  return {poses->data(), static_cast<std::size_t>(poses->size())};
}

}  // namespace fascicle_python
