// A body's materials and textures, as received from the server.
import type { Texture } from "three";
import { load_texture_bytes, texture_cutoff } from "../common/body";
import type { Looks } from "../common/body";
import { linear_of_hex } from "../common/colours";
import type { BodyMessage } from "./protocol";
import type { Items } from "./wire";

const SKIN: [number, number, number] = [...linear_of_hex("#e3ab8c")];

export class LookLoader {
  private readonly textures = new Map<Items, Promise<Texture | null>>(); // keyed by their encoded bytes

  async load(body: BodyMessage, arrays: Map<string, Items>): Promise<Omit<Looks, "groups">> {
    const textures: (Texture | null)[] = await Promise.all(
      body.textures.map((texture, k) => {
        const bytes = arrays.get(`texture.${k}`) as Uint8Array | undefined;
        if (!bytes) return null;
        // Does not decode unchanged images again.
        let texture_of = this.textures.get(bytes);
        if (!texture_of) {
          texture_of = load_texture_bytes(new Uint8Array(bytes), texture.type, texture.wrap[0], texture.wrap[1]);
          this.textures.set(bytes, texture_of);
        }
        return texture_of;
      }),
    );
    const materials = body.materials.map((material) => ({
      name: material.name,
      colour: [material.colour[0], material.colour[1], material.colour[2]] as [number, number, number],
      cutoff: texture_cutoff(material.alpha_cutoff, material.colour[3]),
      texture: material.texture,
    }));
    return {
      // Bodies without materials look like skin.
      materials: materials.length > 0 ? materials : [{ name: "skin", colour: SKIN, cutoff: 0, texture: -1 }],
      textures,
      layers: body.layers,
    };
  }

  // Disposes of textures whose bytes are gone.
  forget_all_but(arrays: Map<string, Items>): void {
    const kept = new Set(arrays.values());
    for (const [bytes, texture] of this.textures) {
      if (kept.has(bytes)) continue;
      this.textures.delete(bytes);
      void texture.then((one) => one?.dispose());
    }
  }
}
