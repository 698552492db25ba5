// A plot of points that is redrawn for each width, with the name of the point nearest to the pointer.

const SVG = "http://www.w3.org/2000/svg";
const shape = (name, attributes, text = "") => {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.textContent = text;
  return made;
};

// An axis for values: logarithmic if they are positive and of different magnitudes. `at` is a fraction of its length.
class Axis {
  constructor(values, most) {
    let low = Infinity;
    let high = -Infinity;
    for (const value of values) {
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
    this.logarithmic = low > 0 && high > 20 * low;
    const own = (x) => (this.logarithmic ? Math.log10(x) : x);
    const span = own(high) - own(low) || Math.abs(own(high)) || 1;
    this.low = own(low) - 0.06 * span;
    this.high = own(high) + 0.06 * span;
    this.own = own;
    this.ticks = (this.logarithmic ? this.powers(most) : this.steps(most));
  }

  at(value) { return (this.own(value) - this.low) / (this.high - this.low); }

  // Multiples of 1, 2 or 5 times a power of ten.
  steps(most) {
    const rough = (this.high - this.low) / most;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough);
    const ticks = [];
    for (let i = Math.ceil(this.low / step); i * step <= this.high; i += 1) ticks.push(Number((i * step).toPrecision(12)));
    return ticks;
  }

  // 1, 2 and 5 of each decade, or powers of ten for many decades.
  powers(most) {
    const decades = this.high - this.low;
    const marks = 3 * decades <= most ? [1, 2, 5] : [1];
    const every = Math.max(1, Math.ceil(decades / most));
    const ticks = [];
    for (let d = Math.floor(this.low); d <= this.high; d += every) ticks.push(...marks.map((mark) => mark * 10 ** d));
    return ticks.filter((x) => this.own(x) >= this.low && this.own(x) <= this.high);
  }
}

// The label of a tick without rounding errors.
const tickLabel = (x) => {
  const size = Math.abs(x);
  if (x !== 0 && (size < 1e-3 || size >= 1e4)) return x.toExponential().replace("e+", "e");
  return String(Number(x.toPrecision(6)));
};

const MARGINS = { left: 66, right: 14, top: 10, bottom: 42 };

class ScatterCard {
  // `choose` takes the point of a click; a point for which `mark` holds has a ring.
  constructor(plot, choose = null) {
    this.plot = plot;
    this.mark = () => false;
    this.points = plot.groups.flatMap((group) => group.points.map(([x, y, name]) => ({ x, y, name, group })));
    this.svg = shape("svg", { role: "img", "aria-label": `${plot.title}: ${plot.y} against ${plot.x}` });
    this.readout = element("div", "tip");
    this.readout.hidden = true;
    this.area = element("div", "plot-area", "", [this.svg, this.readout]);
    const entries = plot.groups.map((group) => {
      const swatch = element("i", "swatch");
      swatch.style.background = group.failed ? "none" : group.color;
      if (group.failed) {
        swatch.classList.add("cross");
        swatch.style.color = group.color;
        swatch.textContent = "×";
      }
      return element("span", "entry", "", [swatch, element("span", "", `${group.name} (${group.points.length})`)]);
    });
    this.root = element("figure", "plot scatter", "", [element("h3", "", plot.title), this.area, element("div", "legend", "", entries)]);
    this.root.dataset.title = plot.title;
    if (!this.points.length) {
      this.area.replaceChildren(element("p", "hint", "There is nothing to draw."));
      return;
    }
    new ResizeObserver(() => this.draw()).observe(this.area);
    this.area.addEventListener("pointermove", (event) => this.point(event));
    this.area.addEventListener("pointerdown", (event) => this.point(event));
    if (choose) {
      this.area.classList.add("seekable");
      this.area.addEventListener("click", (event) => {
        const nearest = this.point(event);
        if (nearest) choose(nearest);
      });
    }
    this.area.addEventListener("pointerleave", () => this.leave());
  }

  draw() {
    const width = Math.floor(this.area.clientWidth);
    if (!width || width === this.width) return;
    this.width = width;
    const height = Math.round(clamp(0.58 * width, 220, 380));
    const { left, right, top, bottom } = MARGINS;
    const [across, up] = [width - left - right, height - top - bottom];
    const x = new Axis(this.points.map((point) => point.x), Math.max(3, across / 55));
    const y = new Axis(this.points.map((point) => point.y), Math.max(3, up / 40));
    for (const point of this.points) point.at = [left + across * x.at(point.x), top + up * (1 - y.at(point.y))];
    for (const [key, value] of Object.entries({ width, height, viewBox: `0 0 ${width} ${height}` })) this.svg.setAttribute(key, value);
    const parts = [];
    for (const tick of x.ticks) {
      const at = left + across * x.at(tick);
      parts.push(shape("line", { class: "rule", x1: at, x2: at, y1: top, y2: top + up }));
      parts.push(shape("text", { x: at, y: top + up + 16, "text-anchor": "middle" }, tickLabel(tick)));
    }
    for (const tick of y.ticks) {
      const at = top + up * (1 - y.at(tick));
      parts.push(shape("line", { class: "rule", x1: left, x2: left + across, y1: at, y2: at }));
      parts.push(shape("text", { x: left - 7, y: at + 4, "text-anchor": "end" }, tickLabel(tick)));
    }
    parts.push(shape("text", { class: "name", x: left + across / 2, y: height - 6, "text-anchor": "middle" }, this.plot.x));
    parts.push(shape("text", { class: "name", transform: `translate(13 ${top + up / 2}) rotate(-90)`, "text-anchor": "middle" }, this.plot.y));
    this.plot.groups.forEach((group) => {
      const own = this.points.filter((point) => point.group === group);
      const place = ([a, b]) => `${a.toFixed(1)} ${b.toFixed(1)}`;
      // All points of a group are one path: a dot is a line of length zero with round ends.
      const mark = group.failed ? "m-4 -4 l8 8 m0 -8 l-8 8" : "h0";
      const className = group.failed ? "crosses" : "dots";
      parts.push(shape("path", { class: className, stroke: group.color, d: own.map((point) => `M${place(point.at)} ${mark}`).join("") }));
    });
    for (const { at } of this.points.filter(this.mark)) {
      parts.push(shape("circle", { class: "ring", r: 7, cx: at[0], cy: at[1] }));
    }
    this.ring = shape("circle", { class: "ring", r: 7, visibility: "hidden" });
    parts.push(this.ring);
    this.svg.replaceChildren(...parts);
  }

  point(event) {
    const box = this.area.getBoundingClientRect();
    const at = [event.clientX - box.left, event.clientY - box.top];
    const off = (point) => Math.hypot(point.at[0] - at[0], point.at[1] - at[1]);
    const nearest = this.points.reduce((best, point) => (off(point) < off(best) ? point : best));
    if (off(nearest) > 40) {
      this.leave();
      return null;
    }
    for (const [key, value] of [["cx", nearest.at[0]], ["cy", nearest.at[1]], ["visibility", "visible"]]) this.ring.setAttribute(key, value);
    showTip(this.readout, this.area, nearest.at, nearest.name);
    return nearest;
  }

  leave() {
    this.readout.hidden = true;
    this.ring.setAttribute("visibility", "hidden");
  }
}

// Shows a text beside a point of an area, inside the area.
const showTip = (tip, area, [x, y], text) => {
  tip.hidden = false;
  tip.textContent = text;
  const left = clamp(x - tip.offsetWidth / 2, 0, Math.max(0, area.clientWidth - tip.offsetWidth));
  const above = y - tip.offsetHeight - 12;
  tip.style.left = `${left}px`;
  tip.style.top = `${above < 0 ? y + 14 : above}px`;
};

// A bar for each value: the share of solves that succeed.
const barsCard = ({ title, bars }) => {
  const rows = bars.flatMap(({ name, good, all }) => {
    const share = (100 * good) / (all || 1);
    const bar = element("i", "share");
    bar.style.width = `${share}%`;
    const track = element("span", "shares-track", "", [bar]);
    const told = element("span", "told", `${share.toFixed(share > 0 && share < 10 ? 1 : 0)} %`);
    for (const one of [track, told]) one.title = `${name}: ${good} of ${all} succeed`;
    return [element("span", "value", name), track, told];
  });
  const root = element("figure", "plot", "", [element("h3", "", title), element("div", "shares", "", rows)]);
  root.dataset.title = title;
  return { root };
};
