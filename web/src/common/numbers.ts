// Numbers formatted for people.

// Three significant digits, in as few characters as possible.
export function short_number(value: number): string {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(2);
  return String(Number(value.toPrecision(3)));
}

// All digits before the point, and as many after it as there are, up to thousandths.
export function in_full(value: number): string {
  return String(Number(value.toFixed(3)));
}

// The smallest factor times a power of ten that is at least `value` (> 0).
export function nice_above(value: number, factors: readonly number[] = [1, 2, 5, 10]): number {
  const power = 10 ** Math.floor(Math.log10(value));
  for (const factor of factors) if (factor * power >= value * (1 - 1e-9)) return factor * power;
  return 10 * power;
}

export function grouped(value: number): string {
  return value.toLocaleString("en-US");
}
