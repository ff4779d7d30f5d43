// SPDX-License-Identifier: BSD-3-Clause
// What is drawn over the points: paths, loops, doubtful sections, changes, the ruler.
(function (lm) {
  'use strict';

  const vertexShader = `
    attribute vec3 other;
    attribute float side;
    uniform vec2 screen;
    uniform float width;
    const float near = 0.05;  // m: a line that begins behind the camera begins there
    vec4 clipped(vec4 p, vec4 q) {
      return p.w >= near ? p : mix(p, q, (near - p.w) / (q.w - p.w));
    }
    void main() {
      vec4 p = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
      vec4 q = projectionMatrix * modelViewMatrix * vec4(other, 1.0);
      if (max(p.w, q.w) <= near) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
        return;
      }
      vec4 from = clipped(p, q), to = clipped(q, p);
      vec2 along = (to.xy / to.w - from.xy / from.w) * screen;
      float length2 = dot(along, along);
      vec2 unit = length2 > 1e-9 ? along * inversesqrt(length2) : vec2(1.0, 0.0);
      vec2 across = vec2(-unit.y, unit.x) * side * 0.5 - unit * 0.5;
      from.xy += across * width / screen * from.w;
      gl_Position = from;
    }`;
  const fragmentShader = `
    uniform vec3 colour;
    uniform float opacity;
    void main() { gl_FragColor = vec4(colour, opacity); }`;

  /** Lines of some pixels' width, which WebGL has not; `segments` are pairs of places. */
  lm.wideLines = function (segments, colour, width, opacity) {
    const count = segments.length;
    const positions = new Float32Array(12 * count), others = new Float32Array(12 * count);
    const sides = new Float32Array(4 * count);
    const index = new Uint32Array(6 * count);
    segments.forEach(([a, b], i) => {
      positions.set([...a, ...a, ...b, ...b], 12 * i);
      others.set([...b, ...b, ...a, ...a], 12 * i);
      sides.set([1, -1, -1, 1], 4 * i);  // seen from the other end, left is right
      index.set([0, 1, 2, 2, 1, 3].map(k => 4 * i + k), 6 * i);
    });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute('other', new THREE.BufferAttribute(others, 3));
    geometry.setAttribute('side', new THREE.BufferAttribute(sides, 1));
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    const material = new THREE.ShaderMaterial({
      vertexShader, fragmentShader, transparent: true, depthTest: false, depthWrite: false, side: THREE.DoubleSide,
      uniforms: {screen: lm.screen, width: {value: width}, colour: {value: new THREE.Color(colour)},
        opacity: {value: opacity}},
    });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false;
    return mesh;
  };
  lm.screen = {value: new THREE.Vector2(1, 1)};  // half of the canvas, pixels

  function segmentsOf(path) {
    return path.slice(1).map((p, i) => [path[i], p]);
  }

  /** The twelve edges of a box, whose corners are numbered by bits: 1 for x, 2 for y, 4 for z. */
  function edgesOf(corners) {
    const edges = [];
    for (let i = 0; i < 8; ++i) {
      for (const bit of [1, 2, 4]) if (!(i & bit)) edges.push([corners[i], corners[i | bit]]);
    }
    return edges;
  }

  const changeColours = {appeared: '#b6f25c', disappeared: '#ff4fd8'};

  lm.changeText = function (change) {
    const date = text => text.replace('T', ' ').slice(0, 16);
    const verb = change.kind === 'appeared' ? 'came' : 'went';
    return `${verb} ${date(change.after)} to ${date(change.before)}, ${change.size.map(v => v.toFixed(1)).join(' × ')} m`;
  };

  const kAround = 0.3;  // m, chosen: about a voxel of the list of changes

  /** The smallest change in whose box a place lies, in the coordinates of the tiles; else none. */
  lm.changeAt = function (marks, p) {
    const inside = change => [0, 1, 2].every(axis => {
      const values = change.corners.map(corner => corner[axis]);
      return p[axis] > Math.min(...values) - kAround && p[axis] < Math.max(...values) + kAround;
    });
    const volume = change => change.size[0] * change.size[1] * change.size[2];
    return marks.changes.filter(inside).sort((a, b) => volume(a) - volume(b))[0];
  };

  /** A scene with a group for each kind of mark. */
  lm.markScene = function (marks, origin) {
    const local = p => p.map((v, i) => v - origin[i]);
    const scene = new THREE.Scene();
    const groups = {path: new THREE.Group(), loops: new THREE.Group(), doubts: new THREE.Group(), changes: new THREE.Group()};
    marks.drives.forEach(drive => {
      const colour = marks.drives.length > 1 ? lm.driveColours[drive.number % lm.driveColours.length] : '#59b8ff';
      groups.path.add(lm.wideLines(segmentsOf(drive.path.map(local)), colour, 2.5, 0.9));
    });
    const loopColours = {accepted: '#4fd27d', refused: '#ff5a4d', undecided: '#f0e26c'};
    for (const verdict of Object.keys(loopColours)) {
      const loops = marks.loops.filter(loop => loop.verdict === verdict);
      groups.loops.add(lm.wideLines(loops.map(l => [local(l.from), local(l.to)]), loopColours[verdict], 2, 0.8));
    }
    for (const doubt of marks.doubts) {
      const path = doubt.path.length > 1 ? doubt.path : [doubt.path[0], doubt.path[0].map((v, i) => v + (i === 2 ? 2 : 0))];
      groups.doubts.add(lm.wideLines(segmentsOf(path.map(local)), doubt.trusted ? '#ffb454' : '#ff5a4d', 7, 0.85));
    }
    for (const kind of Object.keys(changeColours)) {
      const edges = marks.changes.filter(c => c.kind === kind).flatMap(c => edgesOf(c.corners.map(local)));
      groups.changes.add(lm.wideLines(edges, changeColours[kind], 2.5, 0.9));
    }
    for (const name of Object.keys(groups)) {
      groups[name].matrixAutoUpdate = false;
      scene.add(groups[name]);
    }
    return {scene, groups};
  };
}(window.lidarMap = window.lidarMap || {}));
