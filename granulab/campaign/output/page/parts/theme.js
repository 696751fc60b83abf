// Colours of the page as its style has them, light or dark, for what is drawn on canvases.

import { rgb } from "./scale.js";

const NAMES = ["stage", "ink", "quiet", "rule", "wall", "shell", "edge", "network", "pull", "force", "picked",
  "measure"];

const LIGHTER = 0.35; // of the way to white, on a dark page

const dark = matchMedia("(prefers-color-scheme: dark)");

/** Colours by name; of(colour) gives that of a curve, the ink's where it is null. */
export function readTheme() {
  const style = getComputedStyle(document.documentElement);
  const theme = {};
  for (const name of NAMES) theme[name] = style.getPropertyValue(`--${name}`).trim();
  theme.pale = Number(style.getPropertyValue("--pale"));
  const part = dark.matches ? LIGHTER : 0;
  theme.of = (colour) => {
    if (colour === null) return theme.ink;
    return `rgb(${rgb(colour).map((value) => Math.round(value + part * (255 - value))).join(" ")})`;
  };
  return theme;
}

/** Calls back when the system turns light or dark. */
export function onThemeChange(callback) {
  dark.addEventListener("change", callback);
}
