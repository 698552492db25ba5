// Solids of unit size: positions and normals, three numbers each for every corner, and the corners of triangles.

const solid = () => ({ positions: [], normals: [], triangles: [] });

// Rows of corners around the z axis: a profile of [radius, height, outward radial part, outward axial part of the normal].
const revolved = (profile, sides) => {
  const made = solid();
  for (const [radius, z, outward, upward] of profile) {
    for (let i = 0; i <= sides; i += 1) {
      const angle = (2 * Math.PI * i) / sides;
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      made.positions.push(radius * c, radius * s, z);
      made.normals.push(outward * c, outward * s, upward);
    }
  }
  const width = sides + 1;
  for (let row = 0; row + 1 < profile.length; row += 1) {
    for (let i = 0; i < sides; i += 1) {
      const a = row * width + i;
      made.triangles.push(a, a + 1, a + width + 1, a, a + width + 1, a + width);
    }
  }
  return made;
};

// An arc of the profile of a ball, from one angle above the equator to another.
const arc = (from, to, steps) => {
  const profile = [];
  for (let i = 0; i <= steps; i += 1) {
    const angle = from + ((to - from) * i) / steps;
    profile.push([Math.cos(angle), Math.sin(angle), Math.cos(angle), Math.sin(angle)]);
  }
  return profile;
};

const SIDES = 28;
const ballSolid = () => revolved(arc(-Math.PI / 2, Math.PI / 2, 14), SIDES);
const domeSolid = () => revolved(arc(0, Math.PI / 2, 7), SIDES);
const tubeSolid = () => revolved([[1, -1, 1, 0], [1, 1, 1, 0]], SIDES);
// With flat ends, whose rims have separate normals.
const cylinderSolid = () => revolved([
  [0, -1, 0, -1], [1, -1, 0, -1], [1, -1, 1, 0], [1, 1, 1, 0], [1, 1, 0, 1], [0, 1, 0, 1],
], SIDES);

const boxSolid = () => {
  const made = solid();
  for (let axis = 0; axis < 3; axis += 1) {
    for (const side of [-1, 1]) {
      const first = made.positions.length / 3;
      for (const [u, v] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
        const corner = [0, 0, 0];
        corner[axis] = side;
        corner[(axis + 1) % 3] = u;
        corner[(axis + 2) % 3] = v;
        const normal = [0, 0, 0];
        normal[axis] = side;
        made.positions.push(...corner);
        made.normals.push(...normal);
      }
      const [a, b, c, d] = [0, 1, 2, 3].map((i) => first + i);
      made.triangles.push(...(side > 0 ? [a, b, c, a, c, d] : [a, c, b, a, d, c]));
    }
  }
  return made;
};

// A mesh of the report, each triangle with its own normal.
const meshSolid = (mesh) => {
  const corners = new Uint16Array(bytesOf(mesh.corners));
  const triangles = new Uint32Array(bytesOf(mesh.triangles));
  const made = solid();
  const corner = (i) => [0, 1, 2].map((k) => mesh.low[k] + mesh.step * corners[3 * i + k]);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [corner(triangles[t]), corner(triangles[t + 1]), corner(triangles[t + 2])];
    const normal = unit(cross(subtract(b, a), subtract(c, a)));
    for (const point of [a, b, c]) {
      made.triangles.push(made.positions.length / 3);
      made.positions.push(...point);
      made.normals.push(...normal);
    }
  }
  return made;
};
