// Dark or light: follows the system until the user chooses.
import { element, say } from "./dom";

export function follow_theme(changed: () => void): void {
  const button = element("theme");
  const light = window.matchMedia("(prefers-color-scheme: light)");
  const set = (name: "dark" | "light") => {
    document.documentElement.dataset.theme = name;
    button.textContent = name === "dark" ? "Light" : "Dark";
    changed();
  };
  set(light.matches ? "light" : "dark");
  light.addEventListener("change", () => set(light.matches ? "light" : "dark"));
  button.addEventListener("click", () => {
    set(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
    say(document.documentElement.dataset.theme === "dark" ? "Dark theme" : "Light theme");
  });
}

export function style_value(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
