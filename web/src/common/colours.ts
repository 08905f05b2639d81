// Colours in linear light, as in host/render/colour.cpp.

export type Colour = readonly [number, number, number];

export function linear_of_srgb(encoded: number): number {
  return encoded <= 0.04045 ? encoded / 12.92 : ((encoded + 0.055) / 1.055) ** 2.4;
}

// "#rrggbb"
export function linear_of_hex(hex: string): Colour {
  const channel = (at: number) => linear_of_srgb(parseInt(hex.slice(at, at + 2), 16) / 255);
  return [channel(1), channel(3), channel(5)];
}

// Dark violet at 0 through green to yellow at 1, with evenly rising lightness.
export const SCALE = ["#3b1054", "#3f4788", "#2d718e", "#1f9c88", "#6cc35a", "#f9e52a"];
const STOPS = SCALE.map(linear_of_hex);

// Writes the scale's colour of `value`, 0 to 1, to three entries.
export function write_scale_colour(value: number, to: Float32Array, at: number): void {
  const place = Math.min(Math.max(value, 0), 1) * (STOPS.length - 1);
  const below = Math.min(Math.floor(place), STOPS.length - 2);
  const share = place - below;
  for (let c = 0; c < 3; ++c) to[at + c] = (1 - share) * STOPS[below][c] + share * STOPS[below + 1][c];
}
