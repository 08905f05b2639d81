// The comparison bake: its shape, and how it is drawn.
import type { Group, Scene } from "three";
import { Body, BodyMaterials } from "../common/body";
import type { Looks } from "../common/body";
import { linear_of_hex } from "../common/colours";
import type { Surface } from "../common/film";
import type { BesideBake } from "./protocol";
import { INSIDE, skin_of, tetrahedra_surface } from "./surface";
import type { Cut, Skin } from "./surface";
import type { FrameMessage, Items } from "./wire";

export const BESIDE_COLOUR = 0xff4fd0; // colour of its ghost; the skinning ghost is blue, and skin is often
                                       // near orange

// How to draw it.
export interface BesideChoice {
  colour: "materials" | "layers" | "lag";
  tetrahedra: boolean;
  cut: Cut | null;
  is_ghost: boolean;
  edges: boolean;
  lag_scale: number; // m
}

export function same_items(a: Items | undefined, b: Items | undefined): boolean {
  if (!a || !b || a.length !== b.length) return false;
  for (let k = 0; k < a.length; ++k) if (a[k] !== b[k]) return false;
  return true;
}

// Writes the distances, m, between two lists of places (3 numbers each); returns the largest.
export function write_distances(a: Float32Array, b: Float32Array, to: Float32Array): number {
  let most = 0;
  for (let p = 0; p < to.length; ++p) {
    const k = 3 * p;
    to[p] = Math.hypot(a[k] - b[k], a[k + 1] - b[k + 1], a[k + 2] - b[k + 2]);
    if (to[p] > most) most = to[p];
  }
  return most;
}

export class Beside {
  private arrays = new Map<string, Items>();
  private skin: Skin | null = null;
  private looks: Looks | null = null;
  private materials: BodyMaterials | null = null;
  private body: Body | null = null;
  private drawn: Surface | null = null;
  private drawn_as = "";
  private lag = new Float32Array(0);
  private has_colours = false;
  most_lag = 0; // m, maximum so far
  has_same_skin = false;
  has_same_tetrahedra = false;

  constructor(private readonly scene: Scene) {}

  get is_there(): boolean {
    return this.looks !== null;
  }
  get has_skin(): boolean {
    return this.arrays.has("surface.triangle");
  }
  get group(): Group | null {
    return this.body?.group ?? null;
  }
  // Whether its places correspond one to one to those of the played body.
  is_like(tetrahedra: boolean): boolean {
    return tetrahedra ? this.has_same_tetrahedra : this.has_same_skin;
  }

  // `arrays`: the bake's, without the prefix. `played`: of the played body; null while unknown.
  set(
    bake: BesideBake | null,
    arrays: Map<string, Items>,
    played: { arrays: Map<string, Items>; skin: Skin | null; looks: Looks } | null,
  ): void {
    this.clear();
    if (!bake || !played) return;
    this.arrays = arrays;
    const same = (name: string) => same_items(arrays.get(name), played.arrays.get(name));
    this.has_same_skin =
      this.has_skin &&
      same("surface.triangle") &&
      arrays.get("surface.rest")?.length === played.arrays.get("surface.rest")?.length;
    this.has_same_tetrahedra = same("tetrahedron");
    // A bake with the same vertices has the colours of the played body.
    const colours = this.has_same_skin ? ((played.arrays.get("surface.colour") as Float32Array | undefined) ?? null) : null;
    const material = this.has_same_skin ? ((played.arrays.get("surface.material") as Uint32Array | undefined) ?? null) : null;
    const uvs = this.has_same_skin ? ((played.arrays.get("surface.uv") as Float32Array | undefined) ?? null) : null;
    this.skin = this.has_skin
      ? skin_of({
          rest: arrays.get("surface.rest") as Float32Array,
          triangles: arrays.get("surface.triangle") as Uint32Array,
          material,
          uvs,
          colours,
          layer: arrays.get("surface.layer") as Uint8Array,
        })
      : null;
    const plain = [{ name: "skin", colour: [...linear_of_hex("#e3ab8c")] as [number, number, number], cutoff: 0, texture: -1 }];
    this.looks = {
      groups: this.skin?.groups ?? [],
      materials: this.has_same_skin ? played.looks.materials : plain,
      textures: this.has_same_skin ? played.looks.textures : [],
      layers: bake.layers,
    };
    this.has_colours = colours !== null;
  }

  private clear(): void {
    this.drop_body();
    this.arrays = new Map();
    this.looks = this.skin = null;
    this.has_same_skin = this.has_same_tetrahedra = false;
    this.most_lag = 0;
  }

  private drop_body(): void {
    if (this.body) {
      this.scene.remove(this.body.group);
      this.body.dispose();
    }
    this.materials?.dispose();
    this.body = this.drawn = this.materials = null;
    this.drawn_as = "";
  }

  private make_body(tetrahedra: boolean, cut: Cut | null): void {
    const key = tetrahedra ? `tetrahedra ${cut?.axis} ${cut?.place}` : "skin";
    if (key === this.drawn_as || !this.looks) return;
    this.drop_body();
    this.drawn_as = key;
    this.drawn = tetrahedra
      ? tetrahedra_surface(
          this.arrays.get("rest") as Float32Array,
          this.arrays.get("tetrahedron") as Uint32Array,
          this.arrays.get("layer") as Uint8Array,
          cut,
        )
      : this.skin!.surface;
    const looks = tetrahedra
      ? {
          ...this.looks,
          groups: [{ material: 0, triangles: this.drawn.triangles.length / 3 }],
          materials: [INSIDE],
        }
      : this.looks;
    this.materials = new BodyMaterials(looks, this.has_colours && !tetrahedra);
    this.materials.ghost.color.setHex(BESIDE_COLOUR);
    this.body = new Body(this.drawn, looks, this.materials, tetrahedra ? null : this.skin!.linear_colours);
    this.scene.add(this.body.group);
  }

  // Draws a frame. Returns its places; null if the frame does not contain them.
  show(frame: FrameMessage, choice: BesideChoice): Float32Array | null {
    if (!this.is_there) return null;
    const tetrahedra = choice.tetrahedra || !this.skin;
    this.make_body(tetrahedra, choice.cut);
    const places = frame.blocks[tetrahedra ? "vertices" : "surface"];
    const skinned = frame.blocks[tetrahedra ? "ghost-vertices" : "ghost"];
    if (!places || !this.body || !this.drawn || places.length !== 3 * this.drawn.places) return null;
    this.body.move(places);
    if (choice.is_ghost) {
      this.body.haunt();
    } else {
      this.body.stand();
      if (choice.colour === "lag" && skinned && skinned.length === places.length) {
        if (this.lag.length !== this.drawn.places) this.lag = new Float32Array(this.drawn.places);
        this.most_lag = Math.max(this.most_lag, write_distances(places, skinned, this.lag));
        this.body.colour("lag", this.lag, choice.lag_scale);
      } else {
        this.body.colour(choice.colour, null, 1);
      }
    }
    this.body.show_edges((choice.edges || tetrahedra) && !choice.is_ghost);
    return places;
  }
}
