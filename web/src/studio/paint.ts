// The brush: shows the paint on the skin, and paints strokes.
import { linear_of_hex, write_scale_colour } from "../common/colours";
import type { Colour } from "../common/colours";
import { checked, element, say } from "../common/dom";
import { short_number } from "../common/numbers";
import type { Picture } from "./picture";
import type { PaintMessage } from "./protocol";
import { hit } from "./surface";
import type { Items } from "./wire";

// What the brush needs from the page.
export interface PaintUser {
  command(type: string, members: object): Promise<string>;
  say(text: string, is_bad: boolean): void;
  changed(): void; // the view must be redrawn
}

type Place = [number, number, number];

const WIDTHS: Record<string, number> = { _RIGID: 1, _LAYER: 1, _STIFFNESS: 1, _FIBER: 3 };
const LAYERS = ["#8b8e93", "#ece3c8", "#c4473c", "#e9b949"]; // by depth, bone, muscle, fat
const LAYER_NAMES = ["by depth", "bone", "muscle", "fat"];
const UNPAINTED: Colour = linear_of_hex("#8b8e93");
const RIGID: Colour = linear_of_hex("#3f8fe0");
const LAYER_COLOURS = LAYERS.map(linear_of_hex);
const MOST_PLACES = 256; // per message
const SPACING = 0.25; // fraction of the radius, between two places of a stroke

// Radii from a 500th to a fifth of the body's size, on a logarithmic scale.
export function radius_of(step: number, size: number): number {
  return size * 0.002 * 100 ** (step / 100);
}

// The factor of stiffness. If `most` is above 1: from a tenth to ten times, at most `most`, on a logarithmic
// scale; otherwise a fraction of alpha.
export function stiffness_of(step: number, most: number): number {
  return most > 1 ? Number(Math.min(10 ** (step / 50 - 1), most).toPrecision(2)) : step / 100;
}

// Whether two places of a stroke are far enough apart for the second to be sent.
export function is_apart(a: Place, b: Place, least: number): boolean {
  return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) >= least;
}

// Writes a value's colour to three entries. `most`: of stiffness.
export function write_paint_colour(
  kind: string,
  values: Float32Array | null,
  vertex: number,
  to: Float32Array,
  at: number,
  most = 1,
): void {
  if (kind === "_LAYER") {
    to.set(LAYER_COLOURS[Math.round(values?.[vertex] ?? 0)] ?? UNPAINTED, at);
  } else if (kind === "_RIGID") {
    to.set((values?.[vertex] ?? 0) >= 0.5 ? RIGID : UNPAINTED, at);
  } else if (kind === "_STIFFNESS") {
    const value = values?.[vertex] ?? 1;
    write_scale_colour(most > 1 ? (1 + Math.log10(Math.max(value, 0.01))) / 2 : value, to, at);
  } else {
    // Fibres have no sign: opposite directions have the same colour.
    const length = values ? Math.hypot(values[3 * vertex], values[3 * vertex + 1], values[3 * vertex + 2]) : 0;
    for (let c = 0; c < 3; ++c) to[at + c] = length < 0.1 ? UNPAINTED[c] : 0.06 + (0.8 * Math.abs(values![3 * vertex + c])) / length;
  }
}

export class Painter {
  private message: PaintMessage | null = null;
  private readonly sheets = new Map<string, Float32Array>(); // by attribute name
  private stroke: { number: number; finger: number; last: Place | null; waiting: Place[]; ends: boolean; direction: Place } | null =
    null;
  private strokes = 0;
  private is_sending = false;

  constructor(
    private readonly picture: Picture,
    private readonly user: PaintUser,
  ) {}

  // ---- Messages from the server

  said(message: PaintMessage): void {
    this.message = message;
    for (const name of [...this.sheets.keys()]) if (!message.arrays.includes(`paint.${name}`)) this.sheets.delete(name);
    const tool = document.querySelector<HTMLInputElement>('input[name="tool"][value="paint"]')!;
    tool.disabled = !message.can_paint;
    tool.title = message.why_not;
    if (!message.can_paint && tool.checked)
      document.querySelector<HTMLInputElement>('input[name="tool"][value="turn"]')?.click();
    this.show_controls();
    this.note();
  }

  array(name: string, items: Items): void {
    this.sheets.set(name.slice("paint.".length), items as Float32Array);
    this.note();
  }

  // For tests: the number of vertices painted with the chosen kind.
  private note(): void {
    const { kind } = this.chosen();
    const values = this.sheets.get(kind);
    const neutral = kind === "_STIFFNESS" ? 1 : 0;
    const width = WIDTHS[kind];
    let painted = 0;
    for (let k = 0; values && k < values.length; k += width) {
      let is_painted = false;
      for (let c = 0; c < width; ++c) is_painted ||= values[k + c] !== neutral;
      if (is_painted) ++painted;
    }
    document.documentElement.dataset.painted = String(painted);
    this.user.changed();
  }

  // ---- The user's choice

  private chosen(): { kind: string; value: number } {
    const [kind, value] = element<HTMLSelectElement>("brush-kind").value.split(":");
    const step = Number(element<HTMLInputElement>("brush-value").value);
    return { kind, value: value === undefined ? stiffness_of(step, this.most) : Number(value) };
  }

  // Maximum of painted stiffness.
  private get most(): number {
    return this.message?.attributes.find((one) => one.name === "_STIFFNESS")?.most ?? 1;
  }

  get is_chosen(): boolean {
    return checked("tool") === "paint";
  }
  private get radius(): number {
    return radius_of(Number(element<HTMLInputElement>("brush-radius").value), this.picture.size);
  }

  colour = (vertex: number, to: Float32Array, at: number): void => {
    const { kind } = this.chosen();
    write_paint_colour(kind, this.sheets.get(kind) ?? null, vertex, to, at, this.most);
  };

  // Entries of the legend: a text, and a colour if it has one.
  legend(): [string, string | null][] {
    const { kind } = this.chosen();
    if (kind === "_LAYER") return LAYERS.map((colour, k) => [LAYER_NAMES[k], colour]);
    if (kind === "_RIGID") return [["rigid", "#3f8fe0"], ["unpainted", "#8b8e93"]];
    if (kind === "_STIFFNESS")
      return [[this.most > 1 ? "0.1" : "0", null], ["scale", null], [this.most > 1 ? "10" : "1", null]];
    return [["fibre direction: red x, green y, blue z", null]];
  }

  private show_controls(): void {
    const { kind } = this.chosen();
    const erases = element<HTMLInputElement>("brush-erase").checked;
    const is_shaded = kind === "_STIFFNESS" || kind === "_FIBER";
    element("brush").hidden = !this.is_chosen;
    element("brush-value-row").hidden = kind !== "_STIFFNESS" || erases;
    for (const id of ["brush-strength-row", "brush-falloff-row"]) element(id).hidden = !is_shaded || erases;
    const text = (id: string, value: string) => (element(`${id}-text`).textContent = value);
    const value = stiffness_of(Number(element<HTMLInputElement>("brush-value").value), this.most);
    text("brush-value", this.most > 1 ? `× ${value}` : `${Math.round(100 * value)} %`);
    text("brush-strength", `${element<HTMLInputElement>("brush-strength").value} %`);
    text("brush-radius", `${short_number(1e3 * this.radius)} mm`);
    const why = this.message?.attributes.find((one) => one.name === kind)?.why_not ?? "";
    const note = element("brush-note");
    note.hidden = why === "";
    note.textContent = why;
    element<HTMLButtonElement>("brush-middle").disabled = why !== "";
    if (!this.is_chosen) this.picture.show_brush(null, 0);
  }

  // ---- Strokes

  // The skin visible at a point of the window: its position at rest and now.
  private rest_at(x: number, y: number): { rest: Place; place: Place } | null {
    const { surface, places, rest_of_skin } = this.picture;
    // The skin of the comparison cannot be painted.
    if (!surface || !places || !rest_of_skin || x < this.picture.box_of_played().left) return null;
    const { origin, direction } = this.picture.ray_at(x, y).ray;
    const found = hit(origin.toArray(), direction.toArray(), places, surface);
    if (!found) return null;
    const rest: Place = [0, 0, 0];
    found.corners.forEach((vertex, k) => {
      for (let c = 0; c < 3; ++c) rest[c] += found.weights[k] * rest_of_skin[3 * vertex + c];
    });
    return { rest, place: found.place };
  }

  private begin(rest: Place, finger: number, direction: Place): void {
    // The page may be reloaded, so stroke numbers continue from the time.
    this.strokes = Math.max(this.strokes + 1, Date.now());
    this.stroke = { number: this.strokes, finger, last: rest, waiting: [rest], ends: false, direction };
    this.flush();
  }

  private flush(): void {
    const stroke = this.stroke;
    if (!stroke || this.is_sending || (stroke.waiting.length === 0 && !stroke.ends)) return;
    const places = stroke.waiting.splice(0, MOST_PLACES);
    const is_last = stroke.ends && stroke.waiting.length === 0;
    // The last piece of a stroke needs a place.
    if (places.length === 0 && stroke.last) places.push(stroke.last);
    if (is_last) this.stroke = null;
    const { kind, value } = this.chosen();
    const erase = element<HTMLInputElement>("brush-erase").checked;
    this.is_sending = true;
    this.user
      .command("paint", {
        attribute: kind,
        ...(erase ? { erase } : kind === "_FIBER" ? {} : { value }),
        radius: this.radius,
        strength: Number(element<HTMLInputElement>("brush-strength").value) / 100,
        falloff: element<HTMLSelectElement>("brush-falloff").value,
        mirror: element<HTMLInputElement>("brush-mirror").checked,
        places,
        direction: stroke.direction,
        stroke: stroke.number,
        last: is_last,
      })
      .catch((error: Error) => {
        this.stroke = null;
        this.user.say(error.message, true);
      })
      .finally(() => {
        this.is_sending = false;
        this.flush();
      });
  }

  private move(x: number, y: number): void {
    const found = this.rest_at(x, y);
    this.picture.show_brush(found ? found.place : null, this.radius);
    const stroke = this.stroke;
    if (!stroke || !found) return;
    if (stroke.last && !is_apart(stroke.last, found.rest, SPACING * this.radius)) return;
    stroke.last = found.rest;
    stroke.waiting.push(found.rest);
    this.flush();
  }

  private end(): void {
    if (!this.stroke) return;
    this.stroke.ends = true;
    this.flush();
  }

  // For use without a mouse: one dab at the centre of the view. Fibres then point upwards.
  dab(): void {
    if (!this.is_chosen || this.stroke) return;
    const box = this.picture.box_of_played();
    const found = this.rest_at(box.left + box.width / 2, box.top + box.height / 2);
    if (!found) {
      this.user.say("No skin at the centre of the view", true);
      return;
    }
    this.picture.show_brush(found.place, this.radius);
    this.begin(found.rest, -1, [0, 1, 0]);
    this.end();
    say("Painted");
  }

  resize(by: number): void {
    const range = element<HTMLInputElement>("brush-radius");
    range.value = String(Number(range.value) + by);
    range.dispatchEvent(new Event("input", { bubbles: true }));
  }

  listen(): void {
    const canvas = this.picture.stage.canvas;
    const controls = () => {
      this.show_controls();
      this.note();
    };
    element("tool").addEventListener("change", controls);
    element("brush").addEventListener("input", controls);
    element("brush-middle").addEventListener("click", () => this.dab());
    // Registered before the camera's own listeners.
    canvas.addEventListener(
      "pointerdown",
      (event) => {
        if (!this.is_chosen || this.stroke || event.button !== 0 || event.shiftKey) return;
        const found = this.rest_at(event.clientX, event.clientY);
        if (!found) return;
        canvas.setPointerCapture(event.pointerId);
        event.stopImmediatePropagation();
        this.begin(found.rest, event.pointerId, [0, 0, 0]);
      },
      { capture: true },
    );
    canvas.addEventListener("pointermove", (event) => {
      if (this.is_chosen && (!this.stroke || this.stroke.finger === event.pointerId))
        this.move(event.clientX, event.clientY);
    });
    canvas.addEventListener("pointerleave", () => this.picture.show_brush(null, 0));
    for (const end of ["pointerup", "pointercancel"] as const)
      canvas.addEventListener(end, (event) => {
        if (this.stroke?.finger === event.pointerId) this.end();
      });
    this.show_controls();
  }
}
