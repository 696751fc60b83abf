// Colours of particles: from the integers of an array to places on a scale, and its legend.

export const TONES = 64; // colours of a scale that runs on

/**
 * A scale of colours. What it is made of stands in the page: label, unit, array, "per" (particle,
 * frame or moment: a frame with contacts), colours, and low and high; or, of categories, names, or
 * how many are numbered 1, 2, ...: their colours come again where there are fewer.
 */
export class Scale {
  constructor(spec, array) {
    Object.assign(this, spec);
    this.array = array;
    this.categories = spec.names?.length ?? spec.numbered;
    const { colours } = spec;
    this.tones = Array.from({ length: Math.min(this.categories || TONES, TONES) }, (_, k) =>
      this.categories ? colours[k % colours.length] : blend(colours, k / (TONES - 1)));
    // Both a linear and a logarithmic array are linear in the integers.
    if (array.logarithmic) {
      this.slope = array.step / Math.log(spec.high / spec.low);
      this.start = (Math.log(array.low / spec.low) - array.step) / Math.log(spec.high / spec.low);
    } else {
      this.slope = array.step / (spec.high - spec.low);
      this.start = (array.low - spec.low) / (spec.high - spec.low);
    }
  }

  /** Number of the colour of an integer. */
  tone(integer) {
    if (this.categories) return integer % this.tones.length;
    const part = this.start + this.slope * integer;
    return Math.max(0, Math.min(TONES - 1, Math.round((TONES - 1) * part)));
  }

  /** A value in words, with its unit. */
  words(integer) {
    if (this.categories) return this.names?.[integer] ?? `${integer + 1}`;
    return withUnit(this.array.value(integer), this.unit);
  }

  /** Ends and middle of the scale, as numbers. */
  ticks() {
    const { low, high } = this;
    const middle = this.array.logarithmic ? Math.sqrt(low * high) : (low + high) / 2;
    return [low, middle, high].map((value) => digits(value));
  }
}

/** The colour at a part (0 to 1) of a list of #rrggbb. */
function blend(colours, part) {
  const at = part * (colours.length - 1);
  const first = Math.min(Math.floor(at), colours.length - 2);
  const [a, b] = [rgb(colours[first]), rgb(colours[first + 1])];
  const mixed = a.map((value, k) => Math.round(value + (b[k] - value) * (at - first)));
  return `#${mixed.map((value) => value.toString(16).padStart(2, "0")).join("")}`;
}

/** Parts 0 ... 255 of a colour #rrggbb. */
export function rgb(colour) {
  return [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16));
}

/** A number with three digits. */
export function digits(value) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size === 0) return "0";
  const text = size < 1e-3 || size >= 1e5 ? value.toExponential(2) : `${+value.toPrecision(3)}`;
  return text.replace("-", "\u2212").replace(/e\+?(.*)/, "\u00b710^$1");
}

const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "\u00b5"],
  [1e-9, "n"]];

/** A value in SI with a prefix that leaves one to three digits before the point. */
export function withUnit(value, unit) {
  if (!Number.isFinite(value)) return "–";
  if (!unit || value === 0) return `${digits(value)} ${unit}`.trim();
  const size = Math.abs(value);
  const [factor, prefix] = PREFIXES.find(([least]) => size >= least) ?? PREFIXES.at(-1);
  return `${digits(value / factor)} ${prefix}${unit}`;
}
