// What the view draws with: plain SVG and canvas, fed with one small message per frame.
export { Scene } from "./scene.js";
export { Plot } from "./plot.js";
export { COLOURS, pressureColour } from "./colours.js";
