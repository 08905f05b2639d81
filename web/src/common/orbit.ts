// An orbit camera, controlled by mouse, touch and keys.
import type { PerspectiveCamera } from "three";
import { Vector3 } from "three";

const MOST_ELEVATION = 1.553; // just below straight up

export interface View {
  azimuth: number; // rad, about the vertical; 0 looks from +z
  elevation: number;
}
export const VIEWS: Record<string, View> = {
  "three-quarter": { azimuth: 0.6, elevation: 0.2 },
  front: { azimuth: 0, elevation: 0.05 },
  side: { azimuth: Math.PI / 2, elevation: 0.05 },
  back: { azimuth: Math.PI, elevation: 0.05 },
};

const MARGIN = 1.1;

// Directions right, up and towards the camera.
function axes_of({ azimuth, elevation }: View): [number[], number[], number[]] {
  const [sine, cosine] = [Math.sin(azimuth), Math.cos(azimuth)];
  const [high, flat] = [Math.sin(elevation), Math.cos(elevation)];
  return [
    [cosine, 0, -sine],
    [-high * sine, flat, -high * cosine],
    [flat * sine, high, flat * cosine],
  ];
}

export class Orbit {
  azimuth = VIEWS["three-quarter"].azimuth;
  elevation = VIEWS["three-quarter"].elevation;
  distance = 5;
  readonly target = new Vector3();
  readonly carried = new Vector3(); // offset of a body that the camera follows
  private home = { distance: 5, target: new Vector3() };
  // The tangent that the framed points need on either side of the middle, over all views at the home distance.
  across = 0;
  private readonly fingers = new Map<number, { x: number; y: number }>();

  constructor(private readonly changed: () => void) {}

  // Moves as close as possible with all points (3 numbers each, relative to `middle`) visible in every view.
  // `field`: vertical angle of view, rad.
  frame(middle: Vector3, points: ArrayLike<number>, field: number, aspect: number): void {
    const up_tangent = Math.tan(field / 2) / MARGIN;
    const across_tangent = up_tangent * aspect;
    const seen = Object.values(VIEWS).map((view) => axes_of(view));
    const each = (use: (across: number, up: number, near: number) => void) => {
      for (let k = 0; k + 2 < points.length; k += 3)
        for (const [right, up, back] of seen)
          use(
            Math.abs(points[k] * right[0] + points[k + 2] * right[2]),
            Math.abs(points[k] * up[0] + points[k + 1] * up[1] + points[k + 2] * up[2]),
            points[k] * back[0] + points[k + 1] * back[1] + points[k + 2] * back[2],
          );
    };
    let distance = 1e-6;
    each((across, up, near) => {
      distance = Math.max(distance, near + across / across_tangent, near + up / up_tangent);
    });
    this.across = 0;
    each((across, _, near) => (this.across = Math.max(this.across, across / (distance - near))));
    this.home = { distance, target: middle.clone() };
    this.reset();
  }

  reset(): void {
    this.distance = this.home.distance;
    this.target.copy(this.home.target);
    this.look(VIEWS["three-quarter"]);
  }

  look(view: View): void {
    this.azimuth = view.azimuth;
    this.elevation = view.elevation;
    this.changed();
  }

  // Moves close to a place, keeping the direction.
  go_to(place: Vector3, distance: number): void {
    this.target.copy(place).sub(this.carried);
    this.distance = distance;
    this.changed();
  }

  turn(across: number, up: number): void {
    this.azimuth -= across;
    this.elevation = Math.min(Math.max(this.elevation + up, -MOST_ELEVATION), MOST_ELEVATION);
    this.changed();
  }

  // Both in fractions of the picture's height.
  pan(across: number, up: number): void {
    const sine = Math.sin(this.azimuth);
    const cosine = Math.cos(this.azimuth);
    const step = 0.63 * this.distance;
    this.target.x -= step * (across * cosine + up * sine * Math.sin(this.elevation));
    this.target.z -= step * (-across * sine + up * cosine * Math.sin(this.elevation));
    this.target.y += step * up * Math.cos(this.elevation);
    this.changed();
  }

  zoom(factor: number): void {
    this.distance = Math.min(Math.max(this.distance / factor, this.home.distance / 40), this.home.distance * 8);
    this.changed();
  }

  apply(camera: PerspectiveCamera): void {
    const flat = Math.cos(this.elevation);
    const middle = new Vector3().addVectors(this.target, this.carried);
    camera.position.set(
      middle.x + this.distance * flat * Math.sin(this.azimuth),
      middle.y + this.distance * Math.sin(this.elevation),
      middle.z + this.distance * flat * Math.cos(this.azimuth),
    );
    camera.lookAt(middle);
    camera.near = this.distance / 100;
    camera.far = this.distance + 12 * this.home.distance;
    camera.updateProjectionMatrix();
  }

  // Left button: orbit; right or middle button, or shift: pan; wheel: zoom. Two fingers pan and zoom.
  listen(element: HTMLElement): void {
    element.addEventListener("contextmenu", (event) => event.preventDefault());
    element.addEventListener("dblclick", () => this.reset());
    element.addEventListener("pointerdown", (event) => {
      element.setPointerCapture(event.pointerId);
      this.fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    });
    const lift = (event: PointerEvent) => this.fingers.delete(event.pointerId);
    element.addEventListener("pointerup", lift);
    element.addEventListener("pointercancel", lift);
    element.addEventListener("pointermove", (event) => {
      const was = this.fingers.get(event.pointerId);
      if (!was) return;
      const height = element.clientHeight || 1;
      const across = (event.clientX - was.x) / height;
      const down = (event.clientY - was.y) / height;
      if (this.fingers.size === 2) {
        const other = [...this.fingers].find(([id]) => id !== event.pointerId)![1];
        const gap = (x: number, y: number) => Math.hypot(x - other.x, y - other.y) || 1;
        this.zoom(gap(event.clientX, event.clientY) / gap(was.x, was.y));
        this.pan(across / 2, down / 2);
      } else if (event.buttons & 6 || event.shiftKey) {
        this.pan(across, down);
      } else {
        this.turn(4 * across, 4 * down);
      }
      was.x = event.clientX;
      was.y = event.clientY;
    });
    element.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        this.zoom(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015)));
      },
      { passive: false },
    );
  }
}
