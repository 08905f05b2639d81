// Curves along the clip that fill in while it plays, with the last value computed for each frame, and the curves of
// the comparison bake.
import { CurvePlot, range_of, value_text } from "../common/curves";
import type { Axis, Lane, Line } from "../common/curves";
import { element } from "../common/dom";
import type { Curve } from "../common/film";
import { short_number } from "../common/numbers";
import type { FrameMessage } from "./wire";

interface Meaning {
  name: string;
  unit: string;
  said?: string; // the unit, if there is room
  lane: string; // curves in one lane share a scale
  doc: string;
  limit?: number;
  is_of_solver?: boolean; // not available in a bake's frames
  is_of_skeleton?: boolean;
  value: (frame: FrameMessage, fps: number) => number;
}

const MEANINGS: Meaning[] = [
  {
    name: "Lag, mean",
    unit: "mm",
    lane: "lag",
    is_of_skeleton: true,
    doc: "Distance of the flesh from its position by skinning alone: root mean square over all free vertices",
    value: (frame) => 1e3 * frame.lag,
  },
  {
    name: "Lag, peak",
    unit: "mm",
    lane: "lag",
    is_of_skeleton: true,
    doc: "Largest distance of a free vertex from its position by skinning alone",
    value: (frame) => 1e3 * frame.most_lag,
  },
  { name: "Energy", unit: "J", lane: "energy", doc: "Kinetic energy of the body", value: (frame) => frame.energy },
  {
    name: "Volume",
    unit: "%",
    lane: "volume",
    doc: "Volume of the body relative to rest",
    value: (frame) => 100 * frame.volume,
  },
  {
    name: "Solver speed",
    unit: "×",
    said: "× real time",
    lane: "speed",
    doc:
      "How fast the solver can run, as a multiple of real time; below 1, the dashed line, playback is slower than " +
      "real time",
    limit: 1,
    is_of_solver: true,
    value: (frame, fps) => frame.rate / fps,
  },
];

interface Track {
  meaning: Meaning;
  own: Line;
  beside: Line;
  is_shown: boolean;
}

export class LiveCurves {
  private plot: CurvePlot | null = null;
  private tracks: Track[] = [];
  private frame = 0; // the current one
  private fps = 1;
  private label = "";

  constructor(private readonly seek: (frame: number) => void) {}

  // Starts a clip of `count` frames, none of which has arrived yet. `is_live`: whether a solver computes them;
  // `has_skeleton`: without one there is no lag.
  begin(count: number, axis: Axis, is_live: boolean, has_skeleton: boolean): void {
    this.fps = axis.fps;
    const hidden = this.tracks.filter((track) => !track.is_shown).map((track) => track.meaning.name);
    this.tracks = MEANINGS.filter(
      (meaning) => (is_live || !meaning.is_of_solver) && (has_skeleton || !meaning.is_of_skeleton),
    ).map((meaning) => {
      const curve = (): Curve => ({
        name: meaning.name,
        unit: meaning.unit,
        limit: meaning.limit ?? null,
        values: new Array(count).fill(null),
      });
      const colour = `--curve-${MEANINGS.indexOf(meaning)}`;
      return {
        meaning,
        own: { curve: curve(), colour },
        beside: { curve: { ...curve(), limit: null }, colour, dashed: true },
        is_shown: !hidden.includes(meaning.name),
      };
    });
    this.list();
    if (!this.plot) this.plot = new CurvePlot(element<HTMLCanvasElement>("plot"), count, (frame) => this.seek(frame));
    this.plot.frames = count;
    this.plot.axis = axis;
  }

  // Discards all values; the frames will arrive again.
  clear(): void {
    for (const track of this.tracks) track.own.curve.values.fill(null);
  }
  // Discards the values of the comparison bake.
  clear_beside(): void {
    for (const track of this.tracks) track.beside.curve.values.fill(null);
  }

  note(frame: FrameMessage): void {
    const put = (line: Line, at: number, value: number) => {
      if (at < line.curve.values.length) line.curve.values[at] = Number.isFinite(value) ? value : null;
    };
    for (const { meaning, own, beside } of this.tracks) {
      // After a seek the flesh was carried there, so the frame says nothing about its motion.
      if (!frame.begins) put(own, frame.frame, meaning.value(frame, this.fps));
      if (frame.beside && !meaning.is_of_solver) put(beside, frame.frame, meaning.value(frame.beside, this.fps));
    }
  }

  private lanes(): Lane[] {
    const lanes = new Map<string, Lane>();
    for (const track of this.tracks) {
      if (!track.is_shown) continue;
      const lines = track.beside.curve.values.some((value) => value !== null) ? [track.beside] : [];
      const lane = lanes.get(track.meaning.lane);
      if (lane) lane.more!.push(track.own, ...lines);
      else lanes.set(track.meaning.lane, { ...track.own, more: lines });
    }
    return [...lanes.values()];
  }

  draw(frame: number): void {
    this.frame = frame;
    if (!this.plot) return;
    const lanes = this.lanes();
    this.plot.draw(lanes, frame);
    const values = element("curve-list").querySelectorAll("output");
    this.tracks.forEach(({ meaning, own, beside }, k) => {
      if (!values[k]) return;
      const unit = meaning.said ?? meaning.unit;
      const has_other = typeof beside.curve.values[frame] === "number";
      const bare = (curve: Curve) => value_text({ ...curve, unit: "" }, frame);
      values[k].textContent = has_other
        ? `${bare(own.curve)} | ${bare(beside.curve)} ${unit}`
        : value_text({ ...own.curve, unit }, frame);
    });
    const said = lanes.map((lane) => {
      const [least, most] = range_of(lane.curve, ...(lane.more ?? []).map((line) => line.curve));
      return `${lane.curve.name} from ${short_number(least)} to ${short_number(most)} ${lane.curve.unit}`;
    });
    const label = `Curves over time: ${said.join("; ")}`;
    if (label !== this.label) element("plot").setAttribute("aria-label", label);
    this.label = label;
  }

  private list(): void {
    const list = element("curve-list");
    list.replaceChildren();
    for (const track of this.tracks) {
      const label = document.createElement("label");
      label.title = track.meaning.doc;
      const box = document.createElement("input");
      box.type = "checkbox";
      box.checked = track.is_shown;
      const line = document.createElement("span");
      line.className = "line";
      line.style.background = `var(${track.own.colour})`;
      const name = document.createElement("span");
      name.textContent = track.meaning.name;
      const value = document.createElement("output");
      label.append(box, line, name, value);
      const item = document.createElement("li");
      item.append(label);
      list.append(item);
      box.addEventListener("change", () => {
        track.is_shown = box.checked;
        this.draw(this.frame);
      });
    }
  }
}
