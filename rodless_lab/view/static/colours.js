// Colours that the colour-blind tell apart (Okabe and Ito), and a scale of growing lightness that
// says the same in grey (after cividis).
export const COLOURS = {
  blue: "#0072B2",
  orange: "#D55E00",
  green: "#009E73",
  purple: "#AA4499",
  sky: "#56B4E9",
  black: "#111111",
  grey: "#767676",
};

const SCALE = [
  [0, 32, 76],
  [60, 77, 110],
  [124, 123, 120],
  [187, 173, 108],
  [255, 233, 69],
];

// The colour of an absolute pressure (Pa) on a scale from the atmosphere to the supply.
export function pressureColour(pressure, low, high) {
  if (pressure === null || pressure === undefined) return "#ffffff";
  const share = Math.min(Math.max((pressure - low) / Math.max(high - low, 1), 0), 1);
  const place = share * (SCALE.length - 1);
  const first = Math.min(Math.floor(place), SCALE.length - 2);
  const rest = place - first;
  const mix = SCALE[first].map((v, k) => Math.round(v + rest * (SCALE[first + 1][k] - v)));
  return `rgb(${mix.join(",")})`;
}
