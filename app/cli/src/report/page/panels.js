// The facts of a motion in words and tables.

const table = (className, head, rows) => {
  const cells = (kind, texts) => texts.map((text) => (text instanceof Node ? element(kind, "", "", [text]) : element(kind, "", text)));
  const parts = [];
  if (head) parts.push(element("thead", "", "", [element("tr", "", "", cells("th", head))]));
  parts.push(element("tbody", "", "", rows.map((row) => element("tr", "", "", cells("td", row)))));
  return element("table", className, "", parts);
};

// Every joint with its current values and its share of the effort. A selected joint is shown alone in the plots.
class JointTable {
  constructor(motion, values, choose) {
    this.motion = motion;
    this.values = values;
    const most = Math.max(...motion.joints.map((joint) => joint.effort), 1e-12);
    const rows = motion.joints.map((joint) => {
      const swatch = element("i", "swatch");
      swatch.style.background = joint.color;
      const bar = element("i", "bar");
      bar.style.width = `${(100 * joint.effort) / most}%`;
      bar.style.background = joint.color;
      const share = motion.effort > 0 ? (100 * joint.effort) / motion.effort : 0;
      const effort = element("span", "effort", "", [bar, element("span", "", `${short(joint.effort, 3)} (${share.toFixed(0)} %)`)]);
      const name = element("button", "joint", "", [swatch, element("span", "", joint.name)]);
      name.type = "button";
      name.title = "show this joint alone in the plots";
      return [name, "", "", "", "", effort];
    });
    const units = (linear, angular) => {
      const all = new Set(motion.joints.map((joint) => joint.unit));
      return all.size > 1 ? "" : `, ${all.has("m") ? linear : angular}`;
    };
    const head = ["joint", `q${units("m", "rad")}`, `v${units("m/s", "rad/s")}`, `a${units("m/s²", "rad/s²")}`, `τ${units("N", "N m")}`, "effort, ∫τ² dt"];
    this.root = element("div", "scroll", "", [table("joints", head, rows)]);
    this.rows = [...this.root.querySelectorAll("tbody tr")];
    this.rows.forEach((row, i) => row.querySelector("button").addEventListener("click", () => choose(i)));
  }

  set([row, share]) {
    const n = this.motion.joints.length;
    const last = this.values.length / (4 * n) - 1;
    const at = (share > 0.5 ? Math.min(row + 1, last) : row) * 4 * n;
    this.rows.forEach((tr, joint) => {
      for (let what = 0; what < 4; what += 1) tr.children[1 + what].textContent = this.values[at + what * n + joint].toFixed(3);
    });
  }

  select(joint) {
    this.rows.forEach((row, i) => {
      row.classList.toggle("chosen", i === joint);
      row.querySelector("button").setAttribute("aria-pressed", String(i === joint));
    });
  }
}

const commandPanel = (motion) => {
  const line = (command) => {
    const code = element("code", "", command);
    const copy = element("button", "small", "Copy");
    copy.type = "button";
    copy.addEventListener("click", async () => {
      try {
        await navigator.clipboard.writeText(command);
        copy.textContent = "Copied";
      } catch {
        // A page from a file may have no access to the clipboard: the text is selected instead.
        getSelection().selectAllChildren(code);
        copy.textContent = "Selected";
      }
      setTimeout(() => { copy.textContent = "Copy"; }, 1500);
    });
    return element("div", "command", "", [code, copy]);
  };
  return panel("The command that makes it again", [
    ...motion.commands.map(line),
    element("p", "hint", `Made by ${motion.made_by}.`),
  ]);
};

const minimaPanel = (motion, toggle, colorOf) => {
  if (!motion.minima.length) return null;
  const least = motion.minima[0].cost;
  const rows = motion.minima.map((minimum, i) => {
    const more = i === 0 ? "" : `+${((100 * (minimum.cost - least)) / Math.abs(least || 1)).toFixed(1)} %`;
    let shown = "";
    if (minimum.track === 0) shown = "the motion";
    else if (minimum.track) shown = toggle(minimum.track, "show");
    return [String(i + 1), short(minimum.cost), more, String(minimum.starts), shown];
  });
  return panel("Minima that the starts found", [element("div", "scroll", "", [table("minima", ["", "cost", "above the least", "starts", "in the view"], rows)])]);
};

const factsPanel = (motion) => {
  const notes = motion.scene.notes.map((note) => ["in the picture", note]);
  return panel("Summary", [element("div", "scroll", "", [table("facts", null, [...motion.facts, ...notes])])]);
};
