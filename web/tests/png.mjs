// The pixels of a screenshot: PNG of 8 bits a channel, not interlaced, which is what Chromium makes.
import { inflateSync } from "node:zlib";

export function pixels_of(png) {
  const width = png.readUInt32BE(16);
  const height = png.readUInt32BE(20);
  const channels = { 2: 3, 6: 4 }[png[25]];
  if (png[24] !== 8 || !channels || png[28] !== 0) throw new Error("not a PNG of the kind that is expected");
  const parts = [];
  for (let at = 8; at < png.length; ) {
    const size = png.readUInt32BE(at);
    if (png.toString("latin1", at + 4, at + 8) === "IDAT") parts.push(png.subarray(at + 8, at + 8 + size));
    at += 12 + size;
  }
  const raw = inflateSync(Buffer.concat(parts));
  const row = width * channels;
  const values = new Uint8Array(row * height);
  for (let y = 0; y < height; ++y) {
    const filter = raw[y * (row + 1)];
    for (let x = 0; x < row; ++x) {
      const left = x >= channels ? values[y * row + x - channels] : 0;
      const up = y > 0 ? values[(y - 1) * row + x] : 0;
      const corner = x >= channels && y > 0 ? values[(y - 1) * row + x - channels] : 0;
      let guess = 0;
      if (filter === 1) guess = left;
      if (filter === 2) guess = up;
      if (filter === 3) guess = (left + up) >> 1;
      if (filter === 4) {
        const p = left + up - corner;
        const [a, b, c] = [Math.abs(p - left), Math.abs(p - up), Math.abs(p - corner)];
        guess = a <= b && a <= c ? left : b <= c ? up : corner;
      }
      values[y * row + x] = raw[y * (row + 1) + 1 + x] + guess;
    }
  }
  return {
    width,
    height,
    at: (x, y) => values.subarray(y * row + x * channels, y * row + x * channels + 3),
  };
}

// Hue in degrees, saturation and value 0 to 1.
export function hue_of([r, g, b]) {
  const most = Math.max(r, g, b);
  const range = most - Math.min(r, g, b);
  const hue =
    range === 0 ? 0 : most === r ? ((g - b) / range) % 6 : most === g ? (b - r) / range + 2 : (r - g) / range + 4;
  return { hue: (60 * hue + 360) % 360, saturation: most === 0 ? 0 : range / most, value: most / 255 };
}
