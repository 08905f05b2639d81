// The studio's viewport: draws the server's body as the user chose.
import { Raycaster, Vector2, Vector3 } from "three";
import type { Group } from "three";
import { Body, BodyMaterials } from "../common/body";
import type { Colouring, Looks } from "../common/body";
import { write_scale_colour } from "../common/colours";
import type { Surface } from "../common/film";
import { nice_above } from "../common/numbers";
import { FIELD, Stage } from "../common/stage";
import { Beside, write_distances } from "./beside";
import { lowest_of, points_to_fit } from "./framing";
import { marker, Overlays } from "./overlays";
import type { BesideBake, BodyMessage } from "./protocol";
import { floor_of } from "./solids";
import { INSIDE, skin_of, tetrahedra_surface } from "./surface";
import type { Cut, Skin } from "./surface";
import type { BlockName, FrameMessage, Items } from "./wire";

export type ShownColour = Colouring | "difference" | "muscles" | "contact" | "paint";

export interface Choice {
  colour: ShownColour;
  comparison: "flesh" | "ghost" | "sides";
  against: "skinning" | "bake"; // what the ghost or the other side shows
  tetrahedra: boolean;
  cut: Cut | null;
  edges: boolean;
  fibres: boolean;
  skeleton: boolean;
  inverted: boolean;
  solids: boolean;
  lag_scale: number; // m, for lag and for the difference
}

// The blocks that frames must contain for this choice.
export function blocks_for(choice: Choice, has_skin: boolean): BlockName[] {
  const blocks: BlockName[] = [];
  const tetrahedra = choice.tetrahedra || !has_skin;
  const ghost = (choice.comparison !== "flesh" && choice.against === "skinning") || choice.colour === "lag";
  blocks.push(tetrahedra ? "vertices" : "surface");
  if (ghost) blocks.push(tetrahedra ? "ghost-vertices" : "ghost");
  if ((choice.fibres || choice.inverted || choice.solids) && !blocks.includes("vertices")) blocks.push("vertices");
  if (choice.skeleton) blocks.push("joints");
  if (choice.colour === "contact") blocks.push("contact");
  if (choice.solids) blocks.push("solids");
  return blocks;
}

// The same for the comparison bake.
export function blocks_beside(choice: Choice, has_skin: boolean): BlockName[] {
  const is_drawn = choice.comparison !== "flesh" && choice.against === "bake";
  if (!is_drawn && choice.colour !== "difference") return [];
  const tetrahedra = choice.tetrahedra || !has_skin;
  const has_lag = is_drawn && choice.comparison === "sides" && choice.colour === "lag";
  if (tetrahedra) return has_lag ? ["vertices", "ghost-vertices"] : ["vertices"];
  return has_lag ? ["surface", "ghost"] : ["surface"];
}

const CONTACT_SCALE = 0.02; // m; the depth that gets the scale's last colour

export class Picture {
  readonly stage: Stage;
  most_lag = 0; // m, maximum so far
  most_difference = 0; // m, likewise
  readonly beside: Beside;
  private message: BodyMessage | null = null;
  private arrays = new Map<string, Items>();
  private skin: Skin | null = null;
  private materials: BodyMaterials | null = null;
  private looks: Looks | null = null;
  private flesh: Body | null = null;
  private ghost: Body | null = null;
  private drawn: Surface | null = null;
  private drawn_as = "";
  readonly overlays: Overlays;
  private positions: Float32Array | null = null; // of the drawn surface's places, m
  private readonly lag = { values: new Float32Array(0) };
  private readonly mark = marker(0xff5a52);
  private readonly grip = marker(0x62b0ff);
  private readonly brush = marker(0xffffff, 0.18);
  private readonly joint = marker(0xffa21a);
  paint_colour: (vertex: number, to: Float32Array, at: number) => void = () => undefined; // for colouring by
                                                                                          // "paint"
  private is_framed = false;
  private is_split = false; // whether there are two pictures side by side

  constructor(canvas: HTMLCanvasElement) {
    this.stage = new Stage(canvas);
    this.stage.spares = true;
    this.beside = new Beside(this.stage.scene);
    this.overlays = new Overlays(this.stage.scene);
    this.stage.scene.add(this.mark, this.grip, this.brush, this.joint);
  }

  get has_skin(): boolean {
    return this.arrays.has("surface.triangle");
  }
  get has_body(): boolean {
    return this.looks !== null;
  }
  get has_muscles(): boolean {
    return this.arrays.has("muscle.vertex");
  }
  // Whether the drawn body and the comparison bake have the same vertices.
  is_like_beside(tetrahedra: boolean): boolean {
    return this.beside.is_like(tetrahedra || !this.skin);
  }

  // Sets the body described by `arrays`; its textures are already loaded.
  set_body(message: BodyMessage, arrays: Map<string, Items>, looks: Omit<Looks, "groups">): void {
    this.message = message;
    this.arrays = arrays;
    const colours = (arrays.get("surface.colour") as Float32Array | undefined) ?? null;
    this.skin = this.has_skin
      ? skin_of({
          rest: arrays.get("surface.rest") as Float32Array,
          triangles: arrays.get("surface.triangle") as Uint32Array,
          material: (arrays.get("surface.material") as Uint32Array | undefined) ?? null,
          uvs: (arrays.get("surface.uv") as Float32Array | undefined) ?? null,
          colours,
          layer: arrays.get("surface.layer") as Uint8Array,
        })
      : null;
    this.looks = { ...looks, groups: this.skin?.groups ?? [] };
    this.materials?.dispose();
    this.materials = new BodyMaterials(this.looks, colours !== null);
    this.muscle_of = null;
    this.drawn_as = "";
    const [least, most] = message.bounds;
    const middle = new Vector3(...least).add(new Vector3(...most)).multiplyScalar(0.5);
    this.overlays.set_body(message, arrays, middle.clone(), this.size);
    if (this.is_framed) return;
    this.is_framed = true;
    const radius = 0.5 * new Vector3(...least).distanceTo(new Vector3(...most)) || 1;
    const rest = (arrays.get("surface.rest") ?? arrays.get("rest")) as Float32Array;
    const lowest = Math.min(least[1], lowest_of(rest));
    const floor = floor_of(message.solids, lowest, middle.x, middle.z);
    const fall = lowest - floor;
    this.stage.furnish(middle, 1.3 * radius + 0.5 * fall, floor);
    middle.y -= 0.5 * fall;
    const points = points_to_fit(rest, arrays.get("surface.surroundings") ?? null, middle.toArray(), fall);
    const canvas = this.stage.canvas;
    this.stage.orbit.frame(middle, points, FIELD, canvas.clientWidth / Math.max(canvas.clientHeight, 1));
  }

  set_beside(bake: BesideBake | null, arrays: Map<string, Items>): void {
    this.most_difference = 0;
    this.beside.set(bake, arrays, this.looks ? { arrays: this.arrays, skin: this.skin, looks: this.looks } : null);
    this.stage.invalidate();
  }

  private rest(): Float32Array {
    return this.arrays.get("rest") as Float32Array;
  }

  private make_bodies(choice: Choice): void {
    const tetrahedra = choice.tetrahedra || !this.skin;
    const key = tetrahedra ? `tetrahedra ${choice.cut?.axis} ${choice.cut?.place}` : "skin";
    if (key === this.drawn_as || !this.looks || !this.materials) return;
    this.drawn_as = key;
    for (const body of [this.flesh, this.ghost]) {
      if (!body) continue;
      this.stage.scene.remove(body.group);
      body.dispose();
    }
    const surface = tetrahedra
      ? tetrahedra_surface(
          this.rest(),
          this.arrays.get("tetrahedron") as Uint32Array,
          this.arrays.get("layer") as Uint8Array,
          choice.cut,
        )
      : this.skin!.surface;
    const looks = tetrahedra
      ? { ...this.looks, groups: [{ material: 0, triangles: surface.triangles.length / 3 }] }
      : this.looks;
    const materials = tetrahedra
      ? new BodyMaterials({ ...looks, materials: [INSIDE] }, false)
      : this.materials;
    this.flesh = new Body(surface, looks, materials, tetrahedra ? null : this.skin!.linear_colours);
    this.ghost = new Body(surface, looks, materials, null);
    this.drawn = surface;
    this.stage.scene.add(this.flesh.group, this.ghost.group);
  }

  // False if the frame lacks what the choice needs.
  show(frame: FrameMessage, choice: Choice): boolean {
    this.make_bodies(choice);
    const tetrahedra = choice.tetrahedra || !this.skin;
    const positions = frame.blocks[tetrahedra ? "vertices" : "surface"];
    const ghost = frame.blocks[tetrahedra ? "ghost-vertices" : "ghost"];
    if (!positions || !this.flesh || !this.ghost || !this.drawn || positions.length !== 3 * this.drawn.places) return false;
    this.positions = positions;
    this.flesh.move(positions);
    const has_ghost = ghost !== undefined && ghost.length === positions.length;
    if (has_ghost) this.ghost.move(ghost);
    const beside = frame.beside ? this.show_beside(frame.beside, choice) : null;
    this.paint(choice, positions, has_ghost ? ghost : null, beside, frame.blocks.contact ?? null);
    if (has_ghost && choice.comparison === "ghost") this.ghost.haunt();
    if (has_ghost && choice.comparison === "sides") {
      this.ghost.stand();
      this.ghost.colour(choice.colour === "layers" || choice.colour === "materials" ? choice.colour : "lag", null, 1);
    }
    this.flesh.show_edges(choice.edges || tetrahedra);
    this.ghost.show_edges((choice.edges || tetrahedra) && choice.comparison === "sides");
    this.overlays.draw(choice, frame, choice.tetrahedra || !this.skin ? this.drawn.source : null);
    this.stage.invalidate();
    return true;
  }

  private show_beside(frame: FrameMessage, choice: Choice): Float32Array | null {
    const { colour, tetrahedra, cut, edges, lag_scale } = choice;
    return this.beside.show(frame, {
      colour: colour === "lag" || colour === "layers" ? colour : "materials",
      tetrahedra,
      cut,
      edges,
      lag_scale,
      is_ghost: choice.comparison === "ghost",
    });
  }

  private paint(
    choice: Choice,
    positions: Float32Array,
    ghost: Float32Array | null,
    beside: Float32Array | null,
    contact: Float32Array | null,
  ): void {
    const flesh = this.flesh!;
    const drawn = this.drawn!;
    if (choice.colour === "lag" && ghost) {
      if (this.lag.values.length !== drawn.places) this.lag.values = new Float32Array(drawn.places);
      this.most_lag = Math.max(this.most_lag, write_distances(positions, ghost, this.lag.values));
      flesh.colour("lag", this.lag.values, choice.lag_scale);
    } else if (choice.colour === "difference" && beside && this.is_like_beside(choice.tetrahedra)) {
      if (this.lag.values.length !== drawn.places) this.lag.values = new Float32Array(drawn.places);
      this.most_difference = Math.max(this.most_difference, write_distances(positions, beside, this.lag.values));
      flesh.colour("lag", this.lag.values, choice.lag_scale);
    } else if (choice.colour === "paint") {
      flesh.colour_by(this.paint_colour);
    } else if (choice.colour === "muscles") {
      flesh.colour_by((vertex, to, at) => this.muscle_colour(vertex, to, at));
    } else if (choice.colour === "contact" && contact) {
      flesh.colour_by((vertex, to, at) => {
        const depth = contact[3 * vertex];
        if (depth >= 0) write_scale_colour(depth / CONTACT_SCALE, to, at);
        else to.fill(0.55, at, at + 3);
      });
    } else {
      flesh.colour(choice.colour === "layers" ? "layers" : "materials", null, 1);
    }
  }

  private muscle_of: Map<number, number> | null = null;
  private muscle_colour(vertex: number, to: Float32Array, at: number): void {
    if (!this.muscle_of) {
      this.muscle_of = new Map();
      const pairs = this.arrays.get("muscle.vertex") as Uint32Array;
      for (let k = 0; k < pairs.length; k += 2) this.muscle_of.set(pairs[k], pairs[k + 1]);
    }
    const muscle = this.muscle_of.get(vertex);
    if (muscle === undefined) {
      to.fill(0.55, at, at + 3);
      return;
    }
    // Hues a golden angle apart, so that neighbouring numbers differ clearly.
    const hue = (0.02 + 0.618034 * muscle) % 1;
    for (let c = 0; c < 3; ++c) to[at + c] = 0.08 + 0.55 * Math.max(0, 1 - 3 * Math.abs(((hue - c / 3 + 1.5) % 1) - 0.5));
  }

  scale_for(colour: ShownColour): number {
    const most = colour === "difference" ? this.most_difference : Math.max(this.most_lag, this.beside.most_lag);
    return nice_above(Math.max(most, 1e-4), [1, 1.5, 2, 3, 4, 5, 6, 8, 10]);
  }

  render(choice: Choice): void {
    const { flesh, ghost, stage } = this;
    if (!flesh || !ghost) return;
    const played = [flesh.group, this.overlays.of_played];
    const all = [...played, ghost.group, ...(this.beside.group ? [this.beside.group] : [])];
    const with_only = (...shown: Group[]) => ({ shown, hidden: all.filter((one) => !shown.includes(one)) });
    const other = choice.against === "bake" ? this.beside.group : ghost.group;
    this.is_split = other !== null && choice.comparison === "sides";
    if (!other || choice.comparison === "flesh") stage.render([with_only(...played)]);
    else if (choice.comparison === "sides") stage.render([with_only(other), with_only(...played)]);
    else stage.render([with_only(...played, other)]);
  }

  get surface(): Surface | null {
    return this.drawn;
  }
  get places(): Float32Array | null {
    return this.positions;
  }
  // The skin's own vertices, m; null if there is no skin or it is not drawn.
  get rest_of_skin(): Float32Array | null {
    return this.drawn_as === "skin" ? (this.arrays.get("surface.rest") as Float32Array) : null;
  }
  get size(): number {
    if (!this.message) return 1;
    const [least, most] = this.message.bounds;
    return new Vector3(...least).distanceTo(new Vector3(...most)) || 1;
  }

  // Moves the camera to a place on the body, and marks it.
  point_at(place: readonly [number, number, number]): void {
    this.mark.visible = true;
    this.mark.position.set(...place);
    this.mark.scale.setScalar(0.012 * this.size);
    this.stage.orbit.go_to(new Vector3(...place), 0.55 * this.size);
  }
  point_at_nothing(): void {
    this.mark.visible = false;
    this.stage.invalidate();
  }

  // The ray through a point of the window.
  ray_at(x: number, y: number): Raycaster {
    const { camera, orbit } = this.stage;
    const box = this.box_of_played();
    orbit.apply(camera);
    camera.updateMatrixWorld();
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2((2 * (x - box.left)) / box.width - 1, 1 - (2 * (y - box.top)) / box.height), camera);
    return ray;
  }

  // The part of the window that shows the played body: the whole picture, or its right half.
  box_of_played(): DOMRect {
    const box = this.stage.canvas.getBoundingClientRect();
    if (!this.is_split) return box;
    return new DOMRect(box.left + box.width / 2, box.top, box.width / 2, box.height);
  }

  show_brush(place: readonly [number, number, number] | null, radius: number): void {
    if (!place && !this.brush.visible) return;
    this.brush.visible = place !== null;
    if (place) {
      this.brush.position.set(...place);
      this.brush.scale.setScalar(radius);
    }
    this.stage.invalidate();
  }

  show_joint(place: readonly [number, number, number] | null): void {
    if (!place && !this.joint.visible) return;
    this.joint.visible = place !== null;
    if (place) {
      this.joint.position.set(...place);
      this.joint.scale.setScalar(0.012 * this.size);
    }
    this.stage.invalidate();
  }

  show_grip(place: readonly [number, number, number] | null): void {
    this.grip.visible = place !== null;
    if (place) {
      this.grip.position.set(...place);
      this.grip.scale.setScalar(0.01 * this.size);
    }
    this.stage.invalidate();
  }
}
