// Rotations of affine maps, in double with + - * / and sqrt only: the same bits on every machine.
#pragma once

#include <array>

namespace fascicle::model {

using Matrix3 = std::array<double, 9>;     // row by row
using Quaternion = std::array<double, 4>;  // w x y z

Matrix3 multiply(const Matrix3& a, const Matrix3& b);
Matrix3 transposed(const Matrix3& m);
std::array<double, 3> multiply(const Matrix3& m, const std::array<double, 3>& v);

// The rotation nearest to m; the identity if m mirrors or flattens, because the iteration then has no start.
Matrix3 nearest_rotation(Matrix3 m);

// Quaternion of a rotation matrix; it may be q or -q.
Quaternion quaternion_of(const Matrix3& r);

// The unit quaternion of the product a b.
Quaternion multiply(const Quaternion& a, const Quaternion& b);

}  // namespace fascicle::model
