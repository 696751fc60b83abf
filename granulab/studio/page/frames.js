// The last frame of a run that goes on, as its simulator draws it.

import { h, put } from "./dom.js";
import { Plane } from "./plane.js";
import { Space } from "./space.js";

/** A view in a place; show(frame) draws one. */
export function frameView(simulator, place) {
  return VIEWS[simulator](place);
}

function siloView(place) {
  const words = h("p", { class: "quiet" });
  const stage = h("div", { class: "stage" });
  put(place, words, stage);
  const plane = new Plane(stage);
  let frame = null;
  plane.layers.push(() => {
    if (!frame) return;
    plane.particles(frame.particles, frame.shapes);
    plane.context.strokeStyle = plane.colour("wall");
    plane.context.lineWidth = 2.5;
    for (const wall of frame.walls) {
      plane.trace(wall, false);
      plane.context.stroke();
    }
  });
  return {
    show(next) {
      const first = !frame;
      frame = next;
      put(words, `t = ${frame.time.toFixed(2)} s, ${frame.out} of ${frame.of} out`);
      if (first) plane.fit(windowOf(frame.walls.flat()));
      plane.draw();
    },
  };
}

function windowOf(points) {
  const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
  const height = Math.max(...ys) - Math.min(...ys);
  return [Math.min(...xs), Math.max(...xs), Math.min(...ys) - 0.15 * height, Math.max(...ys)];
}

function damperView(place) {
  const words = h("p", { class: "quiet" });
  const stage = h("div", { class: "stage" });
  put(place, words, stage);
  const space = new Space(stage);
  return {
    show(frame) {
      put(words, frame.words);
      space.show(frame);
    },
  };
}

const VIEWS = { silo2d: siloView, damper3d: damperView };
