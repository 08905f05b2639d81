// The scene's keys as controls: one row each, created once and updated with every revision.
import type { KeyGroup, KeyValue, SceneKey } from "./protocol";
import { range_of, step_of, STEPS, value_of } from "./slider";

export type Change = (path: string, value: KeyValue, gesture: number | null) => void;

// Shows the current value; skips a control in use unless by force.
type Fill = (key: SceneKey, by_force: boolean) => void;

interface Row {
  key: SceneKey;
  element: HTMLElement;
  fill: Fill;
}

// Whether a key is shown without a search: keys with a slider, keys that the scene sets, gravity and wind. Of
// equivalent keys, such as those for a layer's stiffness, only the one that the scene uses is shown.
export function is_near(key: SceneKey, is_set: (path: string) => boolean): boolean {
  if (key.kind === "other" || key.kind === "texts" || key.why_unused) return false;
  if (!key.is_set && key.rivals?.some(is_set)) return false;
  return key.is_set || key.soft_minimum !== undefined || /gravity|wind/.test(key.path);
}

function shown_value(key: SceneKey): KeyValue {
  return key.value ?? (typeof key.fallback === "object" || key.kind !== "text" ? (key.fallback as KeyValue) : key.fallback);
}

// Most often changed first.
const FIRST = ["flesh", "layers", "muscle", "force", "collider", "scene", "contact", "solver", "motion"];

function place_of(group: KeyGroup): number {
  const at = FIRST.indexOf(group.path.split(".")[0] || "scene");
  return at < 0 ? FIRST.length : at;
}

// "layers.fat.where" as "Layer fat, where".
export function title_of(group: KeyGroup): string {
  const [table, name, ...rest] = (group.title || "scene").replaceAll("_", " ").split(".");
  const word = table === "layers" ? "layer" : table;
  const title = name === undefined ? word : `${word} ${name}${rest.length > 0 ? `, ${rest.join(" ")}` : ""}`;
  return title.charAt(0).toUpperCase() + title.slice(1);
}

const ECHO = 700; // ms after a change during which the server's values do not update the control
let gestures = 0;

export class TouchPanel {
  private readonly rows = new Map<string, Row>();
  private shape = "";
  private groups: KeyGroup[] = [];

  constructor(
    private readonly home: HTMLElement,
    private readonly find: HTMLInputElement,
    private readonly change: Change,
    private readonly nothing: HTMLElement, // shown if no key matches
  ) {
    find.addEventListener("input", () => this.filter());
  }

  fill(groups: KeyGroup[]): void {
    this.groups = groups
      .map((group, k) => ({ group, k }))
      .sort((a, b) => place_of(a.group) - place_of(b.group) || a.k - b.k)
      .map(({ group }) => group);
    const shape = groups
      .map((group) => `${group.path}:${group.keys.map((key) => `${key.path}/${key.kind}`).join()}`)
      .join(";");
    if (shape !== this.shape) {
      this.shape = shape;
      this.build();
    }
    for (const group of groups) for (const key of group.keys) this.rows.get(key.path)?.fill(key, false);
    this.filter();
  }

  // After a refused change: shows the current values, even in a control in use.
  restore(): void {
    for (const group of this.groups) for (const key of group.keys) this.rows.get(key.path)?.fill(key, true);
  }

  private build(): void {
    const open = new Set([...this.home.querySelectorAll("details[open]")].map((one) => (one as HTMLElement).dataset.path));
    const is_first = this.rows.size === 0;
    this.rows.clear();
    this.home.replaceChildren();
    for (const group of this.groups) {
      const details = document.createElement("details");
      details.dataset.path = group.path;
      details.open = is_first ? /^(flesh|layers\.)/.test(group.path) : open.has(group.path);
      const summary = document.createElement("summary");
      summary.textContent = title_of(group);
      summary.title = group.doc;
      details.append(summary);
      for (const key of group.keys) {
        const row = this.row_of(key);
        this.rows.set(key.path, row);
        details.append(row.element);
      }
      this.home.append(details);
    }
  }

  private filter(): void {
    const set = new Set(this.groups.flatMap((group) => group.keys.filter((key) => key.is_set).map((key) => key.path)));
    const words = this.find.value.trim().toLowerCase().split(/\s+/).filter((word) => word);
    let all = 0;
    for (const details of this.home.querySelectorAll("details")) {
      let shown = 0;
      const group = this.groups.find((one) => one.path === details.dataset.path);
      for (const key of group?.keys ?? []) {
        const row = this.rows.get(key.path)!;
        const text = `${key.path} ${key.doc} ${group!.title}`.toLowerCase();
        const is_shown = words.length > 0 ? words.every((word) => text.includes(word)) : is_near(key, (path) => set.has(path));
        row.element.hidden = !is_shown;
        if (is_shown) ++shown;
      }
      details.hidden = shown === 0;
      if (words.length > 0 && shown > 0) details.open = true;
      all += shown;
    }
    this.nothing.hidden = all > 0;
  }

  private row_of(key: SceneKey): Row {
    const element = document.createElement("div");
    element.className = "key";
    const id = `key-${key.path.replaceAll(/[^A-Za-z0-9_]/g, "-")}`;
    const many = key.kind === "vector";
    const name = document.createElement(many ? "span" : "label");
    name.className = "name";
    name.textContent = key.name.replaceAll("_", " ");
    name.title = `${key.path}: ${key.doc}`;
    if (name instanceof HTMLLabelElement) name.htmlFor = id;
    if (key.effect === "rebuild") {
      const builds = document.createElement("span");
      builds.className = "builds";
      builds.textContent = " · rebuilds";
      name.append(builds);
    }
    const reset = document.createElement("button");
    reset.type = "button";
    reset.className = "undo";
    reset.textContent = "×";
    reset.title = `Reset ${key.path} to default`;
    reset.setAttribute("aria-label", reset.title);
    reset.addEventListener("click", () => this.change(key.path, null, null));
    const fill_value = this.control(element, name, key, id);
    element.append(reset);
    const slider = element.querySelector<HTMLInputElement>('input[type="range"]');
    if (slider) element.append(slider);
    const unused = document.createElement("p");
    unused.className = "unused";
    element.append(unused);
    return {
      key,
      element,
      fill: (now, by_force) => {
        element.classList.toggle("is-set", now.is_set);
        reset.style.visibility = now.is_set ? "visible" : "hidden";
        fill_value(now, by_force);
        // A key found by its name is shown, with the reason why it cannot be set.
        for (const control of element.querySelectorAll<HTMLInputElement | HTMLSelectElement>("input, select"))
          control.disabled = now.why_unused !== undefined;
        unused.hidden = now.why_unused === undefined;
        unused.textContent = now.why_unused ?? "";
      },
    };
  }

  // Adds the control for a key's kind; returns the function that fills it.
  private control(element: HTMLElement, name: HTMLElement, key: SceneKey, id: string): Fill {
    const value = document.createElement("span");
    value.className = "value";
    element.append(name, value);
    if (key.kind === "boolean") {
      const box = document.createElement("input");
      box.type = "checkbox";
      box.id = id;
      box.addEventListener("change", () => this.change(key.path, box.checked, null));
      value.append(box);
      return (now) => (box.checked = shown_value(now) === true);
    }
    if (key.allowed && key.kind === "text") {
      const list = document.createElement("select");
      list.id = id;
      for (const word of key.allowed) list.add(new Option(word, word));
      list.addEventListener("change", () => this.change(key.path, list.value, null));
      value.append(list);
      return (now) => (list.value = String(shown_value(now) ?? ""));
    }
    if (key.kind === "number" || key.kind === "integer") return this.number_control(element, value, key, id);
    if (key.kind === "vector") {
      value.classList.add("three");
      const inputs = ["x", "y", "z"].map((axis) => {
        const input = document.createElement("input");
        input.type = "number";
        input.step = "any";
        input.setAttribute("aria-label", `${key.name.replaceAll("_", " ")} ${axis}`);
        value.append(input);
        return input;
      });
      const send = () => {
        const numbers = inputs.map((input) => Number(input.value));
        if (inputs.every((input) => input.value !== "") && numbers.every(Number.isFinite)) this.change(key.path, numbers, null);
      };
      for (const input of inputs) input.addEventListener("change", send);
      return (now, by_force) => {
        const numbers = shown_value(now);
        inputs.forEach((input, k) => {
          if (by_force || document.activeElement !== input) input.value = Array.isArray(numbers) ? String(numbers[k] ?? "") : "";
        });
      };
    }
    const input = document.createElement("input");
    input.type = "text";
    input.id = id;
    const is_list = key.kind === "texts";
    input.addEventListener("change", () => {
      const words = input.value.split(",").map((word) => word.trim()).filter((word) => word);
      this.change(key.path, is_list ? words : input.value, null);
    });
    value.append(input);
    return (now, by_force) => {
      const shown = shown_value(now);
      if (by_force || document.activeElement !== input) input.value = Array.isArray(shown) ? shown.join(", ") : String(shown ?? "");
    };
  }

  private number_control(
    element: HTMLElement,
    value: HTMLElement,
    key: SceneKey,
    id: string,
  ): Fill {
    const input = document.createElement("input");
    input.type = "number";
    input.id = id;
    input.step = key.kind === "integer" ? "1" : "any";
    if (key.minimum !== undefined) input.min = String(key.minimum);
    if (key.maximum !== undefined) input.max = String(key.maximum);
    const unit = document.createElement("span");
    unit.className = "unit";
    unit.textContent = key.unit ?? "";
    value.append(input, unit);
    input.addEventListener("change", () => {
      if (input.value !== "" && Number.isFinite(Number(input.value))) this.change(key.path, Number(input.value), null);
      else this.restore();
    });
    const range = range_of(key);
    let slider: HTMLInputElement | null = null;
    // Values echoed by the server are older than what the user is choosing.
    let chosen_at = -Infinity;
    const is_busy = () => performance.now() - chosen_at < ECHO;
    if (range && key.kind === "number") {
      slider = document.createElement("input");
      slider.type = "range";
      slider.min = "0";
      slider.max = String(STEPS);
      slider.setAttribute("aria-label", `${key.path} slider`);
      const own = slider;
      let gesture = 0;
      own.addEventListener("pointerdown", () => (gesture = ++gestures));
      own.addEventListener("keydown", () => (gesture ||= ++gestures));
      own.addEventListener("input", () => {
        chosen_at = performance.now();
        const chosen = value_of(Number(own.value), range);
        input.value = String(chosen);
        this.change(key.path, chosen, gesture || (gesture = ++gestures));
      });
      own.addEventListener("pointerup", () => (gesture = 0));
      own.addEventListener("blur", () => (gesture = 0));
      element.append(own);
    }
    return (now, by_force) => {
      const shown = shown_value(now);
      const number = typeof shown === "number" ? shown : null;
      if (by_force || (document.activeElement !== input && !is_busy())) {
        input.value = number === null ? "" : String(number);
        input.placeholder = number === null ? "auto" : "";
      }
      if (slider && range && (by_force || !is_busy())) {
        slider.value = String(number === null ? STEPS / 2 : step_of(number, range));
        slider.setAttribute("aria-valuetext", number === null ? "auto" : `${number} ${now.unit ?? ""}`.trim());
      }
    };
  }
}
