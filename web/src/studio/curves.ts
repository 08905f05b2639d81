// Curves along the clip that grow while it plays: a value of each frame, of the last time that it was computed.
import { CurvePlot, value_text } from "../common/curves";
import type { Lane } from "../common/curves";
import { element } from "../common/dom";
import type { Curve } from "../common/film";
import type { FrameMessage } from "./wire";

const MEANINGS: Record<string, string> = {
  lag: "Root mean square distance of all free flesh from where skinning alone would have it",
  energy: "Kinetic energy of the body",
  volume: "Volume of the body over that at rest",
  "real time": "How many times as fast as the clip the solver can go",
};

export class LiveCurves {
  private plot: CurvePlot | null = null;
  private curves: Curve[] = [];
  private lanes: Lane[] = [];
  private frame = 0; // that is shown

  constructor(private readonly seek: (frame: number) => void) {}

  // A clip of so many frames, none of which has come.
  begin(count: number): void {
    const curve = (name: string, unit: string): Curve => ({ name, unit, limit: null, values: new Array(count).fill(null) });
    this.curves = [
      curve("lag", "mm"),
      curve("energy", "J"),
      curve("volume", "%"),
      { ...curve("real time", "×"), limit: 1 },
    ];
    this.lanes = this.curves.map((one, k) => ({ curve: one, colour: `--curve-${k}` }));
    this.list();
    if (!this.plot) this.plot = new CurvePlot(element<HTMLCanvasElement>("plot"), count, (frame) => this.seek(frame));
    else this.plot.frames = count;
  }

  // All frames are to come again.
  clear(): void {
    for (const curve of this.curves) curve.values.fill(null);
  }

  // `fps`: of the clip.
  note(frame: FrameMessage, fps: number): void {
    if (frame.frame >= (this.curves[0]?.values.length ?? 0)) return;
    const values = [1e3 * frame.lag, frame.energy, 100 * frame.volume, frame.rate / fps];
    values.forEach((value, k) => (this.curves[k].values[frame.frame] = Number.isFinite(value) ? value : null));
  }

  draw(frame: number): void {
    this.frame = frame;
    if (!this.plot) return;
    this.plot.draw(this.lanes, frame);
    const values = element("curve-list").querySelectorAll("output");
    this.curves.forEach((curve, k) => {
      if (values[k]) values[k].textContent = value_text(curve, frame);
    });
  }

  private list(): void {
    const list = element("curve-list");
    list.replaceChildren();
    for (const lane of this.lanes) {
      const label = document.createElement("label");
      label.title = MEANINGS[lane.curve.name];
      const box = document.createElement("input");
      box.type = "checkbox";
      box.checked = true;
      const line = document.createElement("span");
      line.className = "line";
      line.style.background = `var(${lane.colour})`;
      const name = document.createElement("span");
      name.textContent = lane.curve.name;
      const value = document.createElement("output");
      label.append(box, line, name, value);
      const item = document.createElement("li");
      item.append(label);
      list.append(item);
      box.addEventListener("change", () => {
        this.lanes = this.lanes.filter((one) => one !== lane);
        if (box.checked) this.lanes.push(lane);
        this.draw(this.frame);
      });
    }
  }
}
