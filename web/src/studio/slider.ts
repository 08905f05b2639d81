// The position of a key's value on its slider, which has integer steps from 0 to STEPS.
import type { SceneKey } from "./protocol";

export const STEPS = 400;

export interface Range {
  least: number;
  most: number;
  logarithmic: boolean;
}

// Null for a key without both bounds.
export function range_of(key: Pick<SceneKey, "soft_minimum" | "soft_maximum" | "minimum" | "maximum" | "logarithmic">): Range | null {
  const least = key.soft_minimum ?? key.minimum;
  const most = key.soft_maximum ?? key.maximum;
  if (least === undefined || most === undefined || !(least < most)) return null;
  return { least, most, logarithmic: key.logarithmic === true && least > 0 };
}

export function step_of(value: number, range: Range): number {
  const share = range.logarithmic
    ? Math.log(Math.max(value, 1e-300) / range.least) / Math.log(range.most / range.least)
    : (value - range.least) / (range.most - range.least);
  return Math.round(Math.min(Math.max(share, 0), 1) * STEPS);
}

// Rounded to three significant digits.
export function value_of(step: number, range: Range): number {
  const share = step / STEPS;
  const value = range.logarithmic
    ? range.least * (range.most / range.least) ** share
    : range.least + share * (range.most - range.least);
  if (step === 0) return range.least;
  if (step === STEPS) return range.most;
  // A value that is only near 0 because of rounding is 0.
  if (!range.logarithmic && Math.abs(value) < 1e-9 * (range.most - range.least)) return 0;
  return Number(value.toPrecision(3));
}
