// Texts on the page: the title, the status, and notices that disappear.
import { element } from "../common/dom";
import type { Hello, History } from "./protocol";

const STAYS = 4500; // ms

export class Notices {
  private until = 0;

  set_status(text: string, state: string): void {
    const status = element("status");
    if (status.textContent !== text) status.textContent = text;
    status.title = text; // the visible text may be cut off
    status.dataset.state = state;
  }

  toast(text: string, is_bad = false): void {
    if (!text) return;
    const toast = element("toast");
    toast.textContent = text;
    toast.dataset.bad = String(is_bad);
    toast.hidden = false;
    this.until = performance.now() + (is_bad ? 2 : 1) * STAYS;
  }

  tick(): void {
    if (this.until === 0 || performance.now() <= this.until) return;
    element("toast").hidden = true;
    this.until = 0;
  }
}

// Shows an error that stays.
export function fail(text: string): void {
  const failure = element("failure");
  failure.hidden = false;
  failure.textContent = text;
  document.documentElement.dataset.state = "failed";
}

export function show_device(device: string): void {
  element("subtitle").textContent = device;
}

// Shows the scene's name, and enables the controls that apply to it.
export function show_hello(hello: Hello): void {
  element("title").textContent = hello.name;
  document.title = `${hello.name} – fascicle studio`;
  show_device(hello.device);
  const note = element("why-not");
  note.hidden = hello.can_touch;
  note.textContent = hello.why_not ?? "";
  element("find").parentElement!.hidden = !hello.can_touch;
  for (const id of ["save", "bake", "record"]) element<HTMLButtonElement>(id).disabled = !hello.can_touch;
  for (const input of document.querySelectorAll<HTMLInputElement>('input[name="tool"]'))
    input.disabled = !hello.can_touch || ["paint", "bones"].includes(input.value);
}

export function show_history(history: History): void {
  for (const [id, title, label] of [["undo", "Undo", history.undo], ["redo", "Redo", history.redo]] as const) {
    const button = element<HTMLButtonElement>(id);
    button.disabled = label === null;
    button.title = label === null ? "" : `${title}: ${label}`;
  }
  element("save").textContent = history.saved ? "Saved" : "Save";
}
