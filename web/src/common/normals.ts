import type { Surface } from "./film";

// Smooth normals: triangles are weighted by area, and vertices with the same normal number share a normal.
export class Normals {
  private readonly sums: Float32Array;

  constructor(private readonly surface: Surface) {
    this.sums = new Float32Array(3 * (1 + surface.normal.reduce((most, n) => Math.max(most, n), 0)));
  }

  // `positions` and `to`: 3 per vertex.
  write(positions: Float32Array, to: Float32Array): void {
    const { triangles, normal } = this.surface;
    const { sums } = this;
    sums.fill(0);
    for (let t = 0; t < triangles.length; t += 3) {
      const a = 3 * triangles[t];
      const b = 3 * triangles[t + 1];
      const c = 3 * triangles[t + 2];
      const ux = positions[b] - positions[a];
      const uy = positions[b + 1] - positions[a + 1];
      const uz = positions[b + 2] - positions[a + 2];
      const vx = positions[c] - positions[a];
      const vy = positions[c + 1] - positions[a + 1];
      const vz = positions[c + 2] - positions[a + 2];
      const x = uy * vz - uz * vy;
      const y = uz * vx - ux * vz;
      const z = ux * vy - uy * vx;
      for (let k = 0; k < 3; ++k) {
        const n = 3 * normal[triangles[t + k]];
        sums[n] += x;
        sums[n + 1] += y;
        sums[n + 2] += z;
      }
    }
    for (let i = 0; i < normal.length; ++i) {
      const n = 3 * normal[i];
      const length = Math.hypot(sums[n], sums[n + 1], sums[n + 2]) || 1;
      to[3 * i] = sums[n] / length;
      to[3 * i + 1] = sums[n + 1] / length;
      to[3 * i + 2] = sums[n + 2] / length;
    }
  }
}
