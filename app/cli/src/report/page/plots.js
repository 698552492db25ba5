// Plots: SVG of the report, a cursor, values at the pointer, and a click that moves the clock.

class PlotCard {
  // `joints` are those of a plot with a curve for each; `seek` takes a time.
  constructor(plot, motion, seek) {
    this.plot = plot;
    this.joints = plot.per_joint ? motion.joints : null;
    const heading = element("h3", "", plot.title, plot.unit ? [element("span", "unit", `, ${plot.unit}`)] : []);
    this.readout = element("span", "readout");
    this.svg = svgOf(plot.svg);
    this.svg.removeAttribute("width");
    this.svg.removeAttribute("height");
    this.svg.setAttribute("role", "img");
    this.svg.setAttribute("aria-label", `${plot.title}, ${plot.unit}`);
    this.cursor = element("div", "cursor");
    this.area = element("div", "plot-area", "", [this.svg, this.cursor]);
    this.root = element("figure", "plot", "", [heading, this.area]);
    if (plot.legend.length > 1) {
      const entries = plot.legend.map(([name, color]) => {
        const swatch = element("i", "swatch");
        swatch.style.background = color;
        return element("span", "entry", "", [swatch, element("span", "", name)]);
      });
      this.root.append(element("div", "legend", "", entries));
    }
    if (plot.title === "Clearance") this.root.append(this.readout);
    this.root.dataset.title = plot.title;
    this.marks = this.joints ? this.joints.map((joint) => [...this.svg.querySelectorAll(`[stroke="${joint.color}"], [fill="${joint.color}"]`)]) : [];
    const [left, right, top, bottom] = plot.frame;
    Object.assign(this.cursor.style, { top: `${100 * top}%`, height: `${100 * (bottom - top)}%` });
    this.left = left;
    this.width = right - left;
    if (plot.time) {
      for (const { time } of motion.waypoints) {
        const mark = element("div", "waypoint");
        Object.assign(mark.style, { top: this.cursor.style.top, height: this.cursor.style.height, left: `${100 * this.shareAt(time)}%` });
        this.area.append(mark);
      }
      this.area.classList.add("seekable");
      let held = false;
      this.area.addEventListener("pointerdown", (event) => { held = true; this.area.setPointerCapture(event.pointerId); seek(this.timeAt(event)); });
      this.area.addEventListener("pointermove", (event) => { if (held) seek(this.timeAt(event)); });
      for (const end of ["pointerup", "pointercancel"]) this.area.addEventListener(end, () => { held = false; });
    } else {
      this.cursor.remove();
    }
  }

  timeAt(event) {
    const box = this.area.getBoundingClientRect();
    const share = ((event.clientX - box.left) / box.width - this.left) / this.width;
    return this.plot.from + clamp(share, 0, 1) * (this.plot.to - this.plot.from);
  }

  set(time) {
    if (!this.plot.time) return;
    this.cursor.style.left = `${100 * this.shareAt(time)}%`;
  }

  // The place of a time as a share of the width.
  shareAt(time) {
    const share = (time - this.plot.from) / (this.plot.to - this.plot.from || 1);
    return this.left + clamp(share, 0, 1) * this.width;
  }

  // Shows one joint alone, or all for -1.
  select(joint) {
    if (!this.joints) return;
    this.root.classList.toggle("one", joint >= 0);
    this.marks.forEach((marks, i) => marks.forEach((mark) => mark.classList.toggle("chosen", i === joint)));
  }
}
