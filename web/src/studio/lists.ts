// The lists of presets and warnings, and the viewport's legend.
import { SCALE } from "../common/colours";
import { element } from "../common/dom";
import type { ShownColour } from "./picture";
import type { BodyMessage, Preset, SceneWarning } from "./protocol";

type Layer = BodyMessage["layers"][number];

export function list_presets(presets: Preset[], choose: (name: string) => void): void {
  const list = element("presets");
  list.replaceChildren();
  for (const preset of presets) {
    const button = document.createElement("button");
    button.type = "button";
    button.dataset.preset = preset.name;
    button.disabled = preset.why_not !== undefined || Object.keys(preset.changes).length === 0;
    const title = document.createElement("strong");
    title.textContent = preset.title;
    const doc = document.createElement("small");
    doc.textContent = preset.why_not ?? preset.doc;
    const changes = document.createElement("small");
    changes.textContent = Object.entries(preset.changes)
      .map(([path, value]) => `${path} = ${Array.isArray(value) ? value.join(", ") : value}`)
      .join("; ");
    button.append(title, doc, changes);
    button.addEventListener("click", () => choose(preset.name));
    const item = document.createElement("li");
    item.append(button);
    list.append(item);
  }
}

// `point` is called with the rest position and the number of a vertex that the warning is about.
export function list_warnings(
  warnings: SceneWarning[],
  point: (place: [number, number, number], vertex: number | undefined) => void,
): void {
  const list = element("warning-list");
  list.replaceChildren();
  element("warnings-tab").textContent = warnings.length > 0 ? `Warnings ${warnings.length}` : "Warnings";
  if (warnings.length === 0) {
    const item = document.createElement("li");
    item.textContent = "No warnings.";
    list.append(item);
  }
  for (const warning of warnings) {
    const item = document.createElement("li");
    const has_place = warning.places.length > 0;
    const line = document.createElement(has_place ? "button" : "p");
    line.textContent = warning.text;
    if (line instanceof HTMLButtonElement) {
      line.type = "button";
      let next = 0;
      line.addEventListener("click", () => {
        const place = warning.places[next % warning.places.length];
        const vertex = warning.vertices[next % Math.max(warning.vertices.length, 1)];
        ++next;
        point(place, vertex);
      });
    }
    item.append(line);
    list.append(item);
  }
}

// `paint`: the entries if paint is shown.
export function show_legend(
  colour: ShownColour,
  millimetres: string,
  layers: Layer[],
  paint: [string, string | null][],
): void {
  const legend = element("legend");
  legend.replaceChildren();
  legend.hidden = colour === "materials" || colour === "muscles";
  const entry = (text: string, sign: HTMLElement | null) => {
    const item = document.createElement("span");
    if (sign) item.append(sign);
    item.append(text);
    legend.append(item);
  };
  const swatch_of = (background: string) => {
    const swatch = document.createElement("i");
    swatch.className = "swatch";
    swatch.style.background = background;
    return swatch;
  };
  const scale_of = () => {
    const scale = document.createElement("i");
    scale.className = "scale";
    scale.style.background = `linear-gradient(to right, ${SCALE.join(", ")})`;
    return scale;
  };
  if (colour === "layers") {
    for (const layer of layers) entry(layer.name, swatch_of(layer.colour));
  } else if (colour === "paint") {
    for (const [text, background] of paint) {
      if (text === "scale") legend.append(scale_of());
      else entry(text, background === null ? null : swatch_of(background));
    }
  } else if (colour === "lag" || colour === "difference" || colour === "contact") {
    entry("0", null);
    legend.append(scale_of());
    entry(colour === "contact" ? "20 mm" : millimetres, null);
  }
}
