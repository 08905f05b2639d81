// A bake as stored in a page: docs/formats.md, "The page of fascicle view".
import { lower_neighbours, MotionDecoder } from "./motion";
import { NumberDecoder, RangeDecoder } from "./range_decoder";

export interface Curve {
  name: string;
  unit: string;
  limit: number | null;
  values: (number | null)[];
}

export interface Material {
  name: string;
  colour: [number, number, number];
  cutoff: number;
  texture: number;
}

export interface PageTexture {
  type: string;
  across: "repeat" | "mirror" | "clamp";
  down: "repeat" | "mirror" | "clamp";
  base64: string;
}

export interface Layer {
  name: string;
  colour: string;
}

export interface Description {
  version: number;
  program: string;
  scene: string;
  device: string;
  fps: number;
  start: number;
  frames: number;
  first_number: number;
  surface: "render mesh" | "tetrahedra";
  bake_vertices: number;
  tetrahedra: number;
  error: number;
  origin: [number, number, number];
  step: number;
  places: number;
  surroundings: number[]; // places on floors and walls, which the camera does not fit
  vertices: number;
  triangles: number;
  ghost: "skinning" | "rest shape";
  ghost_frames: number;
  has_uvs: boolean;
  has_colours: boolean;
  painted: boolean;
  groups: { material: number; triangles: number }[];
  materials: Material[];
  textures: PageTexture[];
  layers: Layer[];
  curves: Curve[];
  warnings: string[];
  motion: string;
}

export function bytes_of_base64(text: string): Uint8Array<ArrayBuffer> {
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let k = 0; k < characters.length; ++k) bytes[k] = characters.charCodeAt(k);
  return bytes;
}

// Vertices for the graphics card. Vertices with the same place move together; those with the same normal are
// lit alike.
export interface Surface {
  places: number;
  triangles: Uint32Array;
  place: Uint32Array;
  normal: Uint32Array;
  layer: Uint32Array;
  source: Uint32Array; // the vertex's number in the bake
  uvs: Float32Array | null;
  colours: Uint8Array | null; // sRGB
}

const UV_STEP = 1 / 16384;

// A bake's frames; decode_next decodes one after the other.
export class Film {
  readonly surface: Surface;
  readonly flesh: Int32Array[] = []; // cells, 3 per place
  private readonly ghost: Int32Array[] = [];
  private readonly from: RangeDecoder;
  private readonly flesh_motion: MotionDecoder;
  private readonly ghost_motion: MotionDecoder;

  constructor(readonly description: Description) {
    if (description.version !== 1) throw new Error(`the page's data has version ${description.version}, not 1`);
    this.from = new RangeDecoder(bytes_of_base64(description.motion));
    const numbers = new NumberDecoder(16);
    let context = 0;
    const list = <T extends Uint32Array | Int32Array | Uint8Array>(values: T, width: number): T => {
      for (let k = 0; k < values.length; ++k)
        values[k] = numbers.take(this.from, context) + (k < width ? 0 : values[k - width]);
      ++context;
      return values;
    };
    const { vertices, places } = description;
    const triangles = list(new Uint32Array(3 * description.triangles), 1);
    const place = list(new Uint32Array(vertices), 1);
    const normal = list(new Uint32Array(vertices), 1);
    const layer = list(new Uint32Array(vertices), 1);
    const source = list(new Uint32Array(vertices), 1);
    const uvs = description.has_uvs
      ? Float32Array.from(list(new Int32Array(2 * vertices), 2), (value) => value * UV_STEP)
      : null;
    const colours = description.has_colours ? list(new Uint8Array(3 * vertices), 3) : null;
    this.surface = { places, triangles, place, normal, layer, source, uvs, colours };
    const neighbours = lower_neighbours(
      places,
      triangles.map((vertex) => place[vertex]),
    );
    this.flesh_motion = new MotionDecoder(neighbours, places);
    this.ghost_motion = new MotionDecoder(neighbours, places);
  }

  get frames(): number {
    return this.description.frames;
  }

  // False once all frames are decoded.
  decode_next(): boolean {
    const k = this.flesh.length;
    if (k >= this.frames) return false;
    if (k < this.description.ghost_frames) this.ghost.push(this.ghost_motion.take(this.from, null));
    this.flesh.push(this.flesh_motion.take(this.from, this.ghost_of(k)));
    return true;
  }

  // Skinning alone, or the rest shape.
  ghost_of(frame: number): Int32Array {
    return this.ghost[Math.min(frame, this.ghost.length - 1)];
  }

  // The distance of the flesh from the ghost at each place, m.
  lag(frame: number, to: Float32Array): Float32Array {
    const flesh = this.flesh[frame];
    const ghost = this.ghost_of(frame);
    for (let p = 0; p < to.length; ++p) {
      const x = flesh[3 * p] - ghost[3 * p];
      const y = flesh[3 * p + 1] - ghost[3 * p + 1];
      const z = flesh[3 * p + 2] - ghost[3 * p + 2];
      to[p] = this.description.step * Math.sqrt(x * x + y * y + z * z);
    }
    return to;
  }

  // m from `centre`, 3 per place.
  places(cells: Int32Array, centre: readonly number[], to: Float32Array): Float32Array {
    const { origin, step } = this.description;
    for (let axis = 0; axis < 3; ++axis) {
      const from = origin[axis] - centre[axis];
      for (let k = axis; k < to.length; k += 3) to[k] = from + step * cells[k];
    }
    return to;
  }
}
