// Chooses which joints are bones, by a click on the skeleton or in a list.
import { Vector3 } from "three";
import { checked, element } from "../common/dom";
import type { Picture } from "./picture";
import type { BodyMessage, KeyGroup, KeyValue } from "./protocol";

// What this needs from the page.
export interface BonesUser {
  command(type: string, members: object): Promise<string>;
  say(text: string, is_bad: boolean): void;
  joints(): Float32Array | null; // their current positions, 3 numbers each
}

type Joint = BodyMessage["joints"][number];

const CHOSEN = "skeleton.bones";
const UNCHOSEN = "skeleton.not_bones";
const REACH = 18; // pixels

function without(names: readonly string[], name: string): KeyValue {
  const left = names.filter((one) => one !== name);
  return left.length > 0 ? left : null;
}

// The changes that toggle whether a joint is a bone. `names`: the keys' current values.
export function changes_for(
  joint: Pick<Joint, "name" | "is_bone">,
  names: { chosen: readonly string[]; unchosen: readonly string[] },
): Record<string, KeyValue> {
  const { chosen, unchosen } = names;
  const changes: Record<string, KeyValue> = {};
  if (joint.is_bone) {
    if (chosen.includes(joint.name)) changes[CHOSEN] = without(chosen, joint.name);
    changes[UNCHOSEN] = [...unchosen.filter((one) => one !== joint.name), joint.name];
  } else {
    if (unchosen.includes(joint.name)) changes[UNCHOSEN] = without(unchosen, joint.name);
    changes[CHOSEN] = [...chosen.filter((one) => one !== joint.name), joint.name];
  }
  return changes;
}

// The number of the place nearest to a point, within reach; -1 if there is none.
export function nearest_of(
  places: readonly (readonly [number, number])[],
  x: number,
  y: number,
  reach: number,
): number {
  let best = -1;
  let least = reach;
  places.forEach(([px, py], k) => {
    const distance = Math.hypot(px - x, py - y);
    if (distance > least) return;
    least = distance;
    best = k;
  });
  return best;
}

export class Bones {
  private joints: Joint[] = [];
  private names = { chosen: [] as string[], unchosen: [] as string[] };

  constructor(
    private readonly picture: Picture,
    private readonly user: BonesUser,
  ) {}

  get is_chosen(): boolean {
    return checked("tool") === "bones";
  }

  set_body(body: BodyMessage, can_touch: boolean): void {
    this.joints = body.joints;
    const tool = document.querySelector<HTMLInputElement>('input[name="tool"][value="bones"]')!;
    tool.disabled = !can_touch || body.joints.length === 0;
    const list = element<HTMLSelectElement>("bone-joint");
    const was = list.selectedIndex;
    list.replaceChildren(
      ...body.joints.map((joint) => new Option(`${joint.is_bone ? "● " : ""}${joint.name}`, joint.name)),
    );
    if (was >= 0 && was < list.options.length) list.selectedIndex = was;
    this.show();
  }

  set_keys(groups: KeyGroup[]): void {
    const names_of = (path: string) => {
      const value = groups.flatMap((group) => group.keys).find((key) => key.path === path)?.value;
      return Array.isArray(value) ? value.map(String) : [];
    };
    this.names = { chosen: names_of(CHOSEN), unchosen: names_of(UNCHOSEN) };
  }

  private show(): void {
    element("bones").hidden = !this.is_chosen;
    const joint = this.joints[element<HTMLSelectElement>("bone-joint").selectedIndex];
    element("bone-why").textContent = joint ? (joint.reason ?? "not a bone") : "";
    element("bone-turn").textContent = joint?.is_bone ? "Don't use as bone" : "Use as bone";
    this.mark();
  }

  // Marks the chosen joint.
  mark(): void {
    const at = 3 * element<HTMLSelectElement>("bone-joint").selectedIndex;
    const places = this.user.joints();
    const is_there = this.is_chosen && places !== null && at >= 0 && at + 2 < places.length;
    this.picture.show_joint(is_there ? [places[at], places[at + 1], places[at + 2]] : null);
  }

  private turn(): void {
    const joint = this.joints[element<HTMLSelectElement>("bone-joint").selectedIndex];
    if (!joint) return;
    const label = `${joint.is_bone ? "don't use" : "use"} ${joint.name} as bone`;
    this.user.command("set", { changes: changes_for(joint, this.names), label }).then(
      (text) => this.user.say(text, false),
      (error: Error) => this.user.say(error.message, true),
    );
  }

  // The joint drawn at a point of the window; -1 if there is none.
  private joint_at(x: number, y: number): number {
    const places = this.user.joints();
    const box = this.picture.box_of_played();
    // Joints of the comparison cannot be chosen.
    if (!places || x < box.left) return -1;
    const { camera, orbit } = this.picture.stage;
    orbit.apply(camera);
    camera.updateMatrixWorld();
    const seen = this.joints.map((_, k): [number, number] => {
      const p = new Vector3(places[3 * k], places[3 * k + 1], places[3 * k + 2]).project(camera);
      return [box.left + (0.5 + 0.5 * p.x) * box.width, box.top + (0.5 - 0.5 * p.y) * box.height];
    });
    return nearest_of(seen, x, y, REACH);
  }

  listen(): void {
    const list = element<HTMLSelectElement>("bone-joint");
    element("tool").addEventListener("change", () => this.show());
    list.addEventListener("change", () => this.show());
    element("bone-turn").addEventListener("click", () => this.turn());
    this.picture.stage.canvas.addEventListener(
      "pointerdown",
      (event) => {
        if (!this.is_chosen || event.button !== 0 || event.shiftKey) return;
        const joint = this.joint_at(event.clientX, event.clientY);
        if (joint < 0) return;
        event.stopImmediatePropagation();
        list.selectedIndex = joint;
        this.show();
        this.turn();
      },
      { capture: true },
    );
    this.show();
  }
}
