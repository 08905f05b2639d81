// The hand tool: grabs the flesh under the pointer, pulls it and lets go.
import { Vector3 } from "three";
import { checked } from "../common/dom";
import type { Picture } from "./picture";
import { hit } from "./surface";

// What the hand needs from the page.
export interface HandUser {
  can_touch(): boolean;
  draws_model(): boolean; // whether the model's own vertices are drawn
  send(type: string, members: object): void;
  command(type: string, members: object): Promise<string>;
  say(text: string, is_bad: boolean): void;
}

export class Hand {
  private grip: { place: Vector3; finger: number } | null = null;

  constructor(
    private readonly picture: Picture,
    private readonly user: HandUser,
  ) {}

  // True if there is flesh to grab.
  private grab(x: number, y: number, finger: number): boolean {
    const { surface, places } = this.picture;
    // The flesh of the comparison cannot be grabbed.
    if (!surface || !places || x < this.picture.box_of_played().left) return false;
    const { origin, direction } = this.picture.ray_at(x, y).ray;
    const found = hit(origin.toArray(), direction.toArray(), places, surface);
    if (!found) return false;
    this.grip = { place: new Vector3(...found.place), finger };
    const is_model = this.user.draws_model();
    this.user.send("hand", {
      action: "grab",
      vertex: found.vertex,
      radius: 0,
      place: found.place,
      ...(is_model ? { of: "vertices" } : {}),
    });
    this.picture.show_grip(found.place);
    return true;
  }

  private drag(x: number, y: number): void {
    if (!this.grip) return;
    const ray = this.picture.ray_at(x, y).ray;
    const normal = this.picture.stage.camera.getWorldDirection(new Vector3());
    const along = normal.dot(ray.direction);
    if (Math.abs(along) < 1e-6) return;
    const distance = normal.dot(this.grip.place.clone().sub(ray.origin)) / along;
    const place = ray.origin.clone().addScaledVector(ray.direction, distance);
    this.user.command("hand", { action: "move", place: place.toArray() }).catch(() => this.drop());
    this.picture.show_grip(place.toArray() as [number, number, number]);
  }

  drop(): void {
    this.grip = null;
    this.picture.show_grip(null);
  }

  private release(): void {
    if (!this.grip) return;
    this.drop();
    this.user.send("hand", { action: "release" });
  }

  // For use without a mouse: grabs the flesh at the centre of the view, pulls it towards the camera and lets go.
  tug(): void {
    const box = this.picture.box_of_played();
    const [x, y] = [box.left + box.width / 2, box.top + box.height / 2];
    if (!this.grab(x, y, -1)) {
      this.user.say("No flesh at the centre of the view", true);
      return;
    }
    const ahead = this.picture.stage.camera.getWorldDirection(new Vector3());
    const towards = ahead.multiplyScalar(-0.12 * this.picture.size);
    const place = this.grip!.place.clone().add(towards);
    this.user.send("hand", { action: "move", place: place.toArray() });
    setTimeout(() => this.release(), 450);
  }

  listen(): void {
    const canvas = this.picture.stage.canvas;
    // Registered before the camera's own listeners.
    canvas.addEventListener(
      "pointerdown",
      (event) => {
        if (checked("tool") !== "pull" || event.button !== 0 || event.shiftKey || !this.user.can_touch()) return;
        if (!this.grab(event.clientX, event.clientY, event.pointerId)) return;
        canvas.setPointerCapture(event.pointerId);
        event.stopImmediatePropagation();
      },
      { capture: true },
    );
    canvas.addEventListener("pointermove", (event) => {
      if (this.grip?.finger === event.pointerId) this.drag(event.clientX, event.clientY);
    });
    for (const end of ["pointerup", "pointercancel"] as const)
      canvas.addEventListener(end, (event) => {
        if (this.grip?.finger === event.pointerId) this.release();
      });
  }
}
