// A motion in three dimensions, and its camera.

const CAPSULE_PARTS = (item) => {
  const [r, , half] = item.size;
  return [
    ["tube", [0, 0, 0], [0, 0, 0, 1], [r, r, half]],
    ["dome", [0, 0, half], [0, 0, 0, 1], [r, r, r]],
    ["dome", [0, 0, -half], [1, 0, 0, 0], [r, r, r]],
  ];
};
// A shape of any other kind is drawn as the box about it.
const SOLID_OF = { sphere: "ball", box: "box", cylinder: "cylinder" };

// Positions and orientations of bodies over time.
class Track {
  constructor(data) {
    this.data = data;
    this.times = floats(data.times);
    this.positions = shorts(data.positions);
    this.turns = shorts(data.turns);
    this.bodies = this.positions.length / 3 / data.rows;
  }

  get end() { return this.times[this.times.length - 1]; }

  // The row before a time, and the fraction of the interval to the next one.
  at(time) {
    let [low, high] = [0, this.times.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= time) low = middle; else high = middle;
    }
    const span = this.times[high] - this.times[low];
    return [low, span > 0 ? clamp((time - this.times[low]) / span, 0, 1) : 1];
  }

  // The row that is nearest to a time.
  nearest(time) {
    const [row, share] = this.at(time);
    return share > 0.5 ? Math.min(row + 1, this.data.rows - 1) : row;
  }

  pose(body, [row, share]) {
    if (body === undefined) return { position: [0, 0, 0], turn: [0, 0, 0, 1] };
    const next = Math.min(row + 1, this.data.rows - 1);
    const [p, q] = [row, next].map((r) => r * this.bodies + body);
    const mix = (numbers, width, i, sign) => numbers[width * p + i] * (1 - share) + sign * numbers[width * q + i] * share;
    let along = 0;
    for (let i = 0; i < 4; i += 1) along += this.turns[4 * p + i] * this.turns[4 * q + i];
    const sign = along < 0 ? -1 : 1;
    const turn = [0, 1, 2, 3].map((i) => mix(this.turns, 4, i, sign));
    const length = Math.hypot(...turn) || 1;
    return {
      position: [0, 1, 2].map((i) => mix(this.positions, 3, i, 1) * this.data.unit),
      turn: turn.map((x) => x / length),
    };
  }

  // The positions of a point of a body at all rows, three numbers each.
  path({ body, point }) {
    const all = [];
    for (let row = 0; row < this.data.rows; row += 1) {
      const { position, turn } = this.pose(body, [row, 0]);
      all.push(...add(position, turned(turn, point)));
    }
    return all;
  }
}

// The tangent of half of the field of view along the shorter side of a canvas.
const HALF_VIEW = 0.33;

// A camera that orbits a target at a distance.
class Camera {
  constructor(bounds) {
    this.bounds = bounds;
    this.reset(1);
  }

  // Moves to where the whole motion is visible on a canvas with this ratio of width to height.
  reset(aspect) {
    const { centre, points } = this.bounds;
    this.target = [...centre];
    this.yaw = -0.9;
    this.pitch = 0.3;
    this.distance = 1;
    const forward = unit(subtract(this.target, this.eye));
    const right = unit(cross(forward, [0, 0, 1]));
    const up = cross(right, forward);
    // A margin for the text above and below.
    const [across, upward] = [0.92 * HALF_VIEW * Math.max(1, aspect), (0.8 * HALF_VIEW) / Math.min(1, aspect)];
    this.distance = 0;
    for (const [point, radius] of points) {
      const off = subtract(point, centre);
      const near = radius - dot(off, forward);
      const needed = Math.max((Math.abs(dot(off, right)) + radius) / across, (Math.abs(dot(off, up)) + radius) / upward);
      this.distance = Math.max(this.distance, near + needed);
    }
    this.distance = Math.max(this.distance, 0.2 * this.bounds.radius);
  }

  get eye() {
    const [c, s] = [Math.cos(this.pitch), Math.sin(this.pitch)];
    return add(this.target, scaled([c * Math.cos(this.yaw), c * Math.sin(this.yaw), s], this.distance));
  }

  matrix(aspect) {
    // On a narrow canvas the width limits the field of view.
    const fov = 2 * Math.atan(HALF_VIEW / Math.min(1, aspect));
    const view = lookAt(this.eye, this.target, [0, 0, 1]);
    return times(perspective(fov, aspect, 0.01 * this.distance, 20 * this.distance + 10 * this.bounds.radius), view);
  }

  orbit(dx, dy) {
    this.yaw -= 0.008 * dx;
    this.pitch = clamp(this.pitch + 0.008 * dy, -1.5, 1.5);
  }

  zoom(factor) {
    this.distance = clamp(this.distance * factor, 0.2 * this.bounds.radius, 20 * this.bounds.radius);
  }

  pan(dx, dy, height) {
    const forward = unit(subtract(this.target, this.eye));
    const right = unit(cross(forward, [0, 0, 1]));
    const up = cross(right, forward);
    const size = (2 * HALF_VIEW * this.distance) / height;
    this.target = add(this.target, add(scaled(right, -dx * size), scaled(up, dy * size)));
  }
}

// The sole of a standing foot, and on it the force of the ground as an arrow from a cross at the centre of pressure.
class FootPicture {
  constructor(foot, radius, renderer) {
    this.foot = foot;
    this.renderer = renderer;
    // An arrow as long as half of that is the weight; two digits, as the legend has this number.
    this.newtonPerMetre = Number(((2 * foot.weight) / radius).toPrecision(2));
    this.points = floats(foot.points);
    this.forces = floats(foot.forces);
    const [l, b] = foot.size;
    const corner = (x, y) => add(foot.pose.slice(0, 3), turned(foot.pose.slice(3), [x, y, 0]));
    this.sole = renderer.uploadPath([[l, b], [-l, b], [-l, -b], [l, -b], [l, b]].flatMap(([x, y]) => corner(x, y)));
    const arm = 0.35 * Math.min(l, b);
    this.arms = [[arm, 0, 0], [0, arm, 0]].map((along) => turned(foot.pose.slice(3), along));
    this.arrow = renderer.uploadPath(new Array(30).fill(0));
  }

  lines(row, eye, colors) {
    const color = [...(this.foot.holds[row] ? colors.good : colors.bad), 1];
    const line = (path, width) => ({ path, width, color, hidden: 0.6 });
    const from = [...this.points.subarray(3 * row, 3 * row + 3)];
    const along = scaled([...this.forces.subarray(3 * row, 3 * row + 3)], 1 / this.newtonPerMetre);
    // Without a normal force there is no centre of pressure.
    if (![...from, ...along].every(Number.isFinite)) return [line(this.sole, 1.8)];
    const to = add(from, along);
    const side = scaled(unit(cross(along, subtract(eye, to))), 0.05 * norm(along));
    const behind = add(to, scaled(along, -0.12));
    const [a, b] = this.arms;
    const points = [subtract(from, a), add(from, a), from, subtract(from, b), add(from, b), from, to, add(behind, side), to, subtract(behind, side)];
    this.renderer.updatePath(this.arrow, points.flat());
    return [line(this.sole, 1.8), line(this.arrow, 2.4)];
  }
}

class View {
  constructor(canvas, motion, tracks, camera) {
    this.motion = motion;
    this.tracks = tracks;
    this.camera = camera;
    this.renderer = new Renderer(canvas);
    this.meshes = motion.scene.meshes.map((mesh) => this.renderer.upload(meshSolid(mesh)));
    this.shown = { obstacles: true, path: true, others: false, nearest: true, foot: true, waypoints: true, tracks: new Set([0]) };
    this.paths = tracks.map((track) => motion.scene.tips.map((tip) => this.renderer.uploadPath(track.path(tip))));
    this.nearestPoints = motion.clearance && floats(motion.clearance.points);
    this.nearestPath = this.nearestPoints && this.renderer.uploadPath([0, 0, 0, 0, 0, 0]);
    const places = motion.waypoints.map(({ place }) => place).filter(Boolean);
    this.waypoints = places.map((place) => this.ball(place, 0.012 * camera.bounds.radius));
    if (motion.foot) this.foot = new FootPicture(motion.foot, camera.bounds.radius, this.renderer);
    const upward = motion.scene.planes.filter((plane) => plane.normal[2] > 0.999);
    this.floor = upward.length ? Math.max(...upward.map((p) => p.offset)) : (motion.foot?.pose[2] ?? motion.lowest);
    const walls = motion.scene.planes.filter((plane) => plane.normal[2] <= 0.999).map((plane) => this.wall(plane));
    this.obstacles = [...motion.scene.obstacles, ...walls].flatMap((item) => this.parts(item, [0, 0, 0], [0, 0, 0, 1]));
    this.bodies = motion.scene.shapes.map((item) => ({ item, parts: this.parts(item, [0, 0, 0], [0, 0, 0, 1]) }));
  }

  ball(at, radius) {
    const scale = [radius, radius, radius];
    return { solid: this.renderer.solids.ball, scale, model: placed(at, [0, 0, 0, 1], scale) };
  }

  wall({ normal, offset }) {
    const { centre, radius } = this.camera.bounds;
    const at = add(centre, scaled(normal, offset - dot(normal, centre)));
    return { kind: "box", size: [1.6 * radius, 1.6 * radius, 0.004 * radius], pose: [...at, ...turnFromZ(normal)] };
  }

  // The solids of a shape, each with its placement in the frame that carries the shape.
  parts(item) {
    const position = item.pose.slice(0, 3);
    const turn = item.pose.slice(3);
    const all = item.kind === "capsule" ? CAPSULE_PARTS(item) : [[SOLID_OF[item.kind] ?? "box", [0, 0, 0], [0, 0, 0, 1], item.size]];
    return all.map(([solid, at, own, scale]) => {
      const made = {
        solid: item.kind === "mesh" ? this.meshes[item.mesh] : this.renderer.solids[solid],
        position: add(position, turned(turn, at)),
        turn: product(turn, own),
        scale,
      };
      made.model = placed(made.position, made.turn, scale);
      return made;
    });
  }

  // The solids of the robot at a time of a track.
  robot(track, time, paint, withBase = true) {
    const at = track.at(time);
    const poses = new Map();
    const list = [];
    for (const { item, parts } of this.bodies) {
      if (item.body === undefined && !withBase) continue;
      if (!poses.has(item.body)) poses.set(item.body, track.pose(item.body, at));
      const pose = poses.get(item.body);
      for (const part of parts) {
        const position = add(pose.position, turned(pose.turn, part.position));
        const model = placed(position, product(pose.turn, part.turn), part.scale);
        list.push({ solid: part.solid, scale: part.scale, model, color: paint(item) });
      }
    }
    return list;
  }

  tipAt(time) {
    const [tip] = this.motion.scene.tips;
    if (!tip) return this.camera.bounds.centre;
    const pose = this.tracks[0].pose(tip.body, this.tracks[0].at(time));
    return add(pose.position, turned(pose.turn, tip.point));
  }

  resize() {
    const { canvas } = this.renderer;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((x) => Math.max(1, Math.round(x * ratio)));
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    return ratio;
  }

  draw(time, colors) {
    const pixels = this.resize();
    const { canvas } = this.renderer;
    const { bounds } = this.camera;
    const paint = (item) => [...(item.color ?? (item.joint ? colors.joint : colors.link)), 1];
    const ghost = (track) => {
      const color = [...colors.ghosts[(track - 1) % colors.ghosts.length], 0.3];
      return this.robot(this.tracks[track], time, () => color, false);
    };
    const ghosts = [...this.shown.tracks].filter((track) => track > 0);
    const lines = [];
    if (this.shown.path || this.shown.others) {
      for (const track of this.shown.tracks) {
        const strong = track === 0 ? colors.path : colors.ghosts[(track - 1) % colors.ghosts.length];
        const [row, share] = this.tracks[track].at(time);
        this.paths[track].forEach((path, tip) => {
          if (tip === 0 ? this.shown.path : this.shown.others) lines.push({ path, width: track === 0 ? 1.6 : 1.2, color: [...strong, 0.95], after: [...strong, 0.4], split: row + share });
        });
      }
    }
    const row = this.tracks[0].nearest(time);
    if (this.foot && this.shown.foot) lines.push(...this.foot.lines(row, this.camera.eye, colors));
    if (this.shown.nearest && this.nearestPath) {
      this.renderer.updatePath(this.nearestPath, this.nearestPoints.subarray(6 * row, 6 * row + 6));
      lines.push({ path: this.nearestPath, width: 1.8, color: [...colors.near, 1], split: 1e9 });
    }
    const obstacle = [...colors.obstacle, 0.36];
    const waypoints = this.shown.waypoints ? this.waypoints.map((ball) => ({ ...ball, color: [...colors.path, 1] })) : [];
    this.renderer.draw({
      opaque: [...this.robot(this.tracks[0], time, paint), ...waypoints],
      seeThrough: this.shown.obstacles ? this.obstacles.map((part) => ({ ...part, color: obstacle })) : [],
      ghosts: ghosts.map(ghost),
      lines,
      pixels,
      bounds,
      ground: { z: this.floor, spacing: bounds.radius > 4 ? 5 : 1, floor: colors.floor, line: colors.line, shade: colors.shade },
      camera: { eye: this.camera.eye, matrix: this.camera.matrix(canvas.width / canvas.height) },
    });
  }
}

// The extent of a motion: points of the robot at all times and obstacles near it, with radii, and its lowest point.
const takenUp = (motion, tracks) => {
  let [low, high] = [[0, 0, 0], [0, 0, 0]];
  const points = [];
  const take = (p, r) => {
    points.push([p, r]);
    low = low.map((x, i) => Math.min(x, p[i] - r));
    high = high.map((x, i) => Math.max(x, p[i] + r));
  };
  const thickness = Math.max(...motion.scene.shapes.map((s) => Math.min(...s.size)), 0);
  const track = tracks[0];
  for (let i = 0; i < track.positions.length; i += 3) {
    take([0, 1, 2].map((k) => track.positions[i + k] * track.data.unit), thickness);
  }
  for (const tip of motion.scene.tips) {
    const path = track.path(tip);
    for (let i = 0; i < path.length; i += 3) take(path.slice(i, i + 3), 0);
  }
  const lowest = low[2] < -0.02 ? low[2] - thickness : 0;
  const reach = 1.5 * norm(subtract(high, low));
  for (const item of motion.scene.obstacles) {
    const at = item.pose.slice(0, 3);
    const size = Math.max(...item.size);
    // Of a table top beyond the reach of the robot only the near part counts.
    take(at.map((x, i) => clamp(x, low[i] - reach, high[i] + reach)), Math.min(size, 0.5 * reach));
  }
  return { points, lowest };
};

// A ball about points with individual radii.
const ballAbout = (points) => {
  const corner = (pick, sign) => points.reduce((m, [p, r]) => m.map((x, i) => pick(x, p[i] + sign * r)), [0, 0, 0]);
  const [low, high] = [corner(Math.min, -1), corner(Math.max, 1)];
  return { points, centre: scaled(add(low, high), 0.5), radius: Math.max(0.5 * norm(subtract(high, low)), 0.1) };
};
