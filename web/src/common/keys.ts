// Keyboard shortcuts: one table, which is also the page's help.

export interface Binding {
  keys: string[]; // as in KeyboardEvent.key, with "Shift+" in front if shift is required
  shown: string; // as shown to the user
  does: string;
  run: () => void;
}

export interface BindingGroup {
  title: string;
  bindings: Binding[];
}

// Keys that a focused control of this kind uses itself.
function is_used_by(target: EventTarget | null, key: string): boolean {
  if (!(target instanceof HTMLElement)) return false;
  const moves = /^(Arrow|Home$|End$|Page)/.test(key);
  if (target instanceof HTMLInputElement) {
    if (target.type === "range") return moves;
    if (target.type === "radio") return moves || key === " ";
    if (target.type === "checkbox") return key === " ";
    return true;
  }
  if (target instanceof HTMLSelectElement) return moves || key === " " || /^[a-z0-9]$/i.test(key);
  if (target instanceof HTMLTextAreaElement) return true;
  if (target instanceof HTMLButtonElement || target.tagName === "SUMMARY") return key === " " || key === "Enter";
  return false;
}

export function name_of_key(event: { key: string; shiftKey: boolean }): string {
  const letter = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  // For non-letters, the character already includes shift.
  const tells_shift = event.key.length > 1 || /[a-z]/.test(letter);
  return (event.shiftKey && tells_shift ? "Shift+" : "") + letter;
}

export function listen_to_keys(groups: BindingGroup[], is_off: () => boolean): void {
  const by_key = new Map<string, Binding>();
  for (const group of groups) for (const binding of group.bindings) for (const key of binding.keys) by_key.set(key, binding);
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || is_off() || is_used_by(event.target, event.key)) return;
    const binding = by_key.get(name_of_key(event));
    if (!binding) return;
    event.preventDefault();
    binding.run();
  });
}

export function fill_help(table: HTMLElement, groups: BindingGroup[]): void {
  for (const group of groups) {
    const section = document.createElement("section");
    const title = document.createElement("h3");
    title.textContent = group.title;
    const list = document.createElement("dl");
    for (const binding of group.bindings) {
      const row = document.createElement("div");
      const key = document.createElement("dt");
      for (const part of binding.shown.split(" ")) {
        const cap = document.createElement("kbd");
        cap.textContent = part;
        key.append(cap, " ");
      }
      const does = document.createElement("dd");
      does.textContent = binding.does;
      row.append(key, does);
      list.append(row);
    }
    section.append(title, list);
    table.append(section);
  }
}
