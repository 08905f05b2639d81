// Overlays on a body: fibres, skeleton, inverted tetrahedra, the scene's solids, markers.
import {
  BufferAttribute,
  BufferGeometry,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  Object3D,
  SphereGeometry,
} from "three";
import type { Scene, Vector3 } from "three";
import type { BodyMessage } from "./protocol";
import { Solids } from "./solids";
import type { FrameMessage, Items } from "./wire";

class Lines {
  readonly object: LineSegments;
  private positions: BufferAttribute;

  constructor(colour: number, over: boolean, coloured = false) {
    const geometry = new BufferGeometry();
    this.positions = new BufferAttribute(new Float32Array(0), 3);
    geometry.setAttribute("position", this.positions);
    this.object = new LineSegments(
      geometry,
      new LineBasicMaterial({ color: coloured ? 0xffffff : colour, depthTest: !over, vertexColors: coloured, transparent: over }),
    );
    this.object.frustumCulled = false;
    this.object.renderOrder = over ? 3 : 0;
    this.object.visible = false;
  }

  // 6 numbers per line.
  draw(points: Float32Array, colours?: Float32Array): void {
    if (this.positions.count * 3 < points.length) {
      this.positions = new BufferAttribute(new Float32Array(points.length), 3);
      this.object.geometry.setAttribute("position", this.positions);
    }
    (this.positions.array as Float32Array).set(points);
    this.positions.needsUpdate = true;
    if (colours) this.object.geometry.setAttribute("color", new BufferAttribute(colours, 3));
    this.object.geometry.setDrawRange(0, points.length / 3);
  }
}

// Weighted by a direction's squared components, which sum to one: all directions are equally bright, and each axis
// has a pure colour.
const AXIS_COLOURS = [
  [0.68, 0.033, 0.025],
  [0.028, 0.342, 0.052],
  [0.024, 0.122, 0.694],
];

// Short lines along the fibres, carried by the flesh.
export class Fibres {
  readonly lines = new Lines(0xffffff, false, true);
  private readonly at: number[] = []; // vertices that have a fibre
  private readonly tetrahedron: number[] = [];
  private readonly weights: number[] = []; // 3 per vertex: its direction in terms of the tetrahedron's edges
  private readonly length: number;

  constructor(
    private readonly tetrahedra: Uint32Array,
    rest: Float32Array,
    fibre: Float32Array,
    drawn: Uint32Array,
  ) {
    const first = new Map<number, number>();
    for (let t = 0; t < tetrahedra.length; t += 4)
      for (let c = 0; c < 4; ++c) if (!first.has(tetrahedra[t + c])) first.set(tetrahedra[t + c], t);
    let edges = 0;
    for (const vertex of new Set(drawn)) {
      const t = first.get(vertex);
      const d = [fibre[3 * vertex], fibre[3 * vertex + 1], fibre[3 * vertex + 2]];
      if (t === undefined || Math.hypot(...d) === 0) continue;
      const edge = (k: number) =>
        [0, 1, 2].map((c) => rest[3 * tetrahedra[t + k] + c] - rest[3 * tetrahedra[t] + c]);
      const [a, b, c] = [edge(1), edge(2), edge(3)];
      const cross = (u: number[], v: number[]) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      const dot = (u: number[], v: number[]) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
      const volume = dot(a, cross(b, c));
      if (!(Math.abs(volume) > 0)) continue;
      this.at.push(vertex);
      this.tetrahedron.push(t);
      this.weights.push(dot(d, cross(b, c)) / volume, dot(d, cross(c, a)) / volume, dot(d, cross(a, b)) / volume);
      edges += Math.hypot(...a);
    }
    this.length = this.at.length > 0 ? (0.45 * edges) / this.at.length : 0;
  }

  draw(positions: Float32Array): void {
    const points = new Float32Array(6 * this.at.length);
    const colours = new Float32Array(6 * this.at.length);
    this.at.forEach((vertex, i) => {
      const t = this.tetrahedron[i];
      const direction = [0, 0, 0];
      for (let k = 0; k < 3; ++k)
        for (let c = 0; c < 3; ++c)
          direction[c] +=
            this.weights[3 * i + k] * (positions[3 * this.tetrahedra[t + k + 1] + c] - positions[3 * this.tetrahedra[t] + c]);
      const length = Math.hypot(...direction) || 1;
      for (let c = 0; c < 3; ++c) {
        const along = (this.length * direction[c]) / length;
        points[6 * i + c] = positions[3 * vertex + c] - along;
        points[6 * i + 3 + c] = positions[3 * vertex + c] + along;
        const colour = AXIS_COLOURS.reduce((sum, axis, a) => sum + (direction[a] / length) ** 2 * axis[c], 0);
        colours[6 * i + c] = colours[6 * i + 3 + c] = colour;
      }
    });
    this.lines.draw(points, colours);
  }
}

const BONE = [1, 0.64, 0.069];
const NO_BONE = [0.25, 0.27, 0.3];

// Lines from joint to joint, brighter where a bone starts.
export class Skeleton {
  readonly lines = new Lines(0xffffff, true, true);
  constructor(private readonly joints: { parent: number; is_bone?: boolean }[]) {}
  draw(places: Float32Array): void {
    const points: number[] = [];
    const colours: number[] = [];
    this.joints.forEach(({ parent }, joint) => {
      if (parent < 0) return;
      points.push(...places.subarray(3 * parent, 3 * parent + 3), ...places.subarray(3 * joint, 3 * joint + 3));
      const colour = this.joints[parent].is_bone ? BONE : NO_BONE;
      colours.push(...colour, ...colour);
    });
    this.lines.draw(Float32Array.from(points), Float32Array.from(colours));
  }
}

// The edges of flat or inverted tetrahedra.
export class Inverted {
  readonly lines = new Lines(0xff3b3b, true);
  constructor(private readonly tetrahedra: Uint32Array) {}
  draw(positions: Float32Array): void {
    const { tetrahedra } = this;
    const points: number[] = [];
    const at = (vertex: number) => positions.subarray(3 * vertex, 3 * vertex + 3);
    for (let t = 0; t < tetrahedra.length; t += 4) {
      const [o, a, b, c] = [at(tetrahedra[t]), at(tetrahedra[t + 1]), at(tetrahedra[t + 2]), at(tetrahedra[t + 3])];
      const [ax, ay, az] = [a[0] - o[0], a[1] - o[1], a[2] - o[2]];
      const [bx, by, bz] = [b[0] - o[0], b[1] - o[1], b[2] - o[2]];
      const [cx, cy, cz] = [c[0] - o[0], c[1] - o[1], c[2] - o[2]];
      const six = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
      if (six > 0) continue;
      for (const [p, q] of [[o, a], [o, b], [o, c], [a, b], [b, c], [c, a]]) points.push(...p, ...q);
    }
    this.lines.draw(Float32Array.from(points));
  }
}

// A sphere that is visible through anything in front of it.
export function marker(colour: number, opacity = 0.75): Object3D {
  const ball = new Mesh(
    new SphereGeometry(1, 24, 16),
    new MeshBasicMaterial({ color: colour, transparent: true, opacity, depthTest: false }),
  );
  ball.renderOrder = 4;
  ball.visible = false;
  return ball;
}

export interface OverlayChoice {
  fibres: boolean;
  skeleton: boolean;
  inverted: boolean;
  solids: boolean;
}

// All overlays, created on first use.
export class Overlays {
  private message: BodyMessage | null = null;
  private arrays = new Map<string, Items>();
  private fibres: Fibres | null = null;
  private skeleton: Skeleton | null = null;
  private inverted: Inverted | null = null;
  private solids: Solids | null = null;
  private middle: Vector3 | null = null;
  private size = 1;
  touches = 0; // number of vertices that touch a solid, if solids are shown
  readonly of_played = new Group(); // overlays of the played flesh, not of the comparison

  constructor(private readonly scene: Scene) {
    scene.add(this.of_played);
  }

  // `middle` and `size` (m): of the body at rest.
  set_body(message: BodyMessage, arrays: Map<string, Items>, middle: Vector3, size: number): void {
    this.message = message;
    this.arrays = arrays;
    this.middle = middle;
    this.size = size;
    for (const overlay of [this.fibres, this.skeleton, this.inverted])
      if (overlay) {
        overlay.lines.object.removeFromParent();
        overlay.lines.object.geometry.dispose();
      }
    if (this.solids) {
      this.scene.remove(this.solids.group);
      this.of_played.remove(this.solids.spots);
      this.solids.dispose();
    }
    this.fibres = this.skeleton = this.inverted = this.solids = null;
  }

  get has_solids(): boolean {
    return (this.message?.solids.length ?? 0) > 0;
  }

  // `drawn`: the model's visible vertices; null: all.
  draw(choice: OverlayChoice, frame: FrameMessage, drawn: Uint32Array | null): void {
    const { vertices, joints, solids } = frame.blocks;
    const tetrahedra = this.arrays.get("tetrahedron") as Uint32Array;
    const add = <T extends { lines: { object: Object3D } }>(overlay: T, to: Object3D = this.of_played): T => {
      to.add(overlay.lines.object);
      return overlay;
    };
    if (choice.fibres && vertices) {
      const rest = this.arrays.get("rest") as Float32Array;
      const at = drawn ?? Uint32Array.from({ length: rest.length / 3 }, (_, k) => k);
      this.fibres ??= add(new Fibres(tetrahedra, rest, this.arrays.get("fibre") as Float32Array, at));
      this.fibres.draw(vertices);
    }
    if (choice.inverted && vertices) {
      this.inverted ??= add(new Inverted(tetrahedra));
      this.inverted.draw(vertices);
    }
    if (choice.skeleton && joints) {
      this.skeleton ??= add(new Skeleton(this.message!.joints), this.scene);
      this.skeleton.draw(joints);
    }
    this.touches = 0;
    if (choice.solids && solids) {
      if (!this.solids) {
        this.solids = new Solids(this.message!.solids, 0.9 * this.size);
        this.scene.add(this.solids.group);
        this.of_played.add(this.solids.spots);
      }
      const kinematic = this.arrays.get("kinematic") as Uint8Array;
      this.touches = this.solids.draw(solids, vertices ?? null, kinematic, this.middle!, this.size);
    }
    if (this.fibres) this.fibres.lines.object.visible = choice.fibres && vertices !== undefined;
    if (this.inverted) this.inverted.lines.object.visible = choice.inverted && vertices !== undefined;
    if (this.skeleton) this.skeleton.lines.object.visible = choice.skeleton && joints !== undefined;
    if (this.solids) {
      this.solids.group.visible = choice.solids && solids !== undefined;
      this.solids.spots.visible = this.touches > 0;
    }
  }
}
