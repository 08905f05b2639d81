// A page element by its id; a missing one is a bug.

export function element<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no element "${id}"`);
  return found as T;
}

export function checked(name: string): string {
  return document.querySelector<HTMLInputElement>(`input[name="${name}"]:checked`)?.value ?? "";
}

// Acts as if the user had chosen it.
export function choose(name: string, value: string): void {
  const input = document.querySelector<HTMLInputElement>(`input[name="${name}"][value="${value}"]`);
  if (!input || input.disabled || input.checked) return;
  input.checked = true;
  input.dispatchEvent(new Event("change", { bubbles: true }));
}

export function choose_next(name: string): void {
  const inputs = [...document.querySelectorAll<HTMLInputElement>(`input[name="${name}"]:enabled`)];
  const at = inputs.findIndex((input) => input.checked);
  const next = inputs[(at + 1) % inputs.length];
  if (next) choose(name, next.value);
}

export function toggle(id: string): void {
  element<HTMLInputElement>(id).click();
}

export function add_fact(list: HTMLElement, name: string, value: string): void {
  const row = document.createElement("div");
  const term = document.createElement("dt");
  term.textContent = name;
  const text = document.createElement("dd");
  text.textContent = value;
  row.append(term, text);
  list.append(row);
}

// Announces a change to screen readers.
export function say(text: string): void {
  element("said").textContent = text;
}
