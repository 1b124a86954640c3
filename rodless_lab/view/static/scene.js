// The rig in section: cylinder, carriage, target, and the valve with its five ports.
import { pressureColour } from "./colours.js";

const NS = "http://www.w3.org/2000/svg";

// Where the piston's centre is at 0 and at the full stroke, and half its length; in drawing units.
const LEFT = 262;
const RIGHT = 938;
const HALF = 82;

// The spool moves a millimetre: drawn larger, by so many units per mm of eq. (24).
const SPOOL_SCALE = 34;
const MM_PER_VOLT = 0.21485;

const SECTION = `
<defs>
  <linearGradient id="scale">
    <stop offset="0" stop-color="rgb(0,32,76)"/><stop offset=".25" stop-color="rgb(60,77,110)"/>
    <stop offset=".5" stop-color="rgb(124,123,120)"/>
    <stop offset=".75" stop-color="rgb(187,173,108)"/><stop offset="1" stop-color="rgb(255,233,69)"/>
  </linearGradient>
  <pattern id="piston" width="10" height="10" patternUnits="userSpaceOnUse">
    <rect width="10" height="10" fill="#555"/><rect width="5" height="10" fill="#999"/>
  </pattern>
</defs>
<g class="ruler"></g>
<line class="want" x1="0" x2="0" y1="62" y2="214"/>
<rect class="metal" x="124" y="132" width="56" height="88" rx="4"/>
<rect class="metal" x="1020" y="132" width="56" height="88" rx="4"/>
<rect class="tube" x="180" y="140" width="840" height="72"/>
<rect class="a" x="180" y="146" height="60"/>
<rect class="b" y="146" height="60"/>
<g class="moving">
  <rect class="piston" x="-82" y="146" width="164" height="60"/>
  <text class="mid alone" x="0" y="183" text-anchor="middle">piston</text>
</g>
<path class="apart" d=""/>
<g class="carried">
  <path class="carriage" d="M-84,96 h168 v40 h-168 z M-84,216 h168 v12 h-168 z"/>
  <text class="big" x="0" y="124" text-anchor="middle"></text>
</g>
<rect class="shadow" x="-84" y="96" width="168" height="132" rx="5"/>
<g class="target" tabindex="0" role="slider" aria-label="Target of the carriage, mm">
  <rect class="grip" x="-84" y="0" width="168" height="78"/>
  <path class="pointer" d="M0,64 l-15,-24 h30 z"/>
  <text class="mid" x="0" y="28" text-anchor="middle"></text>
</g>
<text class="mid" x="20" y="166">A</text><text class="mid pa" x="20" y="192"></text>
<text class="mid" x="1098" y="166">B</text><text class="mid pb" x="1098" y="192"></text>
<text class="big motion" x="600" y="258" text-anchor="middle"></text>

<path class="pipe pipe-a" d="M530,316 V286 H152 V220"/>
<path class="pipe pipe-b" d="M670,316 V286 H1048 V220"/>
<path class="pipe" d="M460,376 V404"/><path class="pipe supply" d="M600,376 V404"/>
<path class="pipe" d="M740,376 V404"/>
<rect class="metal" x="350" y="312" width="500" height="68" rx="4"/>
<rect class="bore" x="360" y="322" width="480" height="48"/>
<g class="rooms">
  <rect class="room exhaust-a" x="360" y="322" width="170" height="48"/>
  <rect class="room feed" x="530" y="322" width="140" height="48"/>
  <rect class="room exhaust-b" x="670" y="322" width="170" height="48"/>
</g>
<rect class="port port-a" x="512" y="312" width="36" height="10"/>
<rect class="port port-b" x="652" y="312" width="36" height="10"/>
<rect class="port" x="444" y="370" width="32" height="10"/>
<rect class="port feed" x="584" y="370" width="32" height="10"/>
<rect class="port" x="724" y="370" width="32" height="10"/>
<g class="spool">
  <rect class="rod" x="400" y="341" width="400" height="10"/>
  <rect class="land" x="511" y="322" width="38" height="48"/>
  <rect class="land" x="651" y="322" width="38" height="48"/>
</g>
<path class="flow under f0" d="M600,404 V358 Q600,336 575,336 Q530,336 530,318 V286 H152 V216"/>
<path class="flow f0" d="M600,404 V358 Q600,336 575,336 Q530,336 530,318 V286 H152 V216"/>
<path class="flow under f1" d="M152,216 V286 H530 V318 Q530,336 490,336 Q460,336 460,358 V404"/>
<path class="flow f1" d="M152,216 V286 H530 V318 Q530,336 490,336 Q460,336 460,358 V404"/>
<path class="flow under f2" d="M600,404 V358 Q600,336 625,336 Q670,336 670,318 V286 H1048 V216"/>
<path class="flow f2" d="M600,404 V358 Q600,336 625,336 Q670,336 670,318 V286 H1048 V216"/>
<path class="flow under f3" d="M1048,216 V286 H670 V318 Q670,336 710,336 Q740,336 740,358 V404"/>
<path class="flow f3" d="M1048,216 V286 H670 V318 Q670,336 710,336 Q740,336 740,358 V404"/>
<text class="mid" x="508" y="308" text-anchor="end">4</text>
<text class="mid" x="692" y="308">2</text>
<text class="small out-a" x="460" y="426" text-anchor="middle"></text>
<text class="small in" x="600" y="426" text-anchor="middle"></text>
<text class="small out-b" x="740" y="426" text-anchor="middle"></text>
<text class="small" x="440" y="400" text-anchor="end">5 exhaust</text>
<text class="small" x="614" y="400">1 supply</text>
<text class="small" x="760" y="400">3 exhaust</text>
<text class="mid" x="20" y="342">Valve</text><text class="big volts" x="20" y="376"></text>
<text class="small lands" x="20" y="404"></text>
<rect class="scale" x="880" y="338" width="260" height="18" fill="url(#scale)"/>
<text class="small" x="880" y="328">Pressure, kPa absolute</text>
<text class="small low" x="880" y="378"></text>
<text class="small high" x="1140" y="378" text-anchor="end"></text>
`;

const kilopascals = (p) => (p === null || p === undefined ? "–" : `${(p / 1e3).toFixed(0)} kPa`);
// Adding 0 makes a zero of -0, whose sign would be shown.
const millimetres = (x) => (Math.round(x * 1e4) / 10 + 0).toFixed(1);
const litres = (flow) => `${Math.abs(flow) < 0.05 ? "0.0" : flow.toFixed(1)} L/min`;

export class Scene {
  // onTarget(metres) is called while the target is dragged or stepped by keys.
  constructor(svg, onTarget) {
    this.svg = svg;
    svg.setAttribute("viewBox", "0 0 1200 432");
    svg.innerHTML = SECTION;
    svg.classList.add("empty");
    this.parts = {};
    this.shown = {};
    this.onTarget = onTarget;
    this.stroke = 0.2;
    this.atmosphere = 101325;
    this.closed = 5.08;
    this.supply = 6e5;
    this.target = null;
    this.held = null;
    this.locked = true;
    this.offsets = [0, 0, 0, 0];
    this.flows(null);
    this.listen();
  }

  part(name) {
    return (this.parts[name] ??= this.svg.querySelector(name));
  }

  // Writes what has changed alone: each write makes the browser lay out and paint anew.
  put(name, what, value) {
    const key = `${name} ${what}`;
    if (this.shown[key] === value) return;
    this.shown[key] = value;
    const part = this.part(name);
    if (what === "text") part.textContent = value;
    else if (what.startsWith("style.")) part.style[what.slice(6)] = value;
    else part.setAttribute(what, value);
  }

  setup({ stroke, atmosphere, closed, mode }) {
    this.stroke = stroke;
    this.atmosphere = atmosphere;
    this.closed = closed;
    this.isLive = mode === "live";
    if (this.isLive) this.ghost(null);
    this.ruler();
  }

  x(position) {
    return LEFT + (position / this.stroke) * (RIGHT - LEFT);
  }

  ruler() {
    const steps = this.stroke <= 0.25 ? 0.02 : this.stroke / 10;
    let marks = "";
    for (let k = 0; k * steps <= this.stroke + 1e-9; k++) {
      const at = this.x(k * steps);
      const length = k % 2 ? 6 : 10;
      marks += `<line class="tick" x1="${at}" x2="${at}" y1="68" y2="${68 + length}"/>`;
      if (k % 2 === 0) {
        const text = (k * steps * 1e3).toFixed(0);
        marks += `<text class="small" x="${at}" y="94" text-anchor="middle">${text}</text>`;
      }
    }
    const ends = `x1="${LEFT}" x2="${RIGHT}"`;
    const unit = `<text class="small" x="${RIGHT + 34}" y="94">mm</text>`;
    this.part(".ruler").innerHTML = `<line class="tick" ${ends} y1="68" y2="68"/>${marks}${unit}`;
  }

  // A row of samples, and how it is drawn: where the spool is (V), whether the magnets have parted,
  // words, and flows in L/min past the four edges, if known.
  update(row, { spool, lost, motion, valve, flows }) {
    const [, position, , a, b, supply, voltage, , , piston] = row;
    if (supply) this.supply = supply;
    if (position !== null) this.carriage(position, piston ?? position, lost, a, b);
    this.put(".motion", "text", motion);
    this.put(".pa", "text", kilopascals(a));
    this.put(".pb", "text", kilopascals(b));
    this.put(".low", "text", (this.atmosphere / 1e3).toFixed(0));
    this.put(".high", "text", (this.supply / 1e3).toFixed(0));
    this.valve(voltage, spool, valve, a, b);
    this.flows(flows);
  }

  colour(pressure) {
    return pressureColour(pressure, this.atmosphere, Math.max(this.supply, this.atmosphere + 1e5));
  }

  carriage(position, piston, lost, a, b) {
    this.svg.classList.remove("empty");
    const at = this.x(piston);
    const carried = this.x(position);
    const left = Math.max(at - HALF - 180, 0);
    this.put(".a", "width", left.toFixed(2));
    this.put(".b", "x", (at + HALF).toFixed(2));
    this.put(".b", "width", Math.max(1020 - at - HALF, 0).toFixed(2));
    this.put(".a", "style.fill", this.colour(a));
    this.put(".b", "style.fill", this.colour(b));
    this.put(".moving", "transform", `translate(${at.toFixed(2)},0)`);
    this.put(".carried", "transform", `translate(${carried.toFixed(2)},0)`);
    this.svg.classList.toggle("lost", lost);
    if (lost) this.put(".apart", "d", `M${carried.toFixed(2)},176 H${at.toFixed(2)}`);
    this.put(".carried text", "text", `${millimetres(position)} mm`);
  }

  valve(voltage, spool, words, a, b) {
    const known = voltage !== null && voltage !== undefined;
    this.put(".volts", "text", known ? `${voltage.toFixed(2)} V` : "–");
    const away = spool === null ? 0 : Math.min(Math.max(spool, 0), 10) - this.closed;
    // Towards 5 the land of port 4 opens it to the supply, and that of port 2 opens it to 3.
    const shift = -away * MM_PER_VOLT * SPOOL_SCALE;
    this.put(".spool", "transform", `translate(${shift.toFixed(2)},0)`);
    this.put(".feed", "style.fill", this.colour(this.supply));
    this.put(".port.feed", "style.fill", this.colour(this.supply));
    this.put(".supply", "style.stroke", this.colour(this.supply));
    this.put(".pipe-a", "style.stroke", this.colour(a));
    this.put(".port-a", "style.fill", this.colour(a));
    this.put(".pipe-b", "style.stroke", this.colour(b));
    this.put(".port-b", "style.fill", this.colour(b));
    this.put(".lands", "text", words);
  }

  // The dashes move with the air; a line as wide as the flow is large.
  flows(flows) {
    for (let k = 0; k < 4; k++) {
      const flow = flows ? flows[k] : 0;
      const size = Math.abs(flow);
      const width = Math.min(1.5 + Math.sqrt(size), 8);
      this.offsets[k] -= Math.sign(flow) * Math.min(2 + size * 0.4, 10);
      for (const [line, edge] of [[`.f${k}.under`, 3], [`.f${k}:not(.under)`, 0]]) {
        this.put(line, "style.display", size < 0.05 ? "none" : "");
        if (size < 0.05) continue;
        this.put(line, "style.strokeWidth", (width + edge).toFixed(1));
        this.put(line, "style.strokeDashoffset", this.offsets[k].toFixed(1));
      }
    }
    this.put(".in", "text", flows ? litres(flows[0] + flows[2]) : "");
    this.put(".out-a", "text", flows ? litres(flows[1]) : "");
    this.put(".out-b", "text", flows ? litres(flows[3]) : "");
  }

  ghost(position) {
    const shadow = this.part(".shadow");
    shadow.style.display = position === null ? "none" : "";
    if (position !== null) shadow.setAttribute("transform", `translate(${this.x(position)},0)`);
  }

  // Target: what the rig says, or where the user holds it.

  setTarget(target, locked) {
    this.target = target;
    this.locked = locked;
    this.drawTarget();
  }

  drawTarget() {
    const shown = this.held ?? this.target;
    const hidden = shown === null || !this.isLive;
    for (const name of [".target", ".want"]) this.put(name, "style.display", hidden ? "none" : "");
    if (shown === null) return;
    const at = `translate(${this.x(shown).toFixed(2)},0)`;
    for (const name of [".target", ".want"]) this.put(name, "transform", at);
    this.part(".target").classList.toggle("locked", this.locked);
    this.put(".target", "aria-valuenow", millimetres(shown));
    this.put(".target", "aria-valuemin", "0");
    this.put(".target", "aria-valuemax", millimetres(this.stroke));
    this.put(".target", "aria-disabled", String(this.locked));
    this.put(".target text", "text", `target ${millimetres(shown)} mm`);
  }

  at(event) {
    const point = new DOMPoint(event.clientX, event.clientY);
    const { x } = point.matrixTransform(this.svg.getScreenCTM().inverse());
    return ((x - LEFT) / (RIGHT - LEFT)) * this.stroke;
  }

  hold(position) {
    this.held = Math.round(Math.min(Math.max(position, 0), this.stroke) * 1e4) / 1e4;
    this.drawTarget();
    this.onTarget(this.held, false);
  }

  listen() {
    const group = this.part(".target");
    group.addEventListener("pointerdown", (event) => {
      if (this.locked) return;
      this.grip = this.at(event) - (this.held ?? this.target ?? 0);
      group.setPointerCapture(event.pointerId);
      group.focus();
      this.hold(this.at(event) - this.grip);
      event.preventDefault();
    });
    group.addEventListener("pointermove", (event) => {
      if (this.held !== null && group.hasPointerCapture(event.pointerId)) {
        this.hold(this.at(event) - this.grip);
      }
    });
    const release = () => {
      if (this.held === null) return;
      this.onTarget(this.held, true);
      this.target = this.held;
      this.held = null;
    };
    group.addEventListener("pointerup", release);
    group.addEventListener("pointercancel", release);
    const keys = { ArrowRight: 1e-3, ArrowUp: 1e-3, ArrowLeft: -1e-3, ArrowDown: -1e-3 };
    const jumps = { Home: 0, End: Infinity };
    group.addEventListener("keydown", (event) => {
      if (this.locked || this.target === null) return;
      if (event.key in keys) {
        const step = keys[event.key] * (event.shiftKey ? 10 : 1);
        this.hold(this.target + step);
      } else if (event.key in jumps) {
        this.hold(jumps[event.key]);
      } else {
        return;
      }
      event.preventDefault();
      release();
    });
  }
}
