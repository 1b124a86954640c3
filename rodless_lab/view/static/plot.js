// A plot of lines against time on a canvas.
const FONT = "system-ui, 'DejaVu Sans', sans-serif";

// Steps of 1, 2 or 5 times a power of ten: at most `most` of them in `span`.
export function niceStep(span, most) {
  const raw = span / most;
  const power = 10 ** Math.floor(Math.log10(raw));
  return [1, 2, 5, 10].map((k) => k * power).find((step) => step >= raw);
}

// Multiples of a step from low to high. Counted from 0: where numbers are so large that adding 1 to
// them changes nothing, a count of their own would never end.
export function wholeSteps(low, high, step) {
  const first = Math.ceil(low / step - 1e-9);
  const length = Math.min(Math.floor(high / step + 1e-9) - first + 1, 100);
  return Array.from({ length }, (_, n) => (first + n) * step);
}

export class Plot {
  // options: title, unit, scale (unit per SI unit), offset (SI), span (least, in unit), and series:
  // {column, label, colour, dash}.
  constructor(canvas, options) {
    this.canvas = canvas;
    this.options = options;
  }

  // data: lists of rows, each drawn with the same series, the second one fainter.
  // The times stand below the last plot alone.
  draw(data, from, to, isLast, cursor = null) {
    const { canvas } = this;
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth;
    const height = canvas.clientHeight;
    if (!width || !height) return;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const g = canvas.getContext("2d");
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, width, height);
    const size = Math.max(13, Math.min(20, Math.round(width / 75)));
    const box = {
      left: size * 4,
      right: width - size,
      top: size * 1.9,
      bottom: height - size * (isLast ? 1.6 : 0.5),
    };
    const most = Math.max(2, (box.bottom - box.top) / (size * 1.7));
    const { low, high, step } = this.range(data, from, to, most);
    const x = (t) => box.left + ((t - from) / (to - from)) * (box.right - box.left);
    const y = (v) => box.bottom - ((v - low) / (high - low)) * (box.bottom - box.top);
    this.axes(g, box, size, { from, to, low, high, step, isLast }, x, y);
    g.save();
    g.beginPath();
    g.rect(box.left, box.top - 2, box.right - box.left, box.bottom - box.top + 4);
    g.clip();
    data.forEach((rows, place) => this.lines(g, rows, place, from, to, x, y));
    if (cursor !== null) {
      g.strokeStyle = "#111";
      g.lineWidth = 2;
      g.setLineDash([]);
      g.beginPath();
      g.moveTo(x(cursor), box.top);
      g.lineTo(x(cursor), box.bottom);
      g.stroke();
    }
    g.restore();
    this.legend(g, box, size);
  }

  value(row, column) {
    const found = row[column];
    const { scale, offset = 0 } = this.options;
    return found === null || found === undefined ? null : (found - offset) * scale;
  }

  // Bounds on whole steps, at most about so many: both have a number, and they stay where they are
  // while the lines move a little.
  range(data, from, to, most) {
    let low = Infinity;
    let high = -Infinity;
    for (const rows of data) {
      for (const row of rows) {
        if (row[0] < from || row[0] > to) continue;
        for (const { column } of this.options.series) {
          const v = this.value(row, column);
          if (v === null) continue;
          if (v < low) low = v;
          if (v > high) high = v;
        }
      }
    }
    if (low > high) [low, high] = [0, this.options.span];
    const missing = this.options.span - (high - low);
    if (missing > 0) {
      low -= missing / 2;
      high += missing / 2;
    }
    const step = niceStep(high - low, most);
    // Noise about a number costs no step of its own.
    const whole = { low: Math.floor(low / step + 0.02), high: Math.ceil(high / step - 0.02) };
    return { low: whole.low * step, high: whole.high * step, step };
  }

  axes(g, box, size, { from, to, low, high, step, isLast }, x, y) {
    const { title, unit } = this.options;
    g.font = `${size}px ${FONT}`;
    g.lineWidth = 1;
    g.setLineDash([]);
    g.strokeStyle = "#dddddd";
    g.fillStyle = "#333333";
    g.textBaseline = "middle";
    g.textAlign = "right";
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    for (const v of wholeSteps(low, high, step)) {
      g.beginPath();
      g.moveTo(box.left, y(v));
      g.lineTo(box.right, y(v));
      g.stroke();
      g.fillText((v === 0 ? 0 : v).toFixed(digits), box.left - 6, y(v));
    }
    g.textAlign = "center";
    g.textBaseline = "top";
    const pace = niceStep(to - from, Math.max(2, Math.floor((box.right - box.left) / (size * 6))));
    const decimals = Math.max(0, -Math.floor(Math.log10(pace) + 1e-9));
    for (const t of wholeSteps(from, to, pace)) {
      const at = x(t);
      g.beginPath();
      g.moveTo(at, box.top);
      g.lineTo(at, box.bottom);
      g.stroke();
      if (isLast && at < box.right - size) g.fillText(t.toFixed(decimals), at, box.bottom + 4);
    }
    g.textAlign = "right";
    if (isLast) g.fillText("s", box.right + size * 0.7, box.bottom + 4);
    g.textAlign = "left";
    g.textBaseline = "middle";
    g.font = `600 ${size}px ${FONT}`;
    g.fillStyle = "#111111";
    g.fillText(`${title}, ${unit}`, 4, size * 0.85);
  }

  lines(g, rows, place, from, to, x, y) {
    g.lineJoin = "round";
    g.globalAlpha = place ? 0.45 : 1;
    for (const { column, colour, dash } of this.options.series) {
      g.strokeStyle = colour;
      g.lineWidth = place ? 4 : 2.5;
      g.setLineDash(dash || []);
      g.beginPath();
      let drawing = false;
      for (const row of rows) {
        const v = row[0] < from ? null : this.value(row, column);
        if (v === null || row[0] > to) {
          drawing = false;
        } else if (drawing) {
          g.lineTo(x(row[0]), y(v));
        } else {
          g.moveTo(x(row[0]), y(v));
          drawing = true;
        }
      }
      g.stroke();
    }
    g.globalAlpha = 1;
  }

  legend(g, box, size) {
    g.font = `${size}px ${FONT}`;
    g.textAlign = "right";
    g.textBaseline = "middle";
    let right = box.right;
    for (const { label, colour, dash } of [...this.options.series].reverse()) {
      g.fillStyle = "#111111";
      g.fillText(label, right, size * 0.85);
      right -= g.measureText(label).width + 6;
      g.strokeStyle = colour;
      g.lineWidth = 3;
      g.setLineDash(dash || []);
      g.beginPath();
      g.moveTo(right - 26, size * 0.85);
      g.lineTo(right, size * 0.85);
      g.stroke();
      right -= 26 + size;
    }
  }
}
