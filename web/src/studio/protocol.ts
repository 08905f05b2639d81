// The server's JSON messages: docs/design/studio.md. Contains only the members that the page reads.

export interface Hello {
  type: "hello";
  protocol: number;
  program: string;
  kind: "live" | "bake";
  name: string;
  source: string;
  folder: string;
  device: string;
  can_touch: boolean;
  why_not?: string;
  restored?: boolean;
  message?: string;
}

export interface BodyLayer {
  name: string;
  kinematic: boolean;
  vertices: number;
  mass: number;
  colour: string;
}

// A box of this half size, rounded by the radius. For a plane, everything below its height, the radius, is
// solid.
export interface SolidMessage {
  name: string;
  shape: "plane" | "sphere" | "capsule" | "box";
  half_size: [number, number, number]; // m
  radius: number; // m
  middle: [number, number, number]; // m, in the bind pose
  up: [number, number, number]; // its own second axis in the bind pose
}

export interface BodyMessage {
  type: "body";
  body: number;
  counts: Record<"vertices" | "tetrahedra" | "surface_vertices" | "surface_triangles" | "joints", number>;
  bounds: [[number, number, number], [number, number, number]];
  layers: BodyLayer[];
  solids: SolidMessage[];
  joints: { name: string; parent: number; is_bone?: boolean; is_kinematic?: boolean; reason?: string }[];
  muscles: { name: string }[];
  materials: { name: string; colour: [number, number, number, number]; alpha_cutoff: number; texture: number }[];
  textures: { name: string; type: string; wrap: ["repeat" | "mirror" | "clamp", "repeat" | "mirror" | "clamp"] }[];
  arrays: string[];
}

export interface ClipMessage {
  type: "clip";
  name: string;
  clips: string[];
  fps: number;
  start: number;
  frames: number; // number of the last; the first is 0
  substeps: number;
  iterations: number;
}

export type KeyValue = number | string | boolean | null | (number | string)[];

export interface SceneKey {
  path: string;
  name: string;
  doc: string;
  kind: "number" | "integer" | "text" | "boolean" | "vector" | "texts" | "other";
  value: KeyValue;
  is_set: boolean;
  fallback: KeyValue | string;
  minimum?: number;
  maximum?: number;
  minimum_excluded?: boolean;
  soft_minimum?: number;
  soft_maximum?: number;
  logarithmic?: boolean;
  unit?: string;
  allowed?: string[];
  rivals?: string[]; // keys that are dropped when this one is set
  effect: "live" | "rebuild";
  why_unused?: string; // the reason why it would be refused in the current scene
}

export interface KeyGroup {
  path: string;
  title: string;
  doc: string;
  keys: SceneKey[];
}

export interface Preset {
  name: string;
  title: string;
  doc: string;
  changes: Record<string, KeyValue>;
  why_not?: string;
}

export interface SceneWarning {
  text: string;
  places: [number, number, number][];
  vertices: number[];
}

export interface History {
  type: "history";
  revision: number;
  undo: string | null;
  redo: string | null;
  steps: number;
  saved: boolean;
}

export interface PlayerMessage {
  type: "player";
  state: "playing" | "paused" | "recording" | "baking";
  frame: number;
  speed: number;
  loop: boolean;
  message: string;
}

export interface PaintMessage {
  type: "paint";
  can_paint: boolean;
  why_not: string;
  attributes: { name: string; why_not: string; most: number }[]; // most: its largest allowed value
  arrays: string[]; // that follow this message
}

// A bake shown for comparison.
export interface BesideBake {
  name: string;
  fps: number;
  start: number;
  frames: number; // number of the last; the first is 0
  counts: BodyMessage["counts"];
  layers: BodyLayer[];
  arrays: string[]; // that follow this message
  why_no_lag?: string; // absent if frames contain it
}

export interface BesideMessage {
  type: "beside";
  choices: string[];
  bake: BesideBake | null;
}

export type ServerMessage =
  | Hello
  | BodyMessage
  | ClipMessage
  | { type: "keys"; revision: number; groups: KeyGroup[] }
  | { type: "presets"; list: Preset[] }
  | { type: "warnings"; list: SceneWarning[] }
  | History
  | PlayerMessage
  | PaintMessage
  | BesideMessage
  | { type: "ready" }
  | { type: "changed"; revision: number; changes: Record<string, KeyValue>; effect: string; message: string }
  | { type: "applied"; revision: number; effect: string; seconds: number; sequence: number }
  | { type: "device"; device: string }
  | { type: "failed"; what: "change" | "motion" | "bake" | "beside" | "autosave"; error: string }
  | { type: "hand"; is_held: boolean; vertices: number; force: [number, number, number] }
  | { type: "recorded"; frames: number; position_hash: string; seconds: number }
  | { type: "saved"; file: string; kept_comments: boolean; message: string }
  | { type: "baking"; frame: number; frames: number; phase: string }
  | { type: "baked"; folder: string; files: string[]; position_hash: string; frames: number; seconds: number; warnings: string[] }
  | { type: "cancelled" }
  | { type: "done"; id?: number; message?: string }
  | { type: "refused"; id?: number; error: string };
