// The scene around the bodies: light, floor, and one view of it or two side by side.
import {
  CircleGeometry,
  Color,
  DirectionalLight,
  GridHelper,
  Group,
  HemisphereLight,
  LineBasicMaterial,
  Mesh,
  PerspectiveCamera,
  Scene,
  ShadowMaterial,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { nice_above } from "./numbers";
import { Orbit } from "./orbit";

export const FIELD = (32 * Math.PI) / 180; // rad, vertical angle of view

const MOST_RATIO = 2; // render pixels per page pixel during motion
const SLOW = 70; // ms per picture
const MOST_LATE = 6; // this many slow pictures in a row reduce the quality
const STILL = 180; // ms without a change before a picture is drawn at full quality
const LEAST_RATIO = 0.5;

// What a slow machine leaves out during motion.
export interface Spared {
  shadows: boolean;
  ratio: number; // divisor of the pixel ratio
}

// The next reduction; the same if there is none.
export function spared_more(spared: Spared, screen_ratio: number): Spared {
  if (!spared.shadows) return { ...spared, shadows: true };
  const ratio = Math.min(screen_ratio, MOST_RATIO) / spared.ratio;
  return ratio > LEAST_RATIO ? { ...spared, ratio: 1.5 * spared.ratio } : spared;
}

// The part of a way that is whole cells: a floor moved by it keeps its lines where they were.
export function whole_cells(way: number, cell: number): number {
  return cell * Math.round(way / cell);
}

export interface Half {
  shown: Group[];
  hidden: Group[];
}

export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera();
  readonly orbit = new Orbit(() => this.invalidate());
  spares = false; // whether a slow machine gets simpler pictures during motion
  moves = false; // whether the content moves by itself; otherwise a still picture is drawn at full quality
  private readonly renderer: WebGLRenderer;
  private readonly sun = new DirectionalLight(0xffffff, 2.1);
  private readonly rim = new DirectionalLight(0xdfe8ff, 0.7);
  private readonly sky = new HemisphereLight(0xffffff, 0x9a948c, 1.25);
  private readonly floor = new Group();
  private readonly shadow = new ShadowMaterial({ opacity: 0.22, depthWrite: false });
  private grid: GridHelper | null = null;
  private radius = 1;
  private cell = 1; // m, of the grid
  private readonly home = new Vector3(); // the floor's middle before the camera follows the body
  private stale = true;
  private changed = 0; // ms, time of the last visible change
  private spared: Spared = { shadows: false, ratio: 1 };
  // For the last picture: whether it had full quality, and whether it was requested at full quality.
  private is_full = false;
  private is_settled = false;
  private fence: WebGLSync | null = null; // after the last draw commands
  private late = 0;
  private asked = 0; // ms, when they were issued

  // Throws if the browser has no WebGL 2.
  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
    this.renderer.shadowMap.enabled = true;
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.normalBias = 0.02;
    this.scene.add(this.sky, this.sun, this.sun.target, this.rim, this.rim.target, this.floor);
    this.orbit.listen(canvas);
    // A browser takes the GPU away, on a driver's reset or from a page in the background, and gives it back.
    // three.js uploads everything again.
    canvas.addEventListener("webglcontextlost", () => (this.fence = null));
    canvas.addEventListener("webglcontextrestored", () => {
      this.fence = null;
      this.invalidate();
    });
  }

  invalidate(): void {
    this.stale = true;
    this.changed = performance.now();
  }

  // Sets up the scene for a motion within this sphere, on a floor at this height.
  furnish(middle: Vector3, radius: number, floor: number): void {
    this.radius = radius;
    const cell = nice_above(radius / 5);
    this.cell = cell;
    this.home.copy(middle);
    const cells = 2 * Math.ceil((2.4 * radius) / cell);
    this.grid = new GridHelper(cells * cell, cells);
    (this.grid.material as LineBasicMaterial).transparent = true;
    const disc = new Mesh(new CircleGeometry(4 * radius, 64), this.shadow);
    disc.rotation.x = -Math.PI / 2;
    disc.receiveShadow = true;
    disc.position.y = 0.001 * radius;
    this.floor.add(this.grid, disc);
    this.floor.position.y = floor - 0.003 * radius;
    const shadow = this.sun.shadow.camera;
    shadow.left = shadow.bottom = -1.6 * radius;
    shadow.right = shadow.top = 1.6 * radius;
    shadow.near = 0.1 * radius;
    shadow.far = 8 * radius;
    shadow.updateProjectionMatrix();
    this.sun.shadow.normalBias = 0.004 * radius;
    this.sun.shadow.bias = -0.0004;
    this.light_up(middle);
    this.invalidate();
  }

  // Moves the lights along with the camera's target, and the floor along with a body that it follows.
  light_up(middle: Vector3): void {
    const { carried } = this.orbit;
    this.floor.position.x = this.home.x + whole_cells(carried.x, this.cell);
    this.floor.position.z = this.home.z + whole_cells(carried.z, this.cell);
    this.sun.target.position.copy(middle);
    this.sun.position.copy(middle).add(new Vector3(1.4, 2.6, 1.9).multiplyScalar(this.radius));
    this.rim.target.position.copy(middle);
    this.rim.position.copy(middle).add(new Vector3(-2, 1.2, -2.4).multiplyScalar(this.radius));
  }

  show_floor(shown: boolean): void {
    this.floor.visible = shown;
    this.invalidate();
  }

  paint(background: string, lines: string, line_opacity: number): void {
    this.scene.background = new Color(background);
    if (this.grid) {
      const material = this.grid.material as LineBasicMaterial;
      material.vertexColors = false;
      material.color = new Color(lines);
      material.opacity = line_opacity;
      material.needsUpdate = true;
    }
    this.invalidate();
  }

  // Draws one picture, or two side by side, each with its own groups. False if nothing had changed.
  render(halves: Half[]): boolean {
    const width = this.canvas.clientWidth;
    const height = this.canvas.clientHeight;
    if (width === 0 || height === 0) return false;
    const size = this.renderer.getSize(new Vector2());
    if (size.x !== width || size.y !== height) {
      this.renderer.setSize(width, height, false);
      this.stale = true;
    }
    // Once nothing changes any more, a full-quality picture may take longer.
    const settles = !this.stale && !this.is_full && !this.moves && performance.now() - this.changed > STILL;
    if (!(this.stale || settles) || this.is_busy()) return false;
    this.stale = false;
    this.set_quality(settles);
    this.orbit.apply(this.camera);
    const share = width / halves.length;
    this.camera.aspect = share / height;
    // Half the width may be too narrow for what the full width showed.
    const needed = halves.length > 1 ? (1.05 * this.orbit.across) / this.camera.aspect : 0;
    this.camera.fov = (360 / Math.PI) * Math.atan(Math.max(Math.tan(FIELD / 2), needed));
    this.camera.updateProjectionMatrix();
    this.renderer.setScissorTest(halves.length > 1);
    halves.forEach((half, k) => {
      for (const group of half.shown) group.visible = true;
      for (const group of half.hidden) group.visible = false;
      this.renderer.setViewport(k * share, 0, share, height);
      this.renderer.setScissor(k * share, 0, share, height);
      this.renderer.render(this.scene, this.camera);
    });
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    this.asked = performance.now();
    return true;
  }

  // Whether the GPU is still drawing the last picture. Issuing draws faster than they complete would block the
  // page.
  private is_busy(): boolean {
    if (!this.fence) return false;
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    // Null, as from a lost context, must not be waited for.
    if (gl.getSyncParameter(this.fence, gl.SYNC_STATUS) === gl.UNSIGNALED) return true;
    gl.deleteSync(this.fence);
    this.fence = null;
    this.spare(performance.now() - this.asked);
    return false;
  }

  // On a machine too slow for motion, drops shadows first, then resolution.
  private spare(milliseconds: number): void {
    if (this.is_settled) return; // a full-quality picture may be slow
    this.late = milliseconds > SLOW ? this.late + 1 : 0;
    if (!this.spares || this.late < MOST_LATE) return;
    this.late = 0;
    const more = spared_more(this.spared, window.devicePixelRatio);
    if (more === this.spared) return;
    this.spared = more;
    this.stale = true;
  }

  // Reads the screen's pixel ratio each time: the page may be zoomed, or moved to another screen.
  private set_quality(settled: boolean): void {
    const spared: Spared = settled ? { shadows: false, ratio: 1 } : this.spared;
    const screen = window.devicePixelRatio;
    const ratio = settled ? screen : Math.min(screen, MOST_RATIO) / spared.ratio;
    if (this.renderer.getPixelRatio() !== ratio) this.renderer.setPixelRatio(ratio);
    if (this.sun.castShadow === spared.shadows) {
      this.renderer.shadowMap.enabled = !spared.shadows;
      this.sun.castShadow = !spared.shadows;
    }
    this.is_full = !spared.shadows && ratio >= screen;
    this.is_settled = settled;
  }
}
