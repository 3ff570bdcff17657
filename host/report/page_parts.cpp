#include "host/report/page_parts.h"

namespace stria {

const char* const kPageStyle = R"css(
:root { color-scheme: light dark; --ink: #1b1e23; --soft: #5b636e; --paper: #ffffff;
  --rule: #d5d9df; --panel: #f6f7f9; --good: #1a7f45; --bad: #b3261e; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e8eb; --soft: #a0a8b3; --paper: #15181c; --rule: #3a4048; --panel: #1d2126;
    --good: #58c486; --bad: #ff8a80; } }
body { margin: 0 auto; max-width: 1080px; padding: 28px 24px 64px; background: var(--paper);
  color: var(--ink); font: 15px/1.5 system-ui, "Segoe UI", Roboto, sans-serif; }
h1 { font-size: 26px; margin: 0 0 2px; font-weight: 600; }
h2 { font-size: 19px; margin: 40px 0 10px; padding-top: 14px; border-top: 1px solid var(--rule);
  font-weight: 600; }
p { margin: 8px 0; max-width: 46em; }
.subtitle { color: var(--soft); margin: 0 0 18px; }
table { border-collapse: collapse; margin: 12px 0; font-variant-numeric: tabular-nums; }
th, td { padding: 4px 14px 4px 0; text-align: left; border-bottom: 1px solid var(--rule);
  vertical-align: top; }
th { font-weight: 600; color: var(--soft); }
td.number, th.number { text-align: right; padding: 4px 8px 4px 14px; }
.kept { color: var(--good); } .missed { color: var(--bad); font-weight: 600; }
figure { margin: 14px 0; } figcaption, caption { color: var(--soft); text-align: left;
  font-size: 14px; max-width: 60em; padding: 4px 0; }
.row { display: flex; flex-wrap: wrap; gap: 16px; align-items: flex-start; }
.row figure { margin: 0; flex: 1 1 280px; max-width: 100%; }
img { max-width: 100%; height: auto; border: 1px solid var(--rule); background: #fff;
  display: block; }
svg { max-width: 100%; height: auto; color: var(--ink); }
.viewer { position: relative; max-width: 760px; border: 1px solid var(--rule); }
.viewer img { width: 100%; border: 0; }
.viewer canvas { position: absolute; inset: 0; width: 100%; height: 100%; touch-action: none;
  cursor: grab; display: none; }
.scroll { overflow-x: auto; }
@media print { body { max-width: none; } .viewer canvas { display: none !important; } }
)css";

const char* const kViewerScript = R"js(
(() => {
  const bytes = (id) => Uint8Array.from(atob(document.getElementById(id).textContent.trim()),
                                        (c) => c.charCodeAt(0)).buffer;
  const vertexCode = `#version 300 es
    in vec3 place; in vec3 colour; uniform mat3 turn; uniform vec3 size; uniform float zoom;
    uniform vec2 aspect; uniform vec2 shift; out vec3 seen; out vec3 tint;
    void main() { seen = turn * ((place - 0.5) * size); tint = colour;
      gl_Position = vec4(seen.xy * zoom * aspect + shift, -seen.z * 0.3, 1.0); }`;
  const pixelCode = `#version 300 es
    precision highp float; in vec3 seen; in vec3 tint; out vec4 paint;
    void main() { vec3 n = normalize(cross(dFdx(seen), dFdy(seen)));
      paint = vec4(tint * (0.25 + 0.75 * abs(n.z)) * (gl_FrontFacing ? 1.0 : 0.6), 1.0); }`;
  const times = (a, b) => {
    const c = new Array(9).fill(0);
    for (let i = 0; i < 3; i++) for (let j = 0; j < 3; j++) for (let k = 0; k < 3; k++)
      c[3 * j + i] += a[3 * k + i] * b[3 * j + k];
    return c;
  };
  const aboutX = (t) => [1, 0, 0, 0, Math.cos(t), Math.sin(t), 0, -Math.sin(t), Math.cos(t)];
  const aboutY = (t) => [Math.cos(t), 0, -Math.sin(t), 0, 1, 0, Math.sin(t), 0, Math.cos(t)];

  const show = (canvas) => {
    const gl = canvas.getContext('webgl2', {antialias: true, preserveDrawingBuffer: true});
    if (!gl) return;
    const program = gl.createProgram();
    for (const [kind, code] of [[gl.VERTEX_SHADER, vertexCode], [gl.FRAGMENT_SHADER, pixelCode]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, code);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return;
    gl.useProgram(program);
    const id = canvas.dataset.mesh;
    const buffer = (target, data) => {
      gl.bindBuffer(target, gl.createBuffer());
      gl.bufferData(target, data, gl.STATIC_DRAW);
    };
    const attribute = (name, data, type, stride) => {
      buffer(gl.ARRAY_BUFFER, data);
      const at = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, 3, type, true, stride, 0);
    };
    attribute('place', bytes(id + '-places'), gl.UNSIGNED_SHORT, 8);
    attribute('colour', bytes(id + '-colours'), gl.UNSIGNED_BYTE, 4);
    const corners = new Uint32Array(bytes(id + '-corners'));
    buffer(gl.ELEMENT_ARRAY_BUFFER, corners);
    const list = (name) => canvas.dataset[name].split(' ').map(Number);
    const first = list('turn'), size = list('size');
    const fitted = Number(canvas.dataset.zoom);
    let turn = first, zoom = fitted, shift = [0, 0];
    const place = (name) => gl.getUniformLocation(program, name);
    const draw = () => {
      const scale = window.devicePixelRatio || 1;
      canvas.width = canvas.clientWidth * scale;
      canvas.height = canvas.clientHeight * scale;
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clearColor(1, 1, 1, 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      const wide = canvas.width / canvas.height;
      gl.uniformMatrix3fv(place('turn'), false, turn);
      gl.uniform3fv(place('size'), size);
      gl.uniform1f(place('zoom'), zoom);
      gl.uniform2fv(place('aspect'), wide > 1 ? [1 / wide, 1] : [1, wide]);
      gl.uniform2fv(place('shift'), shift);
      gl.drawElements(gl.TRIANGLES, corners.length, gl.UNSIGNED_INT, 0);
    };
    let last = null;
    canvas.addEventListener('pointerdown', (e) => {
      last = [e.clientX, e.clientY];
      canvas.setPointerCapture(e.pointerId);
    });
    canvas.addEventListener('pointermove', (e) => {
      if (!last) return;
      const dx = e.clientX - last[0], dy = e.clientY - last[1];
      last = [e.clientX, e.clientY];
      if (e.shiftKey) {
        shift = [shift[0] + 2 * dx / canvas.clientWidth, shift[1] - 2 * dy / canvas.clientHeight];
      } else {
        turn = times(aboutX(dy * 0.008), times(aboutY(dx * 0.008), turn));
      }
      draw();
    });
    canvas.addEventListener('pointerup', () => { last = null; });
    canvas.addEventListener('wheel', (e) => {
      e.preventDefault();
      zoom = Math.min(60 * fitted, Math.max(0.2 * fitted, zoom * Math.exp(-e.deltaY * 0.0015)));
      draw();
    }, {passive: false});
    canvas.addEventListener('dblclick', () => { turn = first; zoom = fitted; shift = [0, 0]; draw(); });
    new ResizeObserver(draw).observe(canvas);
    canvas.style.display = 'block';
    draw();
  };
  document.querySelectorAll('canvas[data-mesh]').forEach(show);
})();
)js";

}  // namespace stria
