// The page: a column of views with a shared clock, and a column of plots and tables.

// A list of motions side by side, or those of a trade-off, of which the address says which one is shown.
const data = JSON.parse(document.getElementById("data").textContent);
const chosen = data.plot ? clamp(Number(location.hash.slice(1)) || 1, 1, data.motions.length) - 1 : 0;
const motions = data.plot ? [data.motions[chosen]] : data;

// Colours of the picture in the style of the page, red, green and blue from 0 to 1.
let colors = {};
const readColors = () => {
  const style = getComputedStyle(document.documentElement);
  const color = (name) => {
    const hex = style.getPropertyValue(`--${name}`).trim().slice(1);
    return [0, 2, 4].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
  };
  colors = {
    link: color("robot-link"),
    joint: color("robot-joint"),
    obstacle: color("obstacle"),
    path: color("path"),
    near: color("near"),
    good: color("good"),
    bad: color("bad"),
    floor: color("floor"),
    line: color("floor-line"),
    shade: Number(style.getPropertyValue("--shade")),
    ghosts: ["ghost-1", "ghost-2", "ghost-3"].map(color),
  };
};

const state = { time: 0, playing: !matchMedia("(prefers-reduced-motion: reduce)").matches, speed: 1, loop: true, follow: false, joint: -1, pause: 0 };
const end = Math.max(...motions.map((motion) => motion.horizon));
const views = [];
let dirty = true;

const seek = (time) => {
  state.time = clamp(time, 0, end);
  state.pause = 0;
  dirty = true;
};
const play = (on) => {
  if (on && state.time >= end) state.time = 0;
  state.playing = on;
  playButton.textContent = on ? "❚❚" : "▶";
  playButton.setAttribute("aria-label", on ? "pause" : "play");
  dirty = true;
};
const toggled = (made, on) => {
  made.classList.toggle("on", on);
  made.setAttribute("aria-pressed", String(on));
};

// The clock.
const playButton = button("▶", "play", () => play(!state.playing));
playButton.classList.add("play");
const scrub = element("input", "scrub");
Object.assign(scrub, { type: "range", min: 0, max: 1000, step: 1, value: 0 });
scrub.setAttribute("aria-label", "time");
scrub.addEventListener("input", () => seek((end * scrub.value) / 1000));
const clock = element("output", "clock");
const speed = element("select", "speed");
speed.setAttribute("aria-label", "speed");
for (const factor of [0.1, 0.25, 0.5, 1, 2]) speed.append(new Option(`${factor}×`, factor, factor === 1, factor === 1));
speed.addEventListener("change", () => { state.speed = Number(speed.value); });
const loopButton = button("Loop", "play again from the start (L)", () => { state.loop = !state.loop; toggled(loopButton, state.loop); });
const followButton = button("Follow", "keep the tool in the middle (F)", () => { state.follow = !state.follow; toggled(followButton, state.follow); dirty = true; });
const resetButton = button("Reset", "look from where it began (R)", () => { state.follow = false; toggled(followButton, false); fit(); });
toggled(loopButton, true);
toggled(followButton, false);
const transport = element("div", "transport", "", [
  element("div", "transport-main", "", [playButton, scrub, clock]),
  element("div", "transport-more", "", [speed, loopButton, followButton, resetButton]),
]);

// The views.
const tracks = motions.map((motion) => motion.tracks.map((track) => new Track(track)));
const taken = motions.map((motion, i) => takenUp(motion, tracks[i]));
taken.forEach(({ lowest }, i) => { motions[i].lowest = lowest; });
const camera = new Camera(ballAbout(taken.flatMap(({ points }) => points)));

const fit = () => {
  const canvas = document.querySelector("canvas");
  camera.reset(canvas.clientWidth / canvas.clientHeight);
  dirty = true;
};

const pointers = new Map();
const watch = (canvas) => {
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
    if (pointers.size === 2) {
      const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      const apart = (at) => Math.hypot(at[0] - other[0], at[1] - other[1]) || 1;
      camera.zoom(apart(before) / apart([event.clientX, event.clientY]));
      camera.pan(dx / 2, dy / 2, canvas.clientHeight);
    } else if (event.shiftKey || event.buttons === 2 || event.buttons === 4) {
      camera.pan(dx, dy, canvas.clientHeight);
    } else {
      camera.orbit(dx, dy);
    }
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    dirty = true;
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("dblclick", () => resetButton.click());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    camera.zoom(Math.exp(0.0012 * event.deltaY));
    dirty = true;
  }, { passive: false });
};

const tradeoffPanel = () => {
  const curve = new ScatterCard(data.plot, (point) => {
    const number = data.motions.findIndex((motion) => motion.horizon === point.x);
    location.hash = `#${number + 1}`;
    location.reload();
  });
  curve.mark = (point) => point.x === motions[0].horizon;
  const hint = "A click on a point shows its motion; the ring is around the one that is shown.";
  return panel("Duration and effort", [element("p", "hint", hint), curve.root]);
};

const addMotion = (motion, i) => {
  const canvas = element("canvas", "view");
  canvas.tabIndex = 0;
  canvas.setAttribute("aria-label", `the robot ${motion.robot} in motion`);
  const nearest = element("div", "nearest");
  const stage = element("div", "stage-view", "", [canvas]);
  if (motions.length > 1) stage.append(element("div", "caption", `${motion.name}, ${motion.method}`));
  const chips = element("div", "chips");
  let view = null;
  try {
    view = new View(canvas, motion, tracks[i], camera);
    watch(canvas);
  } catch (error) {
    stage.append(element("p", "fault", error.message));
  }
  const controls = new Map();
  const chip = (key, text, swatch, get, set) => {
    const made = button("", text, () => {
      set(!get());
      for (const control of controls.get(key)) toggled(control, get());
      dirty = true;
    });
    made.className = "chip";
    if (swatch) {
      const dot = element("i", `swatch ${swatch}`);
      made.append(dot);
    }
    made.append(element("span", "", text));
    toggled(made, get());
    controls.set(key, [...(controls.get(key) ?? []), made]);
    return made;
  };
  const track = (number, text) => chip(`track ${number}`, text, `ghost-${((number - 1) % 3) + 1}`,
    () => view.shown.tracks.has(number),
    (on) => (on ? view.shown.tracks.add(number) : view.shown.tracks.delete(number)));
  const part = (name, text, swatch) => chip(name, text, swatch, () => view.shown[name], (on) => { view.shown[name] = on; });
  if (view) {
    chips.append(part("path", "Path", "path"));
    if (motion.scene.tips.length > 1) chips.append(part("others", "Other paths", "path"));
    if (motion.scene.obstacles.length || motion.scene.planes.length) chips.append(part("obstacles", "Obstacles", "obstacle"));
    if (motion.waypoints.length) chips.append(part("waypoints", "Waypoints", "path"));
    if (motion.clearance) chips.append(part("nearest", "Nearest pair", "near"));
    if (view.foot) chips.append(part("foot", `Ground force, 1 m = ${view.foot.newtonPerMetre} N, red beyond bounds`, "holds"));
    motion.tracks.forEach((one, number) => {
      if (number > 0) chips.append(track(number, one.name[0].toUpperCase() + one.name.slice(1)));
    });
  }
  stage.append(chips, nearest);

  const values = floats(motion.values);
  const cards = motion.plots.map((plot) => new PlotCard(plot, motion, (time) => { seek(time); }));
  const choose = (joint) => {
    state.joint = state.joint === joint ? -1 : joint;
    for (const one of views) one.select(state.joint);
  };
  const joints = new JointTable(motion, values, choose);
  const clearances = motion.clearance && floats(motion.clearance.values);
  const numbers = [["duration", `${short(motion.horizon)} s`], ["control effort", short(motion.effort)]];
  if (![short(motion.horizon), short(motion.effort)].includes(short(motion.cost))) numbers.push(["cost", short(motion.cost)]);
  if (clearances) numbers.push(["smallest clearance", `${short(1000 * motion.least_clearance)} mm`]);
  numbers.push(["joints", String(motion.joints.length)]);
  const isGood = ["optimal", "valid"].includes(motion.verdict);
  const badge = element("span", isGood ? "badge good" : `badge${motion.failure ? " bad" : ""}`, motion.verdict);
  const title = element("div", "title", "", [element("h1", "", motion.name), element("span", "robot", `${motion.robot}, ${motion.method}`), badge]);
  const figures = element("dl", "figures", "", numbers.flatMap(([name, value]) => [element("div", "", "", [element("dt", "", name), element("dd", "", value)])]));
  header.append(element("div", "head", "", [title, figures]));
  const over = cards.filter((card) => card.plot.time);
  const search = cards.filter((card) => !card.plot.time);
  const grid = (some) => element("div", "grid", "", some.map((card) => card.root));
  const panels = [
    data.plot && tradeoffPanel(),
    motion.failure && element("p", "fault", motion.failure),
    panel("Over time", [element("p", "hint", "A click in a plot moves the robot there. A strip in the colour of a joint lies beyond each of its enforced limits, and a grey one where limits of several joints lie together; a chosen joint shows its own."), grid(over)]),
    panel("Joints", [joints.root]),
    search.length ? panel("The search", [grid(search)]) : null,
    minimaPanel(motion, track),
    factsPanel(motion),
    commandPanel(motion),
  ];
  const column = element("div", "panels", "", panels.filter(Boolean));
  views.push({
    view,
    motion,
    stage,
    column,
    select: (joint) => { joints.select(joint); for (const card of cards) card.select(joint); },
    set: (time) => {
      const at = tracks[i][0].at(time);
      joints.set(at);
      for (const card of cards) card.set(Math.min(time, motion.horizon));
      if (clearances) {
        const row = tracks[i][0].nearest(time);
        const pair = motion.clearance.pairs[motion.clearance.pair[row]];
        const text = `${short(1000 * clearances[row], 3)} mm: ${pair[0]} – ${pair[1]}`;
        nearest.textContent = `nearest ${text}`;
        const card = cards.find((one) => one.plot.title === "Clearance");
        if (card) card.readout.textContent = text;
      }
    },
  });
};
motions.forEach(addMotion);

followTheme(() => {
  readColors();
  dirty = true;
});

const stage = element("section", "stage", "", [element("div", `stage-views of-${motions.length}`, "", views.map((v) => v.stage)), transport]);
main.append(stage, element("section", `columns of-${motions.length}`, "", views.map((v) => v.column)));
new ResizeObserver(() => { dirty = true; }).observe(stage);

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || /^(SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
  const step = (event.shiftKey ? 0.1 : 0.01) * end;
  const actions = {
    " ": () => play(!state.playing),
    ArrowLeft: () => { play(false); seek(state.time - step); },
    ArrowRight: () => { play(false); seek(state.time + step); },
    Home: () => seek(0),
    End: () => { play(false); seek(end); },
    l: () => loopButton.click(),
    f: () => followButton.click(),
    r: () => resetButton.click(),
  };
  const action = actions[event.key] ?? actions[event.key.toLowerCase()];
  // A focused button handles the space bar itself.
  if (!action || (event.key === " " && event.target.tagName === "BUTTON" && event.target !== playButton)) return;
  event.preventDefault();
  action();
});

const advance = (seconds) => {
  if (!state.playing) return;
  dirty = true;
  if (state.time < end) {
    state.time = Math.min(end, state.time + state.speed * seconds);
    return;
  }
  // A pause at the end before the motion is repeated.
  state.pause += seconds;
  if (!state.loop) play(false);
  else if (state.pause > 0.8) seek(0);
};

let before = performance.now();
const frame = (now) => {
  // The time of the first frame may be before that of the page.
  advance(clamp((now - before) / 1000, 0, 0.1));
  before = now;
  if (dirty) {
    dirty = false;
    if (state.follow && views[0].view) camera.target = views[0].view.tipAt(state.time);
    for (const one of views) {
      one.set(state.time);
      if (one.view) one.view.draw(Math.min(state.time, one.motion.horizon), colors);
    }
    scrub.value = Math.round((1000 * state.time) / end);
    clock.textContent = `${state.time.toFixed(2)} / ${end.toFixed(2)} s`;
  }
  requestAnimationFrame(frame);
};
fit();
play(state.playing);
requestAnimationFrame(frame);
// For tests and recordings of the page.
window.report = { state, seek, play, views, camera, colors: () => colors, redraw: () => { dirty = true; } };
