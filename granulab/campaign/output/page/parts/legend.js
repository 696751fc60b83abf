// The legend of the colours: a bar or the names of categories; on the page and in pictures.

const BAR = 150, HIGH = 12; // px

/** Draws it from a corner of a context on; how wide and high it is [px]. */
export function drawLegend(context, scale, [left, top], most, theme) {
  context.font = "600 12px system-ui, sans-serif";
  context.textBaseline = "alphabetic";
  context.textAlign = "left";
  context.fillStyle = theme.ink;
  const title = scale.unit ? `${scale.label} [${scale.unit}]` : scale.label;
  context.fillText(title, left, top + 12);
  const titled = context.measureText(title).width;
  context.font = "11px system-ui, sans-serif";
  const [wide, high] = scale.names
    ? drawNames(context, scale, left, top + 20, most, theme)
    : drawBar(context, scale, left, top + 20, Math.min(BAR, most), theme);
  return [Math.max(wide, titled), high];
}

function drawBar(context, scale, left, top, wide, theme) {
  const each = wide / scale.tones.length;
  scale.tones.forEach((tone, k) => {
    context.fillStyle = tone;
    context.fillRect(left + k * each, top, each + 0.7, HIGH);
  });
  context.strokeStyle = theme.wall;
  context.lineWidth = 1;
  context.strokeRect(left + 0.5, top + 0.5, wide - 1, HIGH - 1);
  context.fillStyle = theme.ink;
  const words = scale.numbered ? [1, scale.numbered] : scale.ticks();
  words.forEach((text, k) => {
    const part = k / (words.length - 1);
    context.textAlign = ["left", "right"][part] ?? "center";
    context.fillText(text, left + part * wide, top + HIGH + 13);
  });
  context.textAlign = "left";
  return [wide, HIGH + 40];
}

function drawNames(context, scale, left, top, most, theme) {
  let x = left, y = top;
  scale.names.forEach((name, k) => {
    const wide = 18 + context.measureText(name).width + 12;
    if (x + wide > left + most && x > left) {
      x = left;
      y += 18;
    }
    context.fillStyle = scale.tones[k];
    context.fillRect(x, y, 12, 12);
    context.strokeStyle = theme.wall;
    context.lineWidth = 1;
    context.strokeRect(x + 0.5, y + 0.5, 11, 11);
    context.fillStyle = theme.ink;
    context.fillText(name, x + 17, y + 10);
    x += wide;
  });
  return [most, y - top + 36];
}
