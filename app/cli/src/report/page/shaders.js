// The programs of the renderer. Lengths in m, z up.

const COMMON = `#version 300 es
precision highp float;
precision highp sampler2DShadow;
`;

// The unshadowed light, from 0 to 1: the mean of four smoothed samples of the shadow map.
const LIT = `
uniform sampler2DShadow shadows;
uniform mat4 lightMatrix;
uniform float texel;
float lit(vec3 world, vec3 normal, float bias) {
  vec4 p = lightMatrix * vec4(world + normal * bias, 1.0);
  vec3 at = p.xyz * 0.5 + 0.5;
  if (any(lessThan(at, vec3(0.0))) || any(greaterThan(at, vec3(1.0)))) return 1.0;
  float sum = 0.0;
  for (int i = 0; i < 4; i++) {
    vec2 off = vec2(i < 2 ? -1.0 : 1.0, (i & 1) == 0 ? -1.0 : 1.0);
    sum += texture(shadows, vec3(at.xy + texel * off, at.z - 0.0012));
  }
  return 0.25 * sum;
}
`;

const SOLID_VERTEX = `${COMMON}
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 model;
uniform vec3 scale;
uniform mat4 viewProjection;
out vec3 world;
out vec3 outward;
out vec3 own;
void main() {
  vec4 at = model * vec4(position, 1.0);
  world = at.xyz;
  // The model is a rotation after a scaling: normals scale inversely.
  outward = mat3(model) * (normal / (scale * scale));
  own = position;
  gl_Position = viewProjection * at;
}`;

const SOLID_FRAGMENT = `${COMMON}${LIT}
in vec3 world;
in vec3 outward;
in vec3 own;
uniform vec4 color;
uniform vec3 light;
uniform vec3 eye;
uniform float bias;
uniform float shine;
uniform vec3 scale;
uniform float edged;
out vec4 result;
// The weight of an edge of a box: one near two of its faces.
float edge() {
  vec3 off = (1.0 - abs(own)) * scale;
  float low = min(off.x, min(off.y, off.z));
  float second = off.x + off.y + off.z - low - max(off.x, max(off.y, off.z));
  return edged * (1.0 - smoothstep(0.5, 1.5, second / max(fwidth(second), 1e-6)));
}
void main() {
  vec3 n = normalize(outward);
  vec3 v = normalize(eye - world);
  if (dot(n, v) < 0.0) n = -n;
  float facing = max(dot(n, light), 0.0);
  float direct = facing > 0.0 ? lit(world, n, bias) * facing : 0.0;
  float sky = 0.5 + 0.5 * n.z;
  float rim = pow(1.0 - max(dot(n, v), 0.0), 3.0);
  float glint = pow(max(dot(n, normalize(light + v)), 0.0), 48.0) * direct;
  vec3 base = pow(color.rgb, vec3(2.2));
  vec3 shaded = base * (mix(0.24, 0.52, sky) + 0.72 * direct) + shine * (0.16 * glint + 0.07 * rim * sky);
  float ink = edge();
  result = vec4(pow(shaded * (1.0 - 0.35 * ink), vec3(1.0 / 2.2)), 1.0) * mix(color.a, 0.9, ink);
}`;

// Depths only, for shadows and for the hulls of ghosts.
const DEPTH_FRAGMENT = `${COMMON}
out vec4 result;
void main() { result = vec4(0.0); }`;

const GROUND_VERTEX = `${COMMON}
layout(location = 0) in vec3 position;
uniform mat4 viewProjection;
uniform vec3 centre;
uniform float radius;
out vec3 world;
void main() {
  world = vec3(centre.xy + position.xy * radius, centre.z);
  gl_Position = viewProjection * vec4(world, 1.0);
}`;

// A floor that fades out, with lines every metre or part of it, and shadows.
const GROUND_FRAGMENT = `${COMMON}${LIT}
in vec3 world;
uniform vec3 centre;
uniform float radius;
uniform float spacing;
uniform vec3 floorColor;
uniform vec3 lineColor;
uniform float shade;
out vec4 result;
float lines(vec2 p) {
  vec2 width = fwidth(p);
  vec2 off = abs(fract(p - 0.5) - 0.5) / max(width, vec2(1e-6));
  vec2 ink = (1.0 - clamp(off - 0.4, 0.0, 1.0)) * clamp(0.5 / width - 0.5, 0.0, 1.0);
  return max(ink.x, ink.y);
}
void main() {
  float far = length(world.xy - centre.xy) / radius;
  float fade = 1.0 - smoothstep(0.35, 1.0, far);
  float dark = 1.0 - lit(world, vec3(0.0, 0.0, 1.0), 0.0);
  float ink = max(0.55 * lines(world.xy / spacing), 0.30 * lines(5.0 * world.xy / spacing));
  vec3 rgb = mix(mix(floorColor, lineColor, ink), vec3(0.0), shade * dark);
  float alpha = max(0.85, ink) * fade;
  result = vec4(rgb, 1.0) * alpha;
}`;

// A line between two points as a strip of pixels; one instance for each part of a path.
const LINE_VERTEX = `${COMMON}
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
uniform mat4 viewProjection;
uniform vec2 size;
uniform float width;
uniform float split;
uniform vec4 before;
uniform vec4 after;
out vec4 tint;
void main() {
  vec4 a = viewProjection * vec4(from, 1.0);
  vec4 b = viewProjection * vec4(to, 1.0);
  vec2 along = (b.xy / b.w - a.xy / a.w) * size;
  float length = length(along);
  vec2 way = length > 1e-4 ? along / length : vec2(1.0, 0.0);
  float end = float(gl_VertexID & 1);
  float side = float(gl_VertexID >> 1) * 2.0 - 1.0;
  vec4 at = mix(a, b, end);
  vec2 offset = vec2(-way.y, way.x) * side * width;
  gl_Position = vec4(at.xy + offset / size * at.w, at.z - 0.0004 * at.w, at.w);
  tint = float(gl_InstanceID) < split ? before : after;
}`;

const LINE_FRAGMENT = `${COMMON}
in vec4 tint;
out vec4 result;
void main() { result = vec4(tint.rgb, 1.0) * tint.a; }`;
