// Smoothed linear keys that sample a motion, compared with that motion.
#include "host/rig/smooth_clip.h"

#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include "host/rig/pose_interpolation.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using rig::Channel;
using rig::ChannelPath;
using rig::Interpolation;

constexpr double rate = 24.0;  // keys per second
constexpr double pi = std::numbers::pi;

// A few dozen operations on numbers near 1, each off by 1e-16.
constexpr double spline_rounding = 1e-14;

Channel sampled(const std::function<Vector3d(double)>& place, const std::vector<double>& times) {
  Channel channel{0, ChannelPath::translation, Interpolation::linear, times, {}};
  for (const double t : times) {
    const Vector3d p = place(t);
    channel.values.insert(channel.values.end(), p.data(), p.data() + 3);
  }
  return channel;
}

std::vector<double> frames(int count) {
  std::vector<double> times;
  for (int k = 0; k <= count; ++k) times.push_back(k / rate);
  return times;
}

Vector3d wave(double t) {
  return {std::sin(3.0 * pi * t), 0.5 * std::cos(2.0 * pi * t), 0.0};
}

double largest_error(const Channel& channel, const std::function<Vector3d(double)>& place) {
  double largest = 0.0;
  for (double t = channel.times.front(); t <= channel.times.back(); t += 1e-3)
    largest = std::max(largest, (rig::sample(channel, t).head<3>() - place(t)).norm());
  return largest;
}

// The largest velocity jump at an inner key, per second.
double largest_jump(const Channel& channel) {
  constexpr double e = 1e-6;
  double largest = 0.0;
  for (std::size_t k = 1; k + 1 < channel.times.size(); ++k) {
    const double t = channel.times[k];
    const Vector4d before = (rig::sample(channel, t) - rig::sample(channel, t - e)) / e;
    const Vector4d after = (rig::sample(channel, t + e) - rig::sample(channel, t)) / e;
    largest = std::max(largest, (after - before).norm());
  }
  return largest;
}

// A wave of 1.5 Hz: straight lines are off by (omega h)^2/8 = 1.9 % of its height, cubics with the parabola's
// slope by about (omega h)^3/40, and by more at the ends, where slopes are one-sided.
TEST(SmoothClip, FollowsTheMotionThatTheKeysAreSamplesOf) {
  const Channel lines = sampled(wave, frames(24)), smooth = rig::smooth_channel(lines);
  EXPECT_LT(largest_error(smooth, wave), 5e-3);
  EXPECT_GT(largest_error(lines, wave), 1.5e-2);
  // Velocity is continuous: what remains is the acceleration, about 100 per second squared, over 1e-6 s.
  EXPECT_LT(largest_jump(smooth), 1e-3);
  EXPECT_GT(largest_jump(lines), 3.0);
}

TEST(SmoothClip, KeysStayAsTheyAre) {
  const Channel lines = sampled(wave, frames(24)), smooth = rig::smooth_channel(lines);
  for (const double t : lines.times) EXPECT_EQ(rig::sample(smooth, t), rig::sample(lines, t)) << t;
}

// Free fall, with the top of its arc between two samples, which simple limiters would cut off. One-sided
// slopes at both ends are exact for a parabola too.
TEST(SmoothClip, ReproducesAParabola) {
  const auto fall = [](double t) { return Vector3d(t, 3.0 * t - 4.905 * t * t, 1.0); };
  std::vector<double> times = frames(16);
  times.erase(times.begin() + 5);  // spacing need not be even
  EXPECT_LT(largest_error(rig::smooth_channel(sampled(fall, times)), fall), spline_rounding);
}

// A held pose, a step and a held pose: no overshoot before or after.
TEST(SmoothClip, HoldsAndStepsDoNotOvershoot) {
  const auto step = [](double t) { return Vector3d(t < 0.27 ? 0.0 : 1.0, 0.0, 0.0); };
  const Channel smooth = rig::smooth_channel(sampled(step, frames(12)));
  for (double t = 0.0; t <= 0.5; t += 1e-3) {
    const double x = rig::sample(smooth, t)[0];
    EXPECT_GE(x, 0.0) << t;
    EXPECT_LE(x, 1.0) << t;
    if (t < 6.0 / rate) {
      EXPECT_EQ(x, 0.0) << t;
    } else if (t > 7.0 / rate) {
      EXPECT_EQ(x, 1.0) << t;
    }
  }
}

// Keys more than a tenth of a second apart are taken as intended straight lines.
TEST(SmoothClip, SparseKeysKeepTheirLines) {
  const Channel sparse = sampled(wave, {0.0, 0.25, 0.5, 1.0});
  EXPECT_EQ(rig::smooth_channel(sparse).interpolation, Interpolation::linear);

  std::vector<double> times = frames(12);
  times.push_back(1.0);  // half a second later
  Channel turning{0, ChannelPath::rotation, Interpolation::linear, times, {}};
  for (const double t : times)
    turning.values.insert(turning.values.end(), {0.0, 0.0, std::sin(1.4 * t * t), std::cos(1.4 * t * t)});
  for (const Channel& mixed : {sampled(wave, times), turning}) {
    const Channel smooth = rig::smooth_channel(mixed);
    EXPECT_EQ(smooth.interpolation, Interpolation::cubic_spline);
    for (double t = 0.51; t < 1.0; t += 0.07)
      // Within spline_rounding of slerp: its keys are normalised twice.
      EXPECT_LT((rig::sample(smooth, t) - rig::sample(mixed, t)).norm(), spline_rounding) << t;
  }
}

TEST(SmoothClip, StepsAndSplinesAreLeftAlone) {
  for (const Interpolation kind : {Interpolation::step, Interpolation::cubic_spline}) {
    Channel channel = sampled(wave, frames(24));
    if (kind == Interpolation::cubic_spline) channel.values.resize(3 * channel.values.size());
    channel.interpolation = kind;
    const Channel same = rig::smooth_channel(channel);
    EXPECT_EQ(same.interpolation, kind);
    EXPECT_EQ(same.values, channel.values);
  }
}

Channel turn(const std::function<double(double)>& angle, const std::vector<double>& times) {
  Channel channel{0, ChannelPath::rotation, Interpolation::linear, times, {}};
  const Vector3d axis = Vector3d(1, 2, -2) / 3.0;
  for (const double t : times) {
    const Vector3d v = axis * std::sin(0.5 * angle(t));
    channel.values.insert(channel.values.end(), {v[0], v[1], v[2], std::cos(0.5 * angle(t))});
  }
  return channel;
}

double angle_of(const Vector4d& q) {
  return 2.0 * std::atan2(q.head<3>().dot(Vector3d(1, 2, -2) / 3.0), q[3]);
}

// A limb that swings by 90 degrees and back, 1.2 times a second: up to 16 degrees between keys.
TEST(SmoothClip, RotationsFollowTheMotionWhateverSideTheirQuaternionsLieOn) {
  const auto swing = [](double t) { return 0.5 * pi * std::sin(2.4 * pi * t); };
  const Channel lines = turn(swing, frames(24));
  Channel flipped = lines;
  for (std::size_t k = 0; k < flipped.times.size(); k += 3)
    for (std::size_t c = 0; c < 4; ++c) flipped.values[4 * k + c] *= -1.0;
  const Channel smooth = rig::smooth_channel(lines), same = rig::smooth_channel(flipped);
  double off = 0.0, off_lines = 0.0;
  for (double t = 0.0; t <= 1.0; t += 1e-3) {
    const Vector4d q = rig::sample(smooth, t);
    EXPECT_NEAR(q.norm(), 1.0, spline_rounding);
    EXPECT_LT((q * q[3] - rig::sample(same, t) * rig::sample(same, t)[3]).norm(), spline_rounding) << t;
    off = std::max(off, std::abs(angle_of(q) - swing(t)));
    off_lines = std::max(off_lines, std::abs(angle_of(rig::sample(lines, t)) - swing(t)));
  }
  EXPECT_LT(off, 0.25 * off_lines);
  EXPECT_LT(largest_jump(smooth), 1e-3);
  // Half the angular acceleration, over a key: (2.4 pi)^2 pi/4 / 24 = 1.86.
  EXPECT_GT(largest_jump(lines), 1.5);
}

// A cycle whose end equals its beginning continues smoothly; the slope at the seam is that of the wave,
// within the (omega h)^2/6 = 1.1 % of a difference over two keys.
TEST(SmoothClip, AClipThatRepeatsIsSmoothAtItsSeam) {
  const auto cycle = [](double t) { return Vector3d(std::sin(2.0 * pi * t), 0.0, 0.0); };
  rig::Clip clip{"cycle", 1.0, {sampled(cycle, frames(24))}};
  // The last key with the opposite sign, as quaternions may come.
  clip.channels.push_back(turn([](double t) { return 2.0 * pi * t; }, frames(24)));
  const auto ends = [](const Channel& channel) {
    constexpr double e = 1e-7;
    const Vector4d first = (rig::sample(channel, e) - rig::sample(channel, 0.0)) / e;
    const Vector4d last = (rig::sample(channel, 1.0) - rig::sample(channel, 1.0 - e)) / e;
    return std::pair<Vector4d, Vector4d>(first, last);
  };
  const rig::Clip once = rig::smooth_clip(clip, false, 0.0, 1.0),
                  again = rig::smooth_clip(clip, true, 0.0, 1.0);
  const auto [first, last] = ends(again.channels[0]);
  EXPECT_NEAR(first[0], last[0], 1e-4);  // differences over 1e-7 s of numbers near 1
  EXPECT_NEAR(first[0], 2.0 * pi, 0.012 * 2.0 * pi);
  const auto [turning, turned] = ends(again.channels[1]);
  EXPECT_LT((turning + turned).norm(), 1e-4);
  // The control: one-sided slopes differ from the wave's by (omega h)^2/3.
  EXPECT_GT(std::abs(ends(once.channels[0]).first[0] - 2.0 * pi), 0.015 * 2.0 * pi);
  // A clip that is not played whole has no seam.
  EXPECT_EQ(rig::smooth_clip(clip, true, 0.5, 1.0).channels[0].values, once.channels[0].values);
}

// Rotation keys of length not quite 1, with either sign.
Channel turning(const std::vector<double>& times) {
  Channel turn{1, rig::ChannelPath::rotation, Interpolation::linear, times, {}, {}};
  for (const double t : times) {
    const double sign = turn.values.size() % 8 == 0 ? 1.0 : -1.0;
    for (const double part : {0.0, std::sin(t), 0.0, std::cos(t)}) turn.values.push_back(sign * 1.001 * part);
  }
  return turn;
}

// Also for repeating clips and sparse keys: bodies are filled in such poses, whichever clip is played.
TEST(StraightClip, IsTheSameOfAClipThatWasMadeSmooth) {
  rig::Clip clip{"walk", 1.0, {sampled(wave, frames(24)), turning(frames(24)), turning({0.0, 0.5, 1.0})}};
  Channel held = turning({0.0, 0.5, 1.0});
  held.interpolation = Interpolation::step;
  clip.channels.push_back(held);
  const rig::Clip straight = rig::straight_clip(clip);
  for (const bool repeats : {false, true}) {
    const rig::Clip smooth = rig::smooth_clip(clip, repeats, 0.0, 1.0);
    ASSERT_EQ(smooth.channels[0].interpolation, Interpolation::cubic_spline);
    ASSERT_EQ(smooth.channels[1].interpolation, Interpolation::cubic_spline);
    const rig::Clip again = rig::straight_clip(smooth);
    ASSERT_EQ(again.channels.size(), straight.channels.size());
    for (std::size_t c = 0; c < straight.channels.size(); ++c) {
      EXPECT_EQ(again.channels[c].interpolation, straight.channels[c].interpolation) << c;
      EXPECT_EQ(again.channels[c].times, straight.channels[c].times) << c;
      EXPECT_EQ(again.channels[c].values, straight.channels[c].values) << c;
      EXPECT_TRUE(again.channels[c].straight.empty()) << c;
    }
  }
  // Keys authored as curves stay unchanged.
  rig::Clip drawn{"drawn", 1.0, {rig::smooth_channel(sampled(wave, frames(24)))}};
  drawn.channels[0].straight.clear();
  EXPECT_EQ(rig::straight_clip(drawn).channels[0].values, drawn.channels[0].values);
}

}  // namespace
}  // namespace fascicle::tests
