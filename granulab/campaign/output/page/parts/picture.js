// A picture of what is shown, with its words and legend, saved as PNG.

import { drawLegend } from "./legend.js";

const HEAD = 46, FOOT = 62; // px above and below the stage

/** Hands the picture to the browser, which asks or saves it among its downloads. */
export function savePicture(player) {
  player.render(); // a drawing of the card is kept until the script ends
  pictureOf(player).toBlob((blob) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = `${player.data.name}-${player.state.frame}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }, "image/png");
}

export function pictureOf(player) {
  const { view, theme, ratio, data } = player;
  const { clientWidth: width, clientHeight: height } = player.stage;
  const canvas = document.createElement("canvas");
  canvas.width = width * ratio;
  canvas.height = (HEAD + height + FOOT) * ratio;
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  context.fillStyle = theme.stage;
  context.fillRect(0, 0, width, HEAD + height + FOOT);
  context.fillStyle = theme.ink;
  context.font = "600 14px system-ui, sans-serif";
  context.fillText(data.title, 10, 20, width - 20);
  context.font = "13px system-ui, sans-serif";
  context.fillText(player.clockWords(), 10, 39, width - 20);
  for (const layer of view ? [view.canvas, view.overlay] : []) {
    if (layer) context.drawImage(layer, 0, HEAD, width, height);
  }
  drawLegend(context, player.scales[player.state.colour], [10, HEAD + height + 4], width - 20, theme);
  return canvas;
}
