// Programs of the graphics card: spheres without triangles, surfaces, edges and faces of walls.
//
// Camera coordinates: right, up, towards the eye [m], from the point in the middle of the stage.
// All is seen from far away (orthographic), so that lengths can be taken off the picture.
//
// Of spheres that do not overlap the one whose centre is nearer is in front on every line of sight:
// the plane between two is crossed once. So a sphere has the depth of its centre, and what is behind
// is left out before it is shaded; depths of their own for all pixels took half as long again.

const CAMERA = `#version 300 es
precision highp float;
uniform mat3 camera;    // rows: right, up, towards the eye
uniform vec3 middle;    // of the stage
uniform vec3 shift;     // of the enclosure
uniform vec3 halves;    // of the stage: width, height, depth
vec4 onStage(vec3 point) {
  return vec4(point.xy / halves.xy, -point.z / halves.z, 1.0);
}
`;

const PLACED = `
uniform vec3 low, step_;             // of the positions
uniform vec3 colours[64];
uniform int picked;
layout(location = 0) in vec3 place;  // in steps
layout(location = 1) in float tone;
uniform float front;  // half the depth of what is shown: the farthest get less light
vec3 centreOf() {
  return camera * (low + step_ * place + shift - middle);
}
vec3 colourAt(vec3 centre) {
  return (0.8 + 0.2 * clamp(centre.z / front, -1.0, 1.0)) * colours[int(tone)];
}
`;

// Light as in damper3d/view/spheres.py: Lambert's law, a highlight, and a dark rim.
const LIT = `
uniform vec4 cut;  // normal and offset of the plane in front of which nothing is drawn
vec3 lit(vec3 colour, vec3 normal) {
  float facing = max(dot(normal, vec3(-0.450, 0.600, 0.661)), 0.0);
  float shine = max(dot(normal, vec3(-0.247, 0.329, 0.911)), 0.0);
  shine *= shine;
  shine *= shine;
  shine *= shine;
  shine *= shine;  // its 16th power
  float rim = min(0.55 + 1.5 * normal.z, 1.0);
  return rim * colour * (0.42 + 0.58 * facing) + 0.2 * shine;
}
vec3 section(vec3 colour) {  // flat, where the plane cuts a particle
  return 0.86 * colour + 0.06;
}
`;

export const SPHERES = {
  vertex: `${CAMERA}${PLACED}
layout(location = 2) in float radius;
out vec2 corner;
flat out vec3 centre, colour;
flat out float size, ring;
void main() {
  corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  centre = centreOf();
  size = radius;
  colour = colourAt(centre);
  ring = gl_InstanceID == picked ? 1.0 : 0.0;
  gl_Position = onStage(centre + vec3(radius * corner, 0.0));
}`,
  // The point of a sphere that a pixel sees: no triangles, and sharp sections.
  fragment: `#version 300 es
precision highp float;
in vec2 corner;
flat in vec3 centre, colour;
flat in float size, ring;
out vec4 pixel;
${LIT}
void main() {
  float across = dot(corner, corner);
  if (across > 1.0) discard;
  float towards = sqrt(1.0 - across);
  vec3 normal = vec3(corner, towards);
  vec3 point = centre + size * normal;
  vec3 shown = lit(colour, normal);
#ifdef CUT
  if (dot(cut.xyz, point) > cut.w) {
    if (cut.z <= 0.0) discard;
    float onPlane = (cut.w - dot(cut.xy, point.xy)) / cut.z;
    float deep = (onPlane - centre.z) / size + towards;
    if (deep < 0.0) discard;
    shown = section(colour) * mix(0.6, 1.0, smoothstep(0.0, 0.1, deep));
  }
#endif
  if (ring > 0.5 && across > 0.72) shown = vec3(1.0, 0.25, 0.1);
  pixel = vec4(shown, 1.0);
}`,
};

export const SURFACES = {
  vertex: `${CAMERA}${PLACED}
layout(location = 2) in vec4 turn;     // unit quaternion (w, x, y, z), in steps
layout(location = 3) in vec3 corner;   // of the particle's surface, about its centre
layout(location = 4) in vec3 outward;
layout(location = 5) in float scale;   // of this particle
uniform vec2 turnScale;                // low and step
out vec3 normal, point;
flat out vec3 colour;
vec3 turned(vec3 arm) {
  vec4 q = normalize(turnScale.x + turnScale.y * turn);
  return arm + 2.0 * cross(q.yzw, cross(q.yzw, arm) + q.x * arm);
}
void main() {
  vec3 centre = centreOf();
  point = centre + scale * (camera * turned(corner));
  normal = camera * turned(outward);
  colour = gl_InstanceID == picked ? vec3(1.0, 0.25, 0.1) : colourAt(centre);
  gl_Position = onStage(point);
}`,
  // Behind the plane of a cut one sees the surface from inside: drawn flat, it is the section.
  fragment: `#version 300 es
precision highp float;
in vec3 normal, point;
flat in vec3 colour;
out vec4 pixel;
${LIT}
void main() {
#ifdef CUT
  if (dot(cut.xyz, point) > cut.w) discard;
#endif
  pixel = vec4(gl_FrontFacing ? lit(colour, normalize(normal)) : section(colour), 1.0);
}`,
};

// An edge is a thin rectangle; of a round wall only those are drawn that are its outline.
export const EDGES = {
  vertex: `${CAMERA}
layout(location = 0) in vec3 first;
layout(location = 1) in vec3 second;
layout(location = 2) in vec3 normalOne;   // of the two faces beside it; zeros: always drawn
layout(location = 3) in vec3 normalTwo;
uniform float width;                      // half of it [m]
void main() {
  vec3 eye = vec3(camera[0][2], camera[1][2], camera[2][2]);
  bool seen = dot(normalOne, normalOne) < 0.5 || dot(normalOne, eye) * dot(normalTwo, eye) <= 0.0;
  vec3 a = camera * (first + shift - middle), b = camera * (second + shift - middle);
  vec2 along = b.xy - a.xy;
  float size = length(along);
  vec2 across = size > 0.0 ? vec2(-along.y, along.x) / size : vec2(1.0, 0.0);
  vec3 point = (gl_VertexID & 1) == 0 ? a : b;
  point.xy += across * ((gl_VertexID >> 1) == 0 ? width : -width);
  gl_Position = seen ? onStage(point) : vec4(2.0, 2.0, 2.0, 1.0);
}`,
  fragment: `#version 300 es
precision highp float;
uniform vec4 tint;
out vec4 pixel;
void main() { pixel = tint; }`,
};

// Behind all else, and one tint however many walls are there: the first at a pixel keeps it.
export const FACES = {
  vertex: `${CAMERA}
layout(location = 0) in vec3 corner;
void main() {
  gl_Position = onStage(camera * (corner + shift - middle));
  gl_Position.z = 0.9999;
}`,
  fragment: EDGES.fragment,
};
