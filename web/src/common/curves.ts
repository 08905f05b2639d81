// Curves over the timeline, each in its own lane, with a mark at the current frame.
import type { Curve } from "./film";
import { nice_above, short_number } from "./numbers";

export interface Line {
  curve: Curve;
  colour: string; // name in the style sheet
  dashed?: boolean;
}

// Curves with the same unit, on one scale.
export interface Lane extends Line {
  more?: Line[];
}

// The minimum and maximum over all curves, extended to 0 if it is close.
export function range_of(...curves: Curve[]): [number, number] {
  let least = Infinity;
  let most = -Infinity;
  for (const curve of curves)
    for (const value of curve.values) {
      if (value === null) continue;
      least = Math.min(least, value);
      most = Math.max(most, value);
    }
  if (least > most) return [0, 1];
  for (const { limit } of curves)
    if (limit !== null) {
      least = Math.min(least, limit);
      most = Math.max(most, limit);
    }
  if (least > 0 && least < 0.5 * most) least = 0;
  if (most === 0 && least === 0) return [0, 1];
  if (most === least) return [least - 0.5 * Math.abs(least) - 0.5, most + 0.5 * Math.abs(most) + 0.5];
  return [least, most];
}

export function value_text(curve: Curve, frame: number): string {
  const value = curve.values[frame];
  if (value === null || value === undefined) return "–";
  const [least, most] = range_of(curve);
  // Too small to see in the curve.
  if (Math.abs(value) < 1e-4 * (most - least)) return curve.unit ? `0 ${curve.unit}` : "0";
  return curve.unit ? `${short_number(value)} ${curve.unit}` : short_number(value);
}

// The time axis.
export interface Axis {
  fps: number;
  start: number; // s, at frame 0
}

const GUTTER = 62; // pixels on the left, for values
const FOOT = 17; // pixels below, for times
const PAD = 4; // pixels above and below a lane
const SIZE = 10.5; // font size, pixels

// Round times (s) between start and end, about `wanted` of them, and the number of digits they need.
export function time_ticks(start: number, end: number, wanted: number): { times: number[]; digits: number } {
  const span = end - start;
  if (!(span > 0)) return { times: [start], digits: Number.isInteger(start) ? 0 : 2 };
  const step = nice_above(span / Math.max(wanted, 1));
  const digits = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  const times: number[] = [];
  // Without -0.
  for (let k = Math.ceil(start / step - 1e-9); k * step <= end + 1e-9 * span; ++k) times.push(k === 0 ? 0 : k * step);
  return { times, digits };
}

// Axis labels of two values, with enough digits to tell them apart.
export function axis_texts(least: number, most: number): [string, string] {
  const span = Math.abs(most - least);
  const text = (value: number) => {
    if (Math.abs(value) < 1e-3 * span) return "0";
    const size = Math.max(Math.abs(least), Math.abs(most));
    const near = span < 0.1 * size;
    // Values close together may have the same three digits.
    if (near && size < 1e5) return value.toFixed(Math.min(Math.max(0, Math.ceil(1 - Math.log10(span))), 6));
    return short_number(value);
  };
  return [text(least), text(most)];
}

export class CurvePlot {
  private readonly context: CanvasRenderingContext2D;
  axis: Axis | null = null; // null: the curves have the full width

  constructor(
    private readonly canvas: HTMLCanvasElement,
    public frames: number,
    seek: (frame: number) => void,
  ) {
    this.context = canvas.getContext("2d")!;
    const at = (event: PointerEvent) => {
      const box = canvas.getBoundingClientRect();
      const left = this.axis ? GUTTER : 0;
      const share = (event.clientX - box.left - left) / (box.width - left || 1);
      seek(Math.round(Math.min(Math.max(share, 0), 1) * (this.frames - 1)));
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      at(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) at(event);
    });
  }

  draw(lanes: Lane[], frame: number): void {
    const ratio = Math.min(window.devicePixelRatio, 2);
    const width = this.canvas.clientWidth;
    const full_height = this.canvas.clientHeight;
    if (this.canvas.width !== Math.round(width * ratio)) this.canvas.width = Math.round(width * ratio);
    if (this.canvas.height !== Math.round(full_height * ratio)) this.canvas.height = Math.round(full_height * ratio);
    const style = getComputedStyle(this.canvas);
    const colour = (name: string) => style.getPropertyValue(name).trim();
    const draw = this.context;
    draw.setTransform(ratio, 0, 0, ratio, 0, 0);
    draw.clearRect(0, 0, width, full_height);
    draw.font = `${SIZE}px ${style.fontFamily}`;
    draw.textBaseline = "alphabetic";
    const left = this.axis ? GUTTER : 0;
    const height = full_height - (this.axis ? FOOT : 0);
    const x_of = (k: number) =>
      this.frames > 1 ? left + 0.5 + (k / (this.frames - 1)) * (width - left - 1) : (left + width) / 2;
    const rule = (x0: number, y0: number, x1: number, y1: number) => {
      draw.beginPath();
      draw.moveTo(x0, y0);
      draw.lineTo(x1, y1);
      draw.stroke();
    };
    if (this.axis) this.draw_times(this.axis, width, height, x_of, rule, colour);
    const lane_height = height / Math.max(lanes.length, 1);
    lanes.forEach((lane, number) => {
      const lines: Line[] = [lane, ...(lane.more ?? [])];
      const [least, most] = range_of(...lines.map((line) => line.curve));
      const top = number * lane_height + PAD + 1;
      const bottom = (number + 1) * lane_height - PAD - 1;
      const y_of = (value: number) => bottom - ((value - least) / (most - least)) * (bottom - top);
      draw.lineWidth = 1;
      draw.strokeStyle = colour("--line");
      const ground = Math.round(bottom + PAD) + 0.5;
      rule(left, ground, width, ground);
      if (this.axis) {
        const [low, high] = axis_texts(least, most);
        draw.textAlign = "right";
        draw.fillStyle = colour("--text");
        for (const y of [top, bottom]) rule(left - 4, Math.round(y) + 0.5, left, Math.round(y) + 0.5);
        rule(left - 0.5, Math.round(top), left - 0.5, Math.round(bottom) + 1);
        draw.fillText(lane.curve.unit ? `${high} ${lane.curve.unit}` : high, left - 7, top + 0.72 * SIZE);
        // If a lane is low, label only its maximum.
        if (bottom - top > 1.7 * SIZE) draw.fillText(low, left - 7, bottom + 1);
      }
      if (lane.curve.limit !== null) {
        draw.setLineDash([4, 4]);
        draw.strokeStyle = colour("--bad");
        rule(left, y_of(lane.curve.limit), width, y_of(lane.curve.limit));
        draw.setLineDash([]);
      }
      for (const line of [...lines].reverse()) this.draw_line(line, frame, x_of, y_of, colour);
      const value = lane.curve.values[frame];
      if (!this.axis || value === null || value === undefined) return;
      const text = value_text(lane.curve, frame);
      const room = draw.measureText(text).width + 14;
      const is_left = x_of(frame) + room > width;
      const x = is_left ? x_of(frame) - 8 : x_of(frame) + 8;
      const y = Math.min(Math.max(y_of(value) + 0.36 * SIZE, top + 0.75 * SIZE), bottom);
      draw.textAlign = is_left ? "right" : "left";
      draw.lineWidth = 3;
      draw.lineJoin = "round";
      draw.strokeStyle = colour("--panel");
      draw.strokeText(text, x, y);
      draw.fillStyle = colour("--text");
      draw.fillText(text, x, y);
    });
    draw.strokeStyle = colour("--text");
    draw.globalAlpha = 0.55;
    draw.lineWidth = 1;
    rule(Math.round(x_of(frame)) + 0.5, 0, Math.round(x_of(frame)) + 0.5, height);
    draw.globalAlpha = 1;
  }

  private draw_line(
    line: Line,
    frame: number,
    x_of: (k: number) => number,
    y_of: (value: number) => number,
    colour: (name: string) => string,
  ): void {
    const draw = this.context;
    draw.strokeStyle = colour(line.colour);
    draw.lineWidth = line.dashed ? 1.4 : 1.75;
    draw.setLineDash(line.dashed ? [5, 3] : []);
    draw.lineJoin = "round";
    draw.beginPath();
    let down = false;
    line.curve.values.forEach((value, k) => {
      if (value === null) {
        down = false;
      } else if (down) {
        draw.lineTo(x_of(k), y_of(value));
      } else {
        draw.moveTo(x_of(k), y_of(value));
        down = true;
      }
    });
    draw.stroke();
    draw.setLineDash([]);
    const value = line.curve.values[frame];
    if (value === null || value === undefined) return;
    draw.fillStyle = colour(line.colour);
    draw.beginPath();
    draw.arc(x_of(frame), y_of(value), line.dashed ? 2.5 : 3.5, 0, 2 * Math.PI);
    draw.fill();
  }

  private draw_times(
    axis: Axis,
    width: number,
    height: number,
    x_of: (k: number) => number,
    rule: (x0: number, y0: number, x1: number, y1: number) => void,
    colour: (name: string) => string,
  ): void {
    const draw = this.context;
    const end = axis.start + (this.frames - 1) / axis.fps;
    const { times, digits } = time_ticks(axis.start, end, (width - GUTTER) / 90);
    draw.lineWidth = 1;
    draw.strokeStyle = colour("--soft");
    draw.fillStyle = colour("--soft");
    for (const time of times) {
      const x = x_of((time - axis.start) * axis.fps);
      const text = `${time.toFixed(digits)} s`;
      const half = draw.measureText(text).width / 2;
      rule(Math.round(x) + 0.5, height, Math.round(x) + 0.5, height + 4);
      draw.textAlign = "center";
      draw.fillText(text, Math.min(x, width - half), height + FOOT - 3);
    }
  }
}
