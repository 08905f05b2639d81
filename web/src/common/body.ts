// A moving surface in a scene: its materials, layers and lag.
import {
  BufferAttribute,
  BufferGeometry,
  ClampToEdgeWrapping,
  DoubleSide,
  DynamicDrawUsage,
  FrontSide,
  Group,
  LineSegments,
  LineBasicMaterial,
  Mesh,
  MeshStandardMaterial,
  MirroredRepeatWrapping,
  RepeatWrapping,
  SRGBColorSpace,
  Texture,
} from "three";
import { linear_of_hex, linear_of_srgb, write_scale_colour } from "./colours";
import type { Layer, Material, PageTexture, Surface } from "./film";
import { bytes_of_base64 } from "./film";
import { Normals } from "./normals";

export type Colouring = "materials" | "layers" | "lag";

export interface Looks {
  groups: { material: number; triangles: number }[];
  materials: Material[];
  textures: (Texture | null)[];
  layers: Layer[];
}

const WRAPS = { repeat: RepeatWrapping, mirror: MirroredRepeatWrapping, clamp: ClampToEdgeWrapping };

// What a texel's alpha must reach, for a material whose base colour has alpha too: only the texture's is compared.
export function texture_cutoff(cutoff: number, base_alpha: number): number {
  if (cutoff <= 0) return 0;
  const all = 2; // more than any alpha
  return base_alpha > 0 ? Math.min(cutoff / base_alpha, all) : all;
}

// Null if it cannot be decoded; the material's plain colour is used instead.
export async function load_texture_bytes(
  bytes: Uint8Array<ArrayBuffer>,
  type: string,
  across: keyof typeof WRAPS,
  down: keyof typeof WRAPS,
): Promise<Texture | null> {
  try {
    const blob = new Blob([bytes], { type });
    const image = await createImageBitmap(blob, { premultiplyAlpha: "none", colorSpaceConversion: "none" });
    const made = new Texture(image);
    made.wrapS = WRAPS[across];
    made.wrapT = WRAPS[down];
    made.flipY = false;
    made.colorSpace = SRGBColorSpace;
    made.anisotropy = 4;
    made.needsUpdate = true;
    return made;
  } catch {
    return null;
  }
}

export function load_textures(textures: PageTexture[]): Promise<(Texture | null)[]> {
  return Promise.all(
    textures.map((texture) =>
      load_texture_bytes(bytes_of_base64(texture.base64), texture.type, texture.across, texture.down),
    ),
  );
}

// Shared by a body and its ghost.
export class BodyMaterials {
  readonly painted: MeshStandardMaterial[];
  readonly coloured = new MeshStandardMaterial({ vertexColors: true, roughness: 0.85, side: DoubleSide });
  readonly plain = new MeshStandardMaterial({ color: 0xb9bcc2, roughness: 0.9, side: DoubleSide });
  readonly ghost = new MeshStandardMaterial({
    color: 0x4da3ff,
    roughness: 0.6,
    transparent: true,
    opacity: 0.38,
    depthWrite: false,
    side: FrontSide,
    // Where the ghost is not further out than the flesh, show the flesh.
    polygonOffset: true,
    polygonOffsetFactor: 2,
    polygonOffsetUnits: 16,
  });
  readonly lines = new LineBasicMaterial({ color: 0x101318, transparent: true, opacity: 0.35 });

  constructor(looks: Looks, has_colours: boolean) {
    this.painted = looks.materials.map((material) => {
      const made = new MeshStandardMaterial({
        roughness: 0.75,
        metalness: 0,
        side: DoubleSide,
        vertexColors: has_colours,
        map: material.texture < 0 ? null : looks.textures[material.texture],
        alphaTest: material.cutoff,
      });
      made.color.setRGB(...material.colour);
      return made;
    });
    for (const surface of [...this.painted, this.coloured, this.plain]) {
      // Draw edge lines in front of their surface.
      surface.polygonOffset = true;
      surface.polygonOffsetFactor = 1;
      surface.polygonOffsetUnits = 1;
    }
  }

  // Does not dispose of textures: their owner does.
  dispose(): void {
    for (const one of [...this.painted, this.coloured, this.plain, this.ghost, this.lines]) one.dispose();
  }
}

function edges_of(triangles: Uint32Array, place: Uint32Array): Uint32Array {
  const seen = new Set<number>();
  const edges: number[] = [];
  for (let t = 0; t < triangles.length; t += 3)
    for (let k = 0; k < 3; ++k) {
      const a = triangles[t + k];
      const b = triangles[t + ((k + 1) % 3)];
      const key = Math.min(place[a], place[b]) * 0x4000000 + Math.max(place[a], place[b]);
      if (seen.has(key)) continue;
      seen.add(key);
      edges.push(a, b);
    }
  return Uint32Array.from(edges);
}

export class Body {
  readonly group = new Group();
  readonly mesh: Mesh;
  private readonly geometry = new BufferGeometry();
  private readonly positions: BufferAttribute;
  private readonly normal_values: BufferAttribute;
  private readonly colour_values: BufferAttribute;
  private readonly normals: Normals;
  private lines: LineSegments | null = null;
  private coloured_as: Colouring | null = null;

  constructor(
    private readonly surface: Surface,
    private readonly looks: Looks,
    private readonly materials: BodyMaterials,
    private readonly linear_colours: Float32Array | null = null, // 3 per vertex, replace the surface's own
  ) {
    const vertices = surface.place.length;
    const dynamic = () => {
      const attribute = new BufferAttribute(new Float32Array(3 * vertices), 3);
      attribute.setUsage(DynamicDrawUsage);
      return attribute;
    };
    this.positions = dynamic();
    this.normal_values = dynamic();
    this.colour_values = dynamic();
    this.geometry.setIndex(new BufferAttribute(surface.triangles, 1));
    this.geometry.setAttribute("position", this.positions);
    this.geometry.setAttribute("normal", this.normal_values);
    this.geometry.setAttribute("color", this.colour_values);
    if (surface.uvs) this.geometry.setAttribute("uv", new BufferAttribute(surface.uvs, 2));
    let start = 0;
    for (const group of looks.groups) {
      this.geometry.addGroup(start, 3 * group.triangles, group.material);
      start += 3 * group.triangles;
    }
    this.normals = new Normals(surface);
    this.mesh = new Mesh(this.geometry, materials.painted);
    this.mesh.castShadow = true;
    this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false;
    this.group.add(this.mesh);
  }

  // `places`: 3 per place, m.
  move(places: Float32Array): void {
    const { place } = this.surface;
    const positions = this.positions.array as Float32Array;
    for (let i = 0; i < place.length; ++i) {
      const from = 3 * place[i];
      positions[3 * i] = places[from];
      positions[3 * i + 1] = places[from + 1];
      positions[3 * i + 2] = places[from + 2];
    }
    this.normals.write(positions, this.normal_values.array as Float32Array);
    this.positions.needsUpdate = true;
    this.normal_values.needsUpdate = true;
  }

  // `lag`: m, one per place, for that colouring; null if there is none to show.
  colour(colouring: Colouring, lag: Float32Array | null, most_lag: number): void {
    const { place, layer, colours } = this.surface;
    if (colouring === "lag" && !lag) {
      this.mesh.material = this.materials.plain;
      this.coloured_as = null;
      return;
    }
    this.mesh.material = colouring === "materials" ? this.materials.painted : this.materials.coloured;
    if (colouring !== "lag" && this.coloured_as === colouring) return;
    this.coloured_as = colouring;
    const values = this.colour_values.array as Float32Array;
    if (colouring === "lag") {
      for (let i = 0; i < place.length; ++i) write_scale_colour(lag![place[i]] / most_lag, values, 3 * i);
    } else if (colouring === "layers") {
      const of_layer = this.looks.layers.map((one) => linear_of_hex(one.colour));
      for (let i = 0; i < place.length; ++i) values.set(of_layer[layer[i]] ?? [1, 1, 1], 3 * i);
    } else if (this.linear_colours) {
      values.set(this.linear_colours);
    } else if (colours) {
      for (let k = 0; k < values.length; ++k) values[k] = linear_of_srgb(colours[k] / 255);
    } else {
      values.fill(1);
    }
    this.colour_values.needsUpdate = true;
  }

  // Colours by a function that gets the vertex's number in the bake and writes three entries.
  colour_by(write: (vertex: number, to: Float32Array, at: number) => void): void {
    this.mesh.material = this.materials.coloured;
    this.coloured_as = null;
    const values = this.colour_values.array as Float32Array;
    this.surface.source.forEach((vertex, i) => write(vertex, values, 3 * i));
    this.colour_values.needsUpdate = true;
  }

  dispose(): void {
    this.geometry.dispose();
    this.lines?.geometry.dispose();
  }

  haunt(): void {
    this.mesh.material = this.materials.ghost;
    this.mesh.castShadow = false;
    this.mesh.receiveShadow = false;
    this.mesh.renderOrder = 1;
    this.coloured_as = null;
  }

  stand(): void {
    this.mesh.castShadow = true;
    this.mesh.receiveShadow = true;
    this.mesh.renderOrder = 0;
  }

  show_edges(shown: boolean): void {
    if (shown && !this.lines) {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", this.positions);
      geometry.setIndex(new BufferAttribute(edges_of(this.surface.triangles, this.surface.place), 1));
      this.lines = new LineSegments(geometry, this.materials.lines);
      this.lines.frustumCulled = false;
      this.group.add(this.lines);
    }
    if (this.lines) this.lines.visible = shown;
  }
}
