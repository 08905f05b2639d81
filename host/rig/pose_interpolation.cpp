#include "host/rig/pose_interpolation.h"

#include <algorithm>
#include <cmath>

#include "host/base/trigonometry.h"

namespace fascicle::rig {
namespace {

// Written out instead of using Eigen's: the order of the sum affects the bits of the result.
double dot(const Eigen::Vector4d& a, const Eigen::Vector4d& b) {
  return ((a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]) + a[3] * b[3];
}

}  // namespace

Eigen::Matrix4d local_transform(const Vector3d& translation, const Eigen::Vector4d& rotation,
                                const Vector3d& scale) {
  const double length = std::sqrt(dot(rotation, rotation));
  const double x = rotation[0] / length, y = rotation[1] / length, z = rotation[2] / length,
               w = rotation[3] / length;
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m(0, 0) = (1.0 - 2.0 * (y * y + z * z)) * scale[0];
  m(0, 1) = (2.0 * (x * y - z * w)) * scale[1];
  m(0, 2) = (2.0 * (x * z + y * w)) * scale[2];
  m(1, 0) = (2.0 * (x * y + z * w)) * scale[0];
  m(1, 1) = (1.0 - 2.0 * (x * x + z * z)) * scale[1];
  m(1, 2) = (2.0 * (y * z - x * w)) * scale[2];
  m(2, 0) = (2.0 * (x * z - y * w)) * scale[0];
  m(2, 1) = (2.0 * (y * z + x * w)) * scale[1];
  m(2, 2) = (1.0 - 2.0 * (x * x + y * y)) * scale[2];
  m.topRightCorner<3, 1>() = translation;
  return m;
}

Eigen::Vector4d slerp(const Eigen::Vector4d& a, const Eigen::Vector4d& b, double u) {
  double cosine = dot(a, b);
  const Eigen::Vector4d end = cosine < 0.0 ? Eigen::Vector4d(-b) : b;
  cosine = std::abs(cosine);
  double share_a = 1.0 - u, share_b = u;
  // Below an angle of about 1e-7 the arc and its chord differ by less than the last bit, and sin(angle) is
  // inaccurate.
  if (cosine < 1.0 - 1e-14) {
    const double angle = base::exact_acos(cosine);
    const double sine = base::exact_sin(angle);
    share_a = base::exact_sin((1.0 - u) * angle) / sine;
    share_b = base::exact_sin(u * angle) / sine;
  }
  Eigen::Vector4d q;
  for (int c = 0; c < 4; ++c) q[c] = share_a * a[c] + share_b * end[c];
  return q / std::sqrt(dot(q, q));
}

double hermite(double a, double slope_a, double b, double slope_b, double u) {
  const double u2 = u * u, u3 = u2 * u;
  return ((2.0 * u3 - 3.0 * u2 + 1.0) * a + (u3 - 2.0 * u2 + u) * slope_a) +
         ((3.0 * u2 - 2.0 * u3) * b + (u3 - u2) * slope_b);
}

Eigen::Vector4d sample(const Channel& channel, double time) {
  const bool is_rotation = channel.path == ChannelPath::rotation;
  const bool is_spline = channel.interpolation == Interpolation::cubic_spline;
  const std::size_t width = is_rotation ? 4 : 3;
  const std::size_t stride = is_spline ? 3 * width : width;
  const auto part = [&](std::size_t key,
                        std::size_t which) {  // 0, 1, 2: in-tangent, value, out-tangent of a spline
    Eigen::Vector4d v = Eigen::Vector4d::Zero();
    for (std::size_t c = 0; c < width; ++c) {
      v[static_cast<int>(c)] = channel.values[key * stride + which * width + c];
    }
    return v;
  };
  const auto value = [&](std::size_t key) { return part(key, is_spline ? 1 : 0); };
  const auto finished = [&](const Eigen::Vector4d& v, std::size_t key) -> Eigen::Vector4d {
    if (!is_rotation) return v;
    const double square = dot(v, v);
    // A spline may pass through zero, where it has no direction: use the previous key.
    if (square > 0.0) return v / std::sqrt(square);
    const Eigen::Vector4d held = value(key);
    return held / std::sqrt(dot(held, held));
  };

  const std::vector<double>& times = channel.times;
  const std::size_t last = times.size() - 1;
  if (time <= times.front()) return finished(value(0), 0);
  if (time >= times[last]) return finished(value(last), last);
  const std::size_t next =
      static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  const std::size_t key = next - 1;
  if (channel.interpolation == Interpolation::step) return finished(value(key), key);

  const double span = times[next] - times[key];
  const double u = (time - times[key]) / span;
  const Eigen::Vector4d a = value(key), b = value(next);
  if (is_spline && (channel.straight.empty() || channel.straight[key] == 0)) {
    const Eigen::Vector4d leaving = part(key, 2), arriving = part(next, 0);
    Eigen::Vector4d v;
    for (int c = 0; c < 4; ++c) v[c] = hermite(a[c], leaving[c] * span, b[c], arriving[c] * span, u);
    return finished(v, key);
  }
  if (is_rotation) return slerp(finished(a, key), finished(b, next), u);
  return a + (b - a) * u;
}

}  // namespace fascicle::rig
