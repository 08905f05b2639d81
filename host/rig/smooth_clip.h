// Linear keys that are samples of a motion, made smooth.
//
// Exporters write what an animation is 24 or 30 times a second, and say that straight lines run between:
// velocity then jumps at every key, and flesh feels each jump as a blow. Where keys follow each other within
// `longest_sample`, a cubic spline runs through them here instead, with continuous velocity and acceleration.
// Its slopes are bounded as by Huynh, "Accurate monotone cubic interpolation", SIAM J. Numer. Anal. 30
// (1993): a pose that is held stays held, a step between two poses overshoots neither, and the top of an arc
// between two samples is kept.
//
// Stretches longer than that stay straight: an artist drew them, or an exporter left out samples that lay on
// the line. Keys, and with them every pose that the file states, stay as they are.
#pragma once

#include "host/rig/character.h"

namespace fascicle::rig {

// s; a float's rounding above a tenth.
inline constexpr double longest_sample = 0.1001;

// The channel with cubics where its linear keys are samples; as it came where none are. `wraps`: what comes
// before its first key is what comes before its last one, whose values are the same but for rounding.
Channel smooth_channel(const Channel& channel, bool wraps = false);

// All channels of the clip. `repeats`: it is played again and again from `start` to `end`; channels with keys
// from the one to the other that end as they begin then wrap.
Clip smooth_clip(const Clip& clip, bool repeats, double start, double end);

// The clip with straight lines between the keys of its linear channels, the same bits whether it was made
// smooth before or not.
Clip straight_clip(const Clip& clip);

}  // namespace fascicle::rig
