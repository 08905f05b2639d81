// The scene's solids, and where flesh touches them.
import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  Group,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  MeshStandardMaterial,
  Points,
  PointsMaterial,
  Vector3,
} from "three";
import { nice_above } from "../common/numbers";
import type { SolidMessage } from "./protocol";

const QUARTER = 10; // steps per quarter circle
const LINES = 20; // maximum number across a plane, approximately
const TOUCH = 0.0015; // fraction of the body's size: flesh this close to a solid touches it

// A solid's own space in the scene: a rotation, in columns, and a middle.
export interface Pose {
  middle: readonly number[];
  axes: readonly [readonly number[], readonly number[], readonly number[]];
}

// From the block "solids": four points each.
export function poses_of(block: Float32Array): Pose[] {
  const poses: Pose[] = [];
  for (let k = 0; k + 11 < block.length; k += 12) {
    const middle = [block[k], block[k + 1], block[k + 2]];
    const axis = (number: number) => {
      const along = [0, 1, 2].map((c) => block[k + 3 * (number + 1) + c] - middle[c]);
      const length = Math.hypot(...along) || 1; // values were rounded for transfer
      return along.map((one) => one / length);
    };
    poses.push({ middle, axes: [axis(0), axis(1), axis(2)] });
  }
  return poses;
}

// The height (m) of the highest plane that a body can land on whose lowest point is at `lowest`, below its
// middle at (x, z); `lowest` itself if there is none.
export function floor_of(solids: readonly SolidMessage[], lowest: number, x = 0, z = 0): number {
  const heights = solids
    .filter((solid) => solid.shape === "plane" && solid.up[1] > 0.7)
    .map(({ up, middle, radius }) => middle[1] + (radius - up[0] * (x - middle[0]) - up[2] * (z - middle[2])) / up[1])
    .filter((height) => height <= lowest + 1e-6);
  return heights.length > 0 ? Math.max(...heights) : lowest;
}

// Distance of a point from a solid, m; negative inside.
export function distance_to(solid: SolidMessage, pose: Pose, x: number, y: number, z: number): number {
  const from = [x - pose.middle[0], y - pose.middle[1], z - pose.middle[2]];
  const along = (axis: readonly number[]) => axis[0] * from[0] + axis[1] * from[1] + axis[2] * from[2];
  if (solid.shape === "plane") return along(pose.axes[1]) - solid.radius;
  const beyond = pose.axes.map((axis, a) => Math.abs(along(axis)) - solid.half_size[a]);
  const outside = Math.hypot(...beyond.map((one) => Math.max(one, 0)));
  return outside + Math.min(Math.max(...beyond), 0) - solid.radius;
}

// Vertices (3 numbers each) that touch a solid, except those moved by the skeleton alone.
export function touching(
  solids: readonly SolidMessage[],
  poses: readonly Pose[],
  vertices: Float32Array,
  kinematic: Uint8Array,
  gap: number,
): number[] {
  const found: number[] = [];
  for (let i = 0; i < kinematic.length; ++i) {
    if (kinematic[i]) continue;
    const near = poses.some((pose, s) => {
      const distance = distance_to(solids[s], pose, vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]);
      // Deeper flesh was inside the solid from the start, and is not pushed out.
      return Math.abs(distance) <= gap;
    });
    if (near) found.push(i);
  }
  return found;
}

// A box with rounded edges; a sphere if all half sizes are 0, a capsule if only one is not.
export function rounded_box(half: readonly number[], radius: number): { positions: Float32Array; triangles: Uint32Array } {
  const quarter = Math.PI / 2;
  const columns = 4 * (QUARTER + 1);
  const positions: number[] = [];
  const rows: [number, number][] = [];
  for (let k = 0; k <= QUARTER; ++k) rows.push([quarter * (1 - k / QUARTER), 1]);
  for (let k = 0; k <= QUARTER; ++k) rows.push([(-quarter * k) / QUARTER, -1]);
  for (const [angle, up] of rows)
    for (let c = 0; c < columns; ++c) {
      const part = Math.floor(c / (QUARTER + 1));
      const turn = quarter * (part + (c % (QUARTER + 1)) / QUARTER);
      positions.push(
        (part === 0 || part === 3 ? 1 : -1) * half[0] + radius * Math.cos(angle) * Math.cos(turn),
        up * half[1] + radius * Math.sin(angle),
        (part < 2 ? 1 : -1) * half[2] + radius * Math.cos(angle) * Math.sin(turn),
      );
    }
  const triangles: number[] = [];
  const quad = (a: number, b: number, c: number, d: number) => triangles.push(a, b, c, a, c, d);
  for (let r = 0; r + 1 < rows.length; ++r)
    for (let c = 0; c < columns; ++c) {
      const next = (c + 1) % columns;
      quad(r * columns + c, r * columns + next, (r + 1) * columns + next, (r + 1) * columns + c);
    }
  const corner = QUARTER + 1;
  const last = (rows.length - 1) * columns;
  quad(0, 3 * corner, 2 * corner, corner);
  quad(last, last + corner, last + 2 * corner, last + 3 * corner);
  return { positions: Float32Array.from(positions), triangles: Uint32Array.from(triangles) };
}

// Pairs of points along the edges of a box, or along the three great circles of a sphere or capsule.
function outline(solid: SolidMessage): Float32Array {
  const { half_size: half, radius } = solid;
  const points: number[] = [];
  for (const [a, b] of [[0, 1], [1, 2], [2, 0]]) {
    const ring: number[][] = [];
    for (let part = 0; part < 4; ++part)
      for (let k = 0; k <= QUARTER; ++k) {
        const turn = (Math.PI / 2) * (part + k / QUARTER);
        const place = [0, 0, 0];
        place[a] = (part === 0 || part === 3 ? 1 : -1) * half[a] + radius * Math.cos(turn);
        place[b] = (part < 2 ? 1 : -1) * half[b] + radius * Math.sin(turn);
        ring.push(place);
      }
    const third = 3 - a - b;
    // Two rings if the third half size is not 0, otherwise one through the middle.
    for (const sign of half[third] > 0 ? [1, -1] : [1])
      ring.forEach((place, k) => {
        for (const one of [place, ring[(k + 1) % ring.length]]) {
          const copy = [...one];
          copy[third] = sign * half[third];
          points.push(...copy);
        }
      });
  }
  return Float32Array.from(points);
}

function grid(reach: number): Float32Array {
  const cell = nice_above((2 * reach) / LINES);
  const count = Math.floor(reach / cell);
  const points: number[] = [];
  const end = count * cell;
  for (let k = -count; k <= count; ++k) points.push(k * cell, 0, -end, k * cell, 0, end, -end, 0, k * cell, end, 0, k * cell);
  return Float32Array.from(points);
}

export class Solids {
  readonly group = new Group();
  private readonly bodies: Group[] = [];
  private readonly faces = new MeshStandardMaterial({
    color: 0x9a8fd0,
    roughness: 0.9,
    transparent: true,
    opacity: 0.3,
    side: DoubleSide,
    depthWrite: false,
  });
  private readonly lines = new LineBasicMaterial({ color: 0x8f7ff0, transparent: true, opacity: 0.75 });
  // Contact points: shown for the played body only, so they are not part of the group.
  readonly spots = new Points(
    new BufferGeometry(),
    new PointsMaterial({ color: 0xff7a1a, size: 5, sizeAttenuation: false, depthTest: false, transparent: true }),
  );

  // `reach`: m, how far a plane is drawn around the body.
  constructor(
    private readonly solids: readonly SolidMessage[],
    reach: number,
  ) {
    for (const solid of solids) {
      const body = new Group();
      body.matrixAutoUpdate = false;
      const face = new BufferGeometry();
      const line = new BufferGeometry();
      if (solid.shape === "plane") {
        const r = reach;
        face.setAttribute("position", new BufferAttribute(Float32Array.from([-r, 0, -r, -r, 0, r, r, 0, r, r, 0, -r]), 3));
        face.setIndex([0, 1, 2, 0, 2, 3]);
        line.setAttribute("position", new BufferAttribute(grid(reach), 3));
      } else {
        const { positions, triangles } = rounded_box(solid.half_size, solid.radius);
        face.setAttribute("position", new BufferAttribute(positions, 3));
        face.setIndex(new BufferAttribute(triangles, 1));
        line.setAttribute("position", new BufferAttribute(outline(solid), 3));
      }
      face.computeVertexNormals();
      const mesh = new Mesh(face, this.faces);
      const edges = new LineSegments(line, this.lines);
      mesh.frustumCulled = edges.frustumCulled = false;
      mesh.renderOrder = 2;
      body.add(mesh, edges);
      this.bodies.push(body);
      this.group.add(body);
    }
    this.spots.frustumCulled = false;
    this.spots.renderOrder = 4;
  }

  // The block "solids", and the model's vertices if known; `middle`: of the body, `size`: its extent, m.
  // Returns the number of vertices that touch.
  draw(block: Float32Array, vertices: Float32Array | null, kinematic: Uint8Array, middle: Vector3, size: number): number {
    const poses = poses_of(block).slice(0, this.solids.length);
    poses.forEach(({ middle: at, axes }, s) => {
      const place = new Vector3(at[0], at[1], at[2]);
      const [x, y, z] = axes.map((axis) => new Vector3(axis[0], axis[1], axis[2]));
      if (this.solids[s].shape === "plane") {
        // The point of the plane nearest to the body.
        const height = middle.clone().sub(place).dot(y) - this.solids[s].radius;
        place.copy(middle).addScaledVector(y, -height);
      }
      this.bodies[s].matrix.copy(new Matrix4().makeBasis(x, y, z).setPosition(place));
      this.bodies[s].matrixWorldNeedsUpdate = true;
    });
    const found =
      vertices && vertices.length === 3 * kinematic.length ? touching(this.solids, poses, vertices, kinematic, TOUCH * size) : [];
    const points = new Float32Array(3 * found.length);
    found.forEach((vertex, k) => points.set(vertices!.subarray(3 * vertex, 3 * vertex + 3), 3 * k));
    this.spots.geometry.dispose();
    this.spots.geometry = new BufferGeometry();
    this.spots.geometry.setAttribute("position", new BufferAttribute(points, 3));
    this.spots.visible = found.length > 0;
    return found.length;
  }

  dispose(): void {
    for (const body of this.bodies)
      for (const part of body.children) (part as Mesh | LineSegments).geometry.dispose();
    this.spots.geometry.dispose();
    for (const material of [this.faces, this.lines, this.spots.material]) material.dispose();
  }
}
