// Curves of a run, with the moment that is shown; a point of a curve brings its frame.

import { digits } from "./scale.js";

const LEFT = 58, RIGHT = 10, TOP = 34, BOTTOM = 22; // px round the curves
const LINES = 2; // of names above them, at most
const LOOSE = 0.06; // of the range, left free above and below

/**
 * A chart of one of the page's curves at a time: name, unit, series (label, colour or null, array,
 * dashed), time (an array), window [s] of the time that is shown or null for all of it, since [s],
 * from when on values decide the scale, spans (from, to, label, colour) and steps, where values hold
 * until the next.
 */
export class Curves {
  constructor(canvas, curves, arrays, clock) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.curves = curves;
    this.arrays = arrays;
    this.clock = clock; // unit and factor of times in words
    this.chosen = 0;
  }

  resize(width, height, ratio) {
    Object.assign(this, { width, height, ratio });
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
  }

  get curve() {
    return this.curves[this.chosen];
  }

  /** Times [s] from left to right when `time` is shown. */
  span(time) {
    const times = this.arrays[this.curve.time];
    const [first, last] = [times.at(0), times.at(times.rows - 1)];
    const { window } = this.curve;
    const spans = this.curve.spans.map((one) => one.to);
    if (!window || window >= last - first) return [first, Math.max(last, ...spans)];
    const start = Math.max(first, Math.min(time - window / 2, last - window));
    return [start, start + window];
  }

  /** The time [s] at a place of the canvas (px), when `time` is shown. */
  timeAt(px, time) {
    const [first, last] = this.span(time);
    const part = (px - LEFT) / (this.width - LEFT - RIGHT);
    return first + Math.max(0, Math.min(part, 1)) * (last - first);
  }

  draw(time, theme) {
    const { context, ratio, curve } = this;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, this.width, this.height);
    const [first, last] = this.span(time), [low, high] = this.range();
    const x = (t) => LEFT + ((t - first) / (last - first || 1)) * (this.width - LEFT - RIGHT);
    const y = (v) => TOP + ((high - v) / (high - low)) * (this.height - TOP - BOTTOM);
    this.drawAxes(x, y, first, last, low, high, theme);
    context.save();
    context.beginPath();
    context.rect(LEFT, TOP - 2, this.width - LEFT - RIGHT, this.height - TOP - BOTTOM + 4);
    context.clip();
    for (const { from, to, colour } of curve.spans) {
      context.fillStyle = theme.of(colour);
      context.globalAlpha = to > from ? 0.2 : 0.9;
      context.fillRect(x(from), TOP, Math.max(x(to) - x(from), 1.5), this.height - TOP - BOTTOM);
      context.globalAlpha = 1;
    }
    for (const series of curve.series) this.drawSeries(series, x, y, first, last, theme);
    context.strokeStyle = theme.picked;
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(x(time), TOP);
    context.lineTo(x(time), this.height - BOTTOM);
    context.stroke();
    context.restore();
    this.drawLabels(time, theme);
  }

  range() {
    const times = this.arrays[this.curve.time];
    let since = 0;
    while (since < times.rows - 1 && times.at(since) < this.curve.since) since++;
    const ends = this.curve.series.flatMap(({ array }) => {
      const { low, step, integers } = this.arrays[array];
      let most = 0, least = 65535;
      for (let k = since; k < integers.length; k++) {
        most = Math.max(most, integers[k]);
        least = Math.min(least, integers[k]);
      }
      return [low + step * least, low + step * most];
    });
    const [low, high] = [Math.min(0, ...ends), Math.max(0, ...ends)];
    const loose = LOOSE * (high - low || 1);
    return [low < 0 ? low - loose : 0, high + loose];
  }

  drawSeries({ array, colour, dashed }, x, y, first, last, theme) {
    const { context, curve } = this, times = this.arrays[curve.time], values = this.arrays[array];
    context.strokeStyle = theme.of(colour);
    context.setLineDash(dashed ? [6, 3] : []);
    context.lineWidth = 1.6;
    context.lineJoin = "round";
    context.beginPath();
    let started = false;
    for (let k = 0; k < times.rows; k++) {
      if (times.at(Math.min(k + 1, times.rows - 1)) < first) continue;
      if (times.at(Math.max(k - 1, 0)) > last) break;
      const at = [x(times.at(k)), y(values.at(k))];
      if (curve.steps && started) context.lineTo(at[0], y(values.at(k - 1)));
      if (started) context.lineTo(...at);
      else context.moveTo(...at);
      started = true;
    }
    context.stroke();
    context.setLineDash([]);
  }

  drawAxes(x, y, first, last, low, high, theme) {
    const { context } = this;
    context.font = "11px system-ui, sans-serif";
    context.lineWidth = 1;
    context.textBaseline = "middle";
    context.textAlign = "right";
    for (const value of rounded(low, high, Math.max(3, Math.floor((this.height - TOP - BOTTOM) / 24)))) {
      context.strokeStyle = theme.rule;
      context.beginPath();
      context.moveTo(LEFT, y(value));
      context.lineTo(this.width - RIGHT, y(value));
      context.stroke();
      context.fillStyle = theme.quiet;
      context.fillText(digits(value), LEFT - 6, y(value));
    }
    context.textAlign = "center";
    context.textBaseline = "alphabetic";
    const { factor, unit } = this.clock;
    const ticks = rounded(first * factor, last * factor, Math.max(2, Math.floor(this.width / 110)));
    ticks.forEach((value, k) => {
      const words = k === ticks.length - 1 ? `${digits(value)} ${unit}` : digits(value);
      const at = Math.min(x(value / factor), this.width - RIGHT - 4 * words.length);
      context.fillText(words, at, this.height - 6);
    });
  }

  /** Names of the series with their values, and of the spans, above the curves. */
  drawLabels(time, theme) {
    const { context, curve } = this, times = this.arrays[curve.time];
    let at = 0;
    while (at + 1 < times.rows && times.at(at + 1) <= time + 1e-12) at++;
    context.textAlign = "left";
    let left = LEFT, line = 0;
    const words = [
      ...curve.series.map(({ label, colour, array, dashed }) =>
        [`${dashed ? "\u2505" : "\u2501"} ${label} ${digits(this.arrays[array].at(at))}`, colour]),
      ...curve.spans.map(({ label, colour }) => [label, colour]),
    ];
    for (const [text, colour] of words) {
      const wide = context.measureText(text).width;
      if (left + wide > this.width - RIGHT && left > LEFT) {
        if (++line === LINES) break;
        left = LEFT;
      }
      context.fillStyle = theme.of(colour);
      context.fillText(text, left, 12 + 13 * line);
      left += wide + 14;
    }
    context.fillStyle = theme.quiet;
    context.fillText(curve.unit ? `[${curve.unit}]` : "", 6, 12);
  }
}

/** Round numbers between two, about so many. */
export function rounded(low, high, count) {
  const rough = (high - low) / count || 1;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((one) => one >= rough * 0.999);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return found;
}
