// The binary messages of the studio's server: docs/design/studio.md.

const ARRAY = 2;
const FRAME = 1;
const BESIDE = 3;

export type Items = Uint8Array | Uint32Array | Float32Array;

export interface ArrayMessage {
  body: number;
  name: string;
  items: Items;
}

// 3 numbers per point.
export interface Block {
  positions: Float32Array;
}

export const BLOCKS = ["surface", "ghost", "vertices", "ghost-vertices", "joints", "contact", "solids"] as const;
export type BlockName = (typeof BLOCKS)[number];

export interface FrameMessage {
  sequence: number;
  body: number;
  revision: number;
  frame: number;
  is_recorded: boolean;
  begins: boolean; // the first after a start, a seek or a change of body
  time: number; // s, in the clip
  hash: string; // 16 hex digits
  solver_seconds: number;
  rate: number; // frames per second that the solver can compute
  lag: number; // m, root mean square
  most_lag: number;
  energy: number; // J
  volume: number; // relative to the rest shape
  inverted: number;
  speed: number; // m/s
  blocks: Partial<Record<BlockName, Float32Array>>;
  beside: FrameMessage | null; // of the comparison bake
}

const aligned = (bytes: number) => (bytes + 3) & ~3;

function need(holds: boolean, what: string): void {
  if (!holds) throw new Error(`the server sent an invalid ${what}`);
}

export function read_array(buffer: ArrayBuffer): ArrayMessage {
  const view = new DataView(buffer);
  need(buffer.byteLength >= 16 && view.getUint8(0) === ARRAY && view.getUint8(1) === 1, "array");
  const kind = view.getUint8(2);
  const length = view.getUint8(3);
  const count = view.getUint32(8, true);
  const start = aligned(16 + length);
  need(16 + length <= buffer.byteLength, "array");
  const name = new TextDecoder().decode(new Uint8Array(buffer, 16, length));
  const width = kind === 1 ? 1 : 4;
  need((kind === 1 || kind === 2 || kind === 3) && start + width * count <= buffer.byteLength, "array");
  const items =
    kind === 1
      ? new Uint8Array(buffer, start, count)
      : kind === 2
        ? new Uint32Array(buffer, start, count)
        : new Float32Array(buffer, start, count);
  return { body: view.getUint32(4, true), name, items };
}

export function read_frame(buffer: ArrayBuffer): FrameMessage {
  const { frame, end } = read_one(buffer, 0, FRAME);
  if (end < buffer.byteLength) {
    const beside = read_one(buffer, end, BESIDE);
    need(beside.end === buffer.byteLength, "frame");
    frame.beside = beside.frame;
  }
  return frame;
}

function read_one(buffer: ArrayBuffer, start: number, type: number): { frame: FrameMessage; end: number } {
  need(buffer.byteLength >= start + 80, "frame");
  const view = new DataView(buffer, start);
  need(view.getUint8(0) === type && view.getUint8(1) === 1, "frame");
  const end = start + view.getUint32(76, true);
  need(end <= buffer.byteLength, "frame");
  const bits = view.getUint16(2, true);
  const blocks: FrameMessage["blocks"] = {};
  let at = 80;
  BLOCKS.forEach((name, k) => {
    if (!(bits & (1 << k))) return;
    need(start + at + 32 <= end, "frame");
    const points = view.getUint32(at + 24, true);
    need(start + at + 32 + 6 * points <= end, "frame");
    const cells = new Uint16Array(buffer, start + at + 32, 3 * points);
    const positions = new Float32Array(3 * points);
    for (let axis = 0; axis < 3; ++axis) {
      const least = view.getFloat32(at + 4 * axis, true);
      const step = view.getFloat32(at + 12 + 4 * axis, true);
      for (let i = axis; i < cells.length; i += 3) positions[i] = least + step * cells[i];
    }
    blocks[name] = positions;
    at = aligned(at + 32 + 6 * points);
  });
  const frame: FrameMessage = {
    sequence: view.getUint32(4, true),
    body: view.getUint32(8, true),
    revision: view.getUint32(12, true),
    frame: view.getUint32(16, true),
    is_recorded: (view.getUint32(20, true) & 1) !== 0,
    begins: (view.getUint32(20, true) & 4) !== 0,
    time: view.getFloat64(24, true),
    hash: view.getBigUint64(32, true).toString(16).padStart(16, "0"),
    solver_seconds: view.getFloat32(40, true),
    rate: view.getFloat32(44, true),
    lag: view.getFloat32(48, true),
    most_lag: view.getFloat32(52, true),
    energy: view.getFloat32(56, true),
    volume: view.getFloat32(60, true),
    inverted: view.getUint32(64, true),
    speed: view.getFloat32(72, true),
    blocks,
    beside: null,
  };
  return { frame, end };
}
