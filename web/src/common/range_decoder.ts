// The decoder for host/page/range_encoder.cpp: adaptive bits and numbers from bytes.

const PROBABILITY_BITS = 12;
const ADAPTION = 5;
const EVEN = 1 << (PROBABILITY_BITS - 1);

export class RangeDecoder {
  private at = 1; // the first byte is always 0
  private range = 0xffffffff;
  private code = 0;

  constructor(private readonly bytes: Uint8Array) {
    for (let k = 0; k < 4; ++k) this.code = ((this.code << 8) | this.next()) >>> 0;
  }

  private next(): number {
    if (this.at >= this.bytes.length) throw new Error("the page's data ends too early");
    return this.bytes[this.at++];
  }

  private normalise(): void {
    while (this.range < 0x1000000) {
      this.range = (this.range << 8) >>> 0;
      this.code = ((this.code << 8) | this.next()) >>> 0;
    }
  }

  // Decodes a bit by its probability of being 0, `of_zero[at]`, which adapts.
  bit(of_zero: Uint16Array, at: number): number {
    const probability = of_zero[at];
    const bound = (this.range >>> PROBABILITY_BITS) * probability;
    let one = 0;
    if (this.code < bound) {
      this.range = bound;
      of_zero[at] = probability + (((1 << PROBABILITY_BITS) - probability) >> ADAPTION);
    } else {
      this.code = (this.code - bound) >>> 0;
      this.range = (this.range - bound) >>> 0;
      of_zero[at] = probability - (probability >> ADAPTION);
      one = 1;
    }
    if (this.range < 0x1000000) this.normalise();
    return one;
  }

  direct(count: number): number {
    let bits = 0;
    for (let k = 0; k < count; ++k) {
      this.range >>>= 1;
      const one = this.code >= this.range ? 1 : 0;
      if (one) this.code = (this.code - this.range) >>> 0;
      bits = (bits << 1) | one;
      this.normalise();
    }
    return bits;
  }
}

const LENGTHS = 32; // a tree of five bits; entry 0 holds the probability of the sign
const LOW = 4;

export class NumberDecoder {
  private readonly lengths: Uint16Array;
  private readonly low = new Uint16Array(LENGTHS * LOW).fill(EVEN);

  constructor(contexts: number) {
    this.lengths = new Uint16Array(contexts * LENGTHS).fill(EVEN);
  }

  take(from: RangeDecoder, context: number): number {
    const tree = context * LENGTHS;
    let node = 1;
    for (let k = 0; k < 5; ++k) node = 2 * node + from.bit(this.lengths, tree + node);
    const length = node - LENGTHS;
    if (length === 0) return 0;
    const negative = from.bit(this.lengths, tree);
    let left = length - 1;
    let size = 1;
    node = 1;
    for (let k = 0; k < 2 && left > 0; ++k, --left) {
      const one = from.bit(this.low, length * LOW + node);
      node = 2 * node + one;
      size = 2 * size + one;
    }
    if (left > 0) size = size * 2 ** left + from.direct(left);
    return negative ? -size : size;
  }
}

// For |number| below 2^31.
export function bit_length(number: number): number {
  return 32 - Math.clz32(Math.abs(number));
}
