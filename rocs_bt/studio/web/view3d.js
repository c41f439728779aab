// @ts-check
// Shapes in three dimensions with plain WebGL: boxes, spheres, ellipsoids, cylinders, capsules, prisms and lines.

const VERTEX = `#version 300 es
uniform mat4 view, place;
in vec3 at, normal;
out vec3 face, point;
void main() {
  point = (place * vec4(at, 1.0)).xyz;
  face = normalize(transpose(inverse(mat3(place))) * normal);
  gl_Position = view * vec4(point, 1.0);
}`;
const FRAGMENT = `#version 300 es
precision mediump float;
uniform vec4 tint;
uniform float grid;
in vec3 face, point;
out vec4 shade;
void main() {
  float light = 0.45 + 0.55 * max(0.0, dot(normalize(face), normalize(vec3(0.4, 0.3, 0.85))));
  shade = vec4(tint.rgb * light, tint.a);
  if (grid > 0.0) {
    vec2 line = abs(fract(point.xy - 0.5) - 0.5) / fwidth(point.xy);
    shade = vec4(tint.rgb * (0.88 + 0.12 * min(1.0, min(line.x, line.y))), 1.0);
  }
}`;
const NEAR = 0.05, FAR = 400, LENS = 1 / Math.tan(0.4);
const PARTS = 20; // of a round shape

/** Product of two matrices, column by column. */
export const times = (a, b) => {
  const c = new Float32Array(16);
  for (let i = 0; i < 4; i++) for (let j = 0; j < 4; j++) for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
};

/** Matrix of a position, a quaternion (w, x, y, z) and a scale. */
export const placed = (
  /** @type {number[]} */ [x, y, z], /** @type {number[]} */ [w, i, j, k] = [1, 0, 0, 0], /** @type {number[]} */ [a, b, c] = [1, 1, 1],
) => new Float32Array([
  a * (1 - 2 * (j * j + k * k)), a * 2 * (i * j + k * w), a * 2 * (i * k - j * w), 0,
  b * 2 * (i * j - k * w), b * (1 - 2 * (i * i + k * k)), b * 2 * (j * k + i * w), 0,
  c * 2 * (i * k + j * w), c * 2 * (j * k - i * w), c * (1 - 2 * (i * i + j * j)), 0,
  x, y, z, 1,
]);

/** Surface of revolution through a profile of (radius, height, radius and height of the normal). */
const turned = (profile) => {
  const out = [], at = ([r, z, nr, nz], part) => {
    const c = Math.cos((2 * Math.PI * part) / PARTS), s = Math.sin((2 * Math.PI * part) / PARTS);
    return [r * c, r * s, z, nr * c, nr * s, nz];
  };
  for (let i = 0; i + 1 < profile.length; i++) for (let k = 0; k < PARTS; k++) {
    const [a, b, c, d] = [at(profile[i], k), at(profile[i], k + 1), at(profile[i + 1], k + 1), at(profile[i + 1], k)];
    out.push(...a, ...b, ...c, ...a, ...c, ...d);
  }
  return out;
};

/** Upright prism over a convex polygon, from one height to another: triangles, of each corner its point and normal. */
const prism = (points, low, high) => {
  const out = [], n = points.length, area = points.reduce((sum, [x, y], i) => sum + x * points[(i + 1) % n][1] - points[(i + 1) % n][0] * y, 0);
  const outline = area > 0 ? points : [...points].reverse();
  for (let i = 0; i < n; i++) {
    const [a, b] = outline[i], [c, d] = outline[(i + 1) % n], length = Math.hypot(c - a, d - b) || 1;
    const normal = [(d - b) / length, (a - c) / length, 0];
    for (const corner of [[a, b, low], [c, d, low], [c, d, high], [a, b, low], [c, d, high], [a, b, high]]) out.push(...corner, ...normal);
    const corners = i > 1 ? [outline[0], outline[i - 1], outline[i]] : [];
    for (const [z, up] of [[low, -1], [high, 1]]) for (const [x, y] of corners) out.push(x, y, z, 0, 0, up);
  }
  return out;
};

const SQUARE = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
const ARC = Array.from({ length: 13 }, (_, i) => {
  const angle = -Math.PI / 2 + (Math.PI * i) / 12, c = Math.cos(angle), s = Math.sin(angle);
  return [c, s, c, s];
});
const CAN = [[0, -1, 0, -1], [1, -1, 0, -1], [1, -1, 1, 0], [1, 1, 1, 0], [1, 1, 0, 1], [0, 1, 0, 1]];

/**
 * A shape of a body: kind, size as in MuJoCo (half sizes; of a prism its points and height), position and quaternion
 * in the frame of the body, and colour.
 * @typedef {{kind: string, size: any[], position: number[], quaternion: number[], tint: number[], body: number}} Shape
 */

export class View3d {
  /** @param {HTMLCanvasElement} canvas @param {Shape[]} shapes @throws {Error} without WebGL2 */
  constructor(canvas, shapes, target, distance) {
    const gl = canvas.getContext("webgl2", { antialias: true });
    if (!gl) throw new Error("this browser has no WebGL 2");
    this.canvas = canvas;
    this.gl = gl;
    this.target = target;
    this.distance = distance;
    this.turn = -1.2;
    this.tilt = 0.7;
    this.sky = [1, 1, 1];
    this.bodies = [];
    this.ways = [];
    this.drawn = () => {};
    this.line = null;
    this.program();
    const known = { box: prism(SQUARE, -1, 1), sphere: turned(ARC), cylinder: turned(CAN) };
    this.meshes = new Map(Object.entries(known).map(([name, data]) => [name, this.mesh(data)]));
    this.parts = shapes.flatMap((shape) => this.partsOf(shape));
    canvas.addEventListener("pointermove", (event) => this.drag(event));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.distance = Math.min(FAR / 2, Math.max(0.3, this.distance * Math.exp(event.deltaY * 0.001)));
      this.draw();
    }, { passive: false });
  }

  program() {
    const { gl } = this, program = gl.createProgram();
    for (const { kind, text } of [{ kind: gl.VERTEX_SHADER, text: VERTEX }, { kind: gl.FRAGMENT_SHADER, text: FRAGMENT }]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, "at");
    gl.bindAttribLocation(program, 1, "normal");
    gl.linkProgram(program);
    gl.useProgram(program);
    this.uniforms = Object.fromEntries(["view", "place", "tint", "grid"].map((name) => [name, gl.getUniformLocation(program, name)]));
  }

  mesh(data) {
    const { gl } = this, vao = gl.createVertexArray();
    gl.bindVertexArray(vao);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(data), gl.STATIC_DRAW);
    for (const i of [0, 1]) {
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, 3, gl.FLOAT, false, 24, 12 * i);
    }
    return { vao, count: data.length / 6 };
  }

  partsOf({ kind, size, position, quaternion, tint, body }) {
    const local = placed(position, quaternion), [a, b, c] = size;
    const part = (name, at, scale) => ({ mesh: this.meshes.get(name), body, tint, local: times(local, placed(at, undefined, scale)) });
    if (kind === "prism") return [{ mesh: this.mesh(prism(a, 0, b)), body, tint, local }];
    if (kind === "capsule") return [part("cylinder", [0, 0, 0], [a, a, b]), part("sphere", [0, 0, b], [a, a, a]), part("sphere", [0, 0, -b], [a, a, a])];
    if (kind === "cylinder") return [part("cylinder", [0, 0, 0], [a, a, b])];
    if (kind === "sphere") return [part("sphere", [0, 0, 0], [a, a, a])];
    return [part(kind === "box" ? "box" : "sphere", [0, 0, 0], [a, b, c])];
  }

  drag(event) {
    if (event.buttons !== 1) return;
    this.turn -= event.movementX * 0.01;
    this.tilt = Math.min(1.55, Math.max(0.02, this.tilt + event.movementY * 0.01));
    this.draw();
  }

  camera() {
    const { turn, tilt, distance, target: [x, y, z], canvas } = this, c = Math.cos(tilt), s = Math.sin(tilt);
    const back = [c * Math.cos(turn), c * Math.sin(turn), s], right = [-Math.sin(turn), Math.cos(turn), 0], up = [-s * Math.cos(turn), -s * Math.sin(turn), c];
    const eye = [x + distance * back[0], y + distance * back[1], z + distance * back[2]];
    const to = (axis) => -(axis[0] * eye[0] + axis[1] * eye[1] + axis[2] * eye[2]);
    const look = new Float32Array([right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0, to(right), to(up), to(back), 1]);
    const lens = new Float32Array([
      (LENS * canvas.height) / canvas.width, 0, 0, 0, 0, LENS, 0, 0,
      0, 0, (FAR + NEAR) / (NEAR - FAR), -1, 0, 0, (2 * FAR * NEAR) / (NEAR - FAR), 0,
    ]);
    return times(lens, look);
  }

  /** Where a point of the world is in the picture [px]. */
  seen([x, y, z]) {
    const m = this.camera(), [a, b, w] = [0, 1, 3].map((row) => m[row] * x + m[4 + row] * y + m[8 + row] * z + m[12 + row]);
    return [0.5 * this.canvas.clientWidth * (1 + a / w), 0.5 * this.canvas.clientHeight * (1 - b / w)];
  }

  /** Draws the bodies at their matrices, of which the first is the world, and ways: points of the world with a colour. */
  draw(bodies = this.bodies, ways = this.ways) {
    const { gl, uniforms, canvas, sky } = this, ratio = devicePixelRatio || 1;
    this.bodies = bodies;
    this.ways = ways;
    if (!bodies || !canvas.clientWidth) return;
    canvas.width = canvas.clientWidth * ratio;
    canvas.height = canvas.clientHeight * ratio;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(sky[0], sky[1], sky[2], 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.uniformMatrix4fv(uniforms.view, false, this.camera());
    const show = ({ vao, count }, place, tint, grid = 0) => {
      gl.bindVertexArray(vao);
      gl.uniformMatrix4fv(uniforms.place, false, place);
      gl.uniform4fv(uniforms.tint, tint);
      gl.uniform1f(uniforms.grid, grid);
      gl.drawArrays(gl.TRIANGLES, 0, count);
    };
    show(this.meshes.get("box"), placed([0, 0, -0.01], undefined, [100, 100, 0.01]), [...sky.map((part) => part * 0.94), 1], 1);
    for (const { mesh, body, local, tint } of this.parts) if (bodies[body]) show(mesh, times(bodies[body], local), tint);
    for (const { points, tint, pairs } of ways) this.way(points, tint, pairs);
    this.drawn();
  }

  /** Draws lines from each point to the next, or between pairs of points. */
  way(points, tint, pairs = false) {
    if (points.length < 2) return;
    const { gl, uniforms } = this;
    this.line ??= { vao: gl.createVertexArray(), buffer: gl.createBuffer() };
    gl.bindVertexArray(this.line.vao);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.line.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(points.flat()), gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 12, 0);
    gl.disableVertexAttribArray(1);
    gl.vertexAttrib3f(1, 0, 0, 1);
    gl.uniformMatrix4fv(uniforms.place, false, placed([0, 0, 0]));
    gl.uniform4fv(uniforms.tint, tint);
    gl.uniform1f(uniforms.grid, 0);
    gl.drawArrays(pairs ? gl.LINES : gl.LINE_STRIP, 0, points.length);
  }
}
