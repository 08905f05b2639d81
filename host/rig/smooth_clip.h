// Smooths linear keys that are samples of a motion.
//
// Exporters sample an animation 24 or 30 times a second and declare linear interpolation between the samples:
// velocity then jumps at every key, and flesh reacts to each jump as to a blow. Where keys are at most
// `longest_sample` apart, they are interpolated by a cubic spline with continuous velocity and acceleration
// instead. Its slopes are bounded as in Huynh, "Accurate monotone cubic interpolation", SIAM J. Numer. Anal.
// 30 (1993): a held pose stays held, a step between two poses does not overshoot, and the top of an arc
// between two samples is kept.
//
// Longer intervals stay straight: an artist drew them, or an exporter left out samples that lay on the line.
// Keys, and with them every pose stated in the file, are unchanged.
#pragma once

#include "host/rig/character.h"

namespace fascicle::rig {

// s; a tenth plus a float's rounding.
inline constexpr double longest_sample = 0.1001;

// The channel with cubics where its linear keys are samples; unchanged if none are. `wraps`: the motion
// before the first key is the motion before the last one, whose values are equal to the first but for
// rounding.
Channel smooth_channel(const Channel& channel, bool wraps = false);

// Smooths all channels of the clip. `repeats`: it loops from `start` to `end`; channels whose keys span that
// range and end as they begin then wrap.
Clip smooth_clip(const Clip& clip, bool repeats, double start, double end);

// The clip with straight lines between the keys of its linear channels. Gives the same bits whether or not
// the clip was smoothed before.
Clip straight_clip(const Clip& clip);

}  // namespace fascicle::rig
