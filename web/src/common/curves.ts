// Curves over the time line, each in a lane of its own, with a mark at the frame that is shown.
import type { Curve } from "./film";
import { short_number } from "./numbers";

export interface Lane {
  curve: Curve;
  colour: string; // of the style sheet
}

// The least and the greatest value, of all of them and 0 where that is near.
export function range_of(curve: Curve): [number, number] {
  let least = Infinity;
  let most = -Infinity;
  for (const value of curve.values) {
    if (value === null) continue;
    least = Math.min(least, value);
    most = Math.max(most, value);
  }
  if (least > most) return [0, 1];
  if (curve.limit !== null) most = Math.max(most, curve.limit);
  if (least > 0 && least < 0.5 * most) least = 0;
  if (most === least) return [least - 0.5 * Math.abs(least) - 0.5, most + 0.5 * Math.abs(most) + 0.5];
  return [least, most];
}

export function value_text(curve: Curve, frame: number): string {
  const value = curve.values[frame];
  if (value === null || value === undefined) return "–";
  const [least, most] = range_of(curve);
  // Nobody sees less of it than that.
  if (Math.abs(value) < 1e-4 * (most - least)) return curve.unit ? `0 ${curve.unit}` : "0";
  return curve.unit ? `${short_number(value)} ${curve.unit}` : short_number(value);
}

export class CurvePlot {
  private readonly context: CanvasRenderingContext2D;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    public frames: number,
    seek: (frame: number) => void,
  ) {
    this.context = canvas.getContext("2d")!;
    const at = (event: PointerEvent) => {
      const box = canvas.getBoundingClientRect();
      const share = (event.clientX - box.left) / (box.width || 1);
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
    const height = this.canvas.clientHeight;
    if (this.canvas.width !== Math.round(width * ratio)) this.canvas.width = Math.round(width * ratio);
    if (this.canvas.height !== Math.round(height * ratio)) this.canvas.height = Math.round(height * ratio);
    const style = getComputedStyle(this.canvas);
    const colour = (name: string) => style.getPropertyValue(name).trim();
    const draw = this.context;
    draw.setTransform(ratio, 0, 0, ratio, 0, 0);
    draw.clearRect(0, 0, width, height);
    const x_of = (k: number) => (this.frames > 1 ? 0.5 + (k / (this.frames - 1)) * (width - 1) : width / 2);
    const lane_height = height / Math.max(lanes.length, 1);
    lanes.forEach(({ curve, colour: name }, number) => {
      const [least, most] = range_of(curve);
      const top = number * lane_height + 5;
      const bottom = (number + 1) * lane_height - 5;
      const y_of = (value: number) => bottom - ((value - least) / (most - least)) * (bottom - top);
      draw.lineWidth = 1;
      draw.strokeStyle = colour("--line");
      draw.beginPath();
      draw.moveTo(0, Math.round(bottom + 4) + 0.5);
      draw.lineTo(width, Math.round(bottom + 4) + 0.5);
      draw.stroke();
      if (curve.limit !== null) {
        draw.setLineDash([4, 4]);
        draw.strokeStyle = colour("--bad");
        draw.beginPath();
        draw.moveTo(0, y_of(curve.limit));
        draw.lineTo(width, y_of(curve.limit));
        draw.stroke();
        draw.setLineDash([]);
      }
      draw.strokeStyle = colour(name);
      draw.lineWidth = 1.75;
      draw.lineJoin = "round";
      draw.beginPath();
      let down = false;
      curve.values.forEach((value, k) => {
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
      const value = curve.values[frame];
      if (value === null || value === undefined) return;
      draw.fillStyle = colour(name);
      draw.beginPath();
      draw.arc(x_of(frame), y_of(value), 3.5, 0, 2 * Math.PI);
      draw.fill();
    });
    draw.strokeStyle = colour("--text");
    draw.globalAlpha = 0.55;
    draw.lineWidth = 1;
    draw.beginPath();
    draw.moveTo(Math.round(x_of(frame)) + 0.5, 0);
    draw.lineTo(Math.round(x_of(frame)) + 0.5, height);
    draw.stroke();
    draw.globalAlpha = 1;
  }
}
