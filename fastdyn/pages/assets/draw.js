// Draws curves, with axes by uPlot, and the motion.

const INK = "#444", FAINT = "#e4e4e4";

// A picture of curves: [{x, y, colour, dash}], and of points: [{x, y, colour}].
class Plot {
  constructor(place, height) {
    this.place = place;
    this.height = height;
    this.curves = [];
    this.points = [];
    this.range = { x: [0, 1], y: [0, 1] };
    this.labels = ["", ""];
    this.equal = false;
    this.handle = null;
    const axis = (k) => ({
      stroke: INK, grid: { stroke: FAINT, width: 1 }, ticks: { stroke: FAINT, width: 1 },
      font: "12px system-ui, sans-serif", labelFont: "13px system-ui, sans-serif",
      size: k ? (u, ticks) => 14 + 7.5 * Math.max(3, ...(ticks || []).map((one) => one.length)) : 34,
      labelSize: 20, label: () => this.labels[k], labelGap: 0,
      values: (u, ticks) => ticks.map((x) => shown(x, 6)),
    });
    this.u = new uPlot({
      width: Math.max(place.clientWidth, 50), height, legend: { show: false },
      cursor: { drag: { x: false, y: false }, points: { show: false }, y: true },
      padding: [8, 12, 0, 0],
      scales: { x: { time: false, range: () => this.range.x }, y: { range: () => this.range.y } },
      axes: [axis(0), axis(1)],
      series: [{}, { paths: (u) => this.draw(u) }],
      hooks: { draw: [() => this.placeHandle()] },
    }, [[0, 1], [0, 1]], place);
    new ResizeObserver(() => {
      const width = place.clientWidth;
      if (width === 0 || width === this.u.width) return;
      this.u.setSize({ width, height: this.height });
      if (this.equal) requestAnimationFrame(() => this.sameScale());
    }).observe(place);
  }

  show(curves, points, labels, equal = false) {
    Object.assign(this, { curves, points, labels, equal });
    const x = bounds(curves.map((one) => one.x)), y = bounds(curves.map((one) => one.y));
    this.range = { x: curves.some((one) => one.whole) ? x : padded(x), y: padded(y) };
    this.u.setData([this.range.x, this.range.y], true);
    if (equal) this.sameScale();
  }

  sameScale() {
    const { width, height } = this.u.bbox, { x, y } = this.range;
    const scale = Math.max((x[1] - x[0]) / width, (y[1] - y[0]) / height);
    for (const [side, size] of [[x, width], [y, height]]) {
      const middle = 0.5 * (side[0] + side[1]);
      side[0] = middle - 0.5 * scale * size;
      side[1] = middle + 0.5 * scale * size;
    }
    this.u.setData([x, y], true);
  }

  draw(u) {
    const { left, top, width, height } = u.bbox, { x, y } = this.range, { ctx } = u;
    const ratio = devicePixelRatio, a = width / (x[1] - x[0]), b = height / (y[1] - y[0]);
    ctx.save();
    ctx.beginPath();
    ctx.rect(left, top, width, height);
    ctx.clip();
    ctx.lineJoin = "round";
    for (const one of this.curves) {
      ctx.strokeStyle = one.colour;
      ctx.lineWidth = 2 * ratio;
      ctx.setLineDash(one.dash ? [7 * ratio, 4 * ratio] : []);
      ctx.beginPath();
      for (let i = 0; i < one.x.length; i++) {
        ctx.lineTo(left + a * (one.x[i] - x[0]), top + b * (y[1] - one.y[i]));
      }
      ctx.stroke();
    }
    ctx.setLineDash([]);
    for (const one of this.points) {
      ctx.fillStyle = one.colour;
      ctx.beginPath();
      ctx.arc(left + a * (one.x - x[0]), top + b * (y[1] - one.y), 4 * ratio, 0, 2 * Math.PI);
      ctx.fill();
    }
    ctx.restore();
    return null;
  }

  // A handle at (x, y), which calls moved(x, y) while it is dragged.
  drag(moved) {
    this.handle = handle(this.u.over, "drag the start", (px, py) => {
      const { clientWidth: w, clientHeight: h } = this.u.over, { x, y } = this.held || this.range;
      moved(x[0] + (x[1] - x[0]) * px / w, y[1] - (y[1] - y[0]) * py / h);
    }, (begins) => { this.held = begins ? { x: [...this.range.x], y: [...this.range.y] } : null; });
  }

  placeHandle() {
    const { at } = this; // the place of the handle
    if (!this.handle || !at) return;
    const { clientWidth: w, clientHeight: h } = this.u.over, { x, y } = this.range;
    this.handle.style.left = `${w * (at[0] - x[0]) / (x[1] - x[0])}px`;
    this.handle.style.top = `${h * (y[1] - at[1]) / (y[1] - y[0])}px`;
  }
}

// A round button over a picture that a finger or a mouse drags.
function handle(place, title, moved, held) {
  const made = document.createElement("button");
  made.type = "button";
  made.className = "handle";
  made.title = title;
  made.setAttribute("aria-label", title);
  made.addEventListener("pointerdown", (event) => {
    made.setPointerCapture(event.pointerId);
    made.classList.add("held");
    held(true);
    event.preventDefault();
    event.stopPropagation();
  });
  made.addEventListener("pointermove", (event) => {
    if (!made.classList.contains("held")) return;
    const box = place.getBoundingClientRect();
    moved(event.clientX - box.left, event.clientY - box.top);
  });
  for (const name of ["pointerup", "pointercancel"]) {
    made.addEventListener(name, () => {
      made.classList.remove("held");
      held(false);
    });
  }
  place.append(made);
  return made;
}

// The moving picture. `scene` has the parts of a picture, see `functions.py`.
class Stage {
  constructor(canvas, scene, colours) {
    Object.assign(this, { canvas, scene, colours, trails: [[], []], box: [-1, 1, -1, 1] });
    this.ratio = devicePixelRatio || 1;
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  resize() {
    this.ratio = devicePixelRatio || 1;
    this.canvas.width = Math.max(1, Math.round(this.canvas.clientWidth * this.ratio));
    this.canvas.height = Math.max(1, Math.round(this.canvas.clientHeight * this.ratio));
    this.fit();
  }

  // The region that shows all of some pictures.
  frame(pictures) {
    let x0 = Infinity, x1 = -Infinity, y0 = Infinity, y1 = -Infinity;
    for (const coordinates of pictures) {
      let at = 0;
      for (const [, n] of this.scene.parts) {
        for (let i = 0; i < n; i++) {
          const x = coordinates[at + i], y = coordinates[at + n + i];
          if (x < x0) x0 = x;
          if (x > x1) x1 = x;
          if (y < y0) y0 = y;
          if (y > y1) y1 = y;
        }
        at += 2 * n;
      }
    }
    if (this.scene.ground !== null) y0 = Math.min(y0, this.scene.ground);
    const size = Math.max(x1 - x0, y1 - y0, 1e-9);
    const pad = (low, high) => {
      const half = Math.max(0.57 * (high - low), 0.3 * size), middle = 0.5 * (low + high);
      return [middle - half, middle + half];
    };
    this.region = [...pad(x0, x1), ...pad(y0, y1)];
    this.fit();
  }

  fit() {
    if (!this.region) return;
    const [x0, x1, y0, y1] = this.region, { width, height } = this.canvas;
    const scale = Math.min(width / (x1 - x0), height / (y1 - y0)), sign = this.scene.down ? 1 : -1;
    this.scale = scale;
    this.x = (x) => 0.5 * width + scale * (x - 0.5 * (x0 + x1));
    this.y = (y) => 0.5 * height + sign * scale * (y - 0.5 * (y0 + y1));
    this.inverse = (px, py) => [
      0.5 * (x0 + x1) + (px * this.ratio - 0.5 * width) / scale,
      0.5 * (y0 + y1) + sign * (py * this.ratio - 0.5 * height) / scale,
    ];
  }

  // Coordinates of each way; the trails are arrays of x, y.
  draw(pictures, trails) {
    const context = this.canvas.getContext("2d"), { width, height } = this.canvas;
    context.clearRect(0, 0, width, height);
    if (this.scene.ground !== null) {
      context.fillStyle = this.colours.ground;
      context.fillRect(0, this.y(this.scene.ground), width, height);
    }
    if (!this.scene.space) this.rule(context);
    for (let way = pictures.length - 1; way >= 0; way--) {
      this.one(context, pictures[way], trails[way] || [], way);
    }
  }

  // A line of a round length, so that a picture without axes has a scale.
  rule(context) {
    const wanted = 0.22 * this.canvas.width / this.scale, power = 10 ** Math.floor(Math.log10(wanted));
    const length = [5, 2, 1].map((n) => n * power).find((x) => x <= wanted) || power;
    const unit = (this.scene.axes[0].match(/\(([^)]*)\)/) || ["", ""])[1];
    const left = 12 * this.ratio, low = this.canvas.height - 12 * this.ratio;
    context.strokeStyle = context.fillStyle = "#666";
    context.lineWidth = 2 * this.ratio;
    context.setLineDash([]);
    context.beginPath();
    context.moveTo(left, low);
    context.lineTo(left + length * this.scale, low);
    context.stroke();
    context.font = `${12 * this.ratio}px system-ui, sans-serif`;
    context.fillText(`${shown(length, 3)} ${unit}`, left, low - 6 * this.ratio);
  }

  one(context, coordinates, trail, way) {
    const second = way > 0, colour = this.colours.ways[way];
    const line = (xs, closed) => {
      context.beginPath();
      let lifted = true;
      for (let i = 0; i < xs.n; i++) {
        const x = coordinates[xs.at + i], y = coordinates[xs.at + xs.n + i];
        if (x !== x) { lifted = true; continue; }
        if (lifted) context.moveTo(this.x(x), this.y(y)); else context.lineTo(this.x(x), this.y(y));
        lifted = false;
      }
      if (closed) context.closePath();
    };
    const dot = (at, size) => {
      context.beginPath();
      context.arc(this.x(coordinates[at]), this.y(coordinates[at + 1]), size * this.ratio, 0, 7);
      context.fill();
    };
    context.lineJoin = "round";
    context.setLineDash(second ? [6 * this.ratio, 4 * this.ratio] : []);
    context.strokeStyle = second ? colour : this.colours.trail;
    context.globalAlpha = second ? 0.5 : 1;
    context.lineWidth = 1.5 * this.ratio;
    context.beginPath();
    for (let i = 0; i < trail.length; i += 2) context.lineTo(this.x(trail[i]), this.y(trail[i + 1]));
    context.stroke();
    context.globalAlpha = 1;
    context.lineWidth = 2 * this.ratio;
    let at = 0;
    for (const [kind, n] of this.scene.parts) {
      context.strokeStyle = second ? colour : "#4d4d4d";
      if (kind === "bodies") {
        line({ at, n }, true);
        context.fillStyle = this.colours.body;
        if (!second) context.fill();
        context.stroke();
      } else if (kind === "lines") {
        line({ at, n }, false);
        context.stroke();
      } else if (kind === "fixed" && !second) {
        context.fillStyle = "#888";
        dot(at, 4.5);
      } else if (kind === "points") {
        context.fillStyle = colour;
        dot(at, second ? 5 : 7);
      }
      at += 2 * n;
    }
  }
}

function bounds(columns) {
  let low = Infinity, high = -Infinity;
  for (const column of columns) {
    for (let i = 0; i < column.length; i++) {
      if (column[i] < low) low = column[i];
      if (column[i] > high) high = column[i];
    }
  }
  return low <= high ? [low, high] : [0, 1];
}

function padded([low, high]) {
  const size = high - low || Math.abs(high) * 1e-3 || 1e-12;
  return [low - 0.05 * size, high + 0.05 * size];
}

// A number as a person would write it, with at most so many digits.
function shown(x, digits) {
  if (!Number.isFinite(x)) return x !== x ? "–" : x > 0 ? "∞" : "−∞";
  const text = Number(x.toPrecision(digits)), size = Math.abs(text);
  if (size !== 0 && (size < 1e-4 || size >= 1e6)) {
    const [head, power] = text.toExponential().split("e");
    return `${head}·10${[...String(Number(power))].map((c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] || "⁻").join("")}`;
  }
  return String(text).replace("-", "−");
}
