// SPDX-License-Identifier: BSD-3-Clause
// The points in view: nodes of the octree by how large they appear, nearest details first.
(function (lm) {
  'use strict';

  const kMinPixels = 130;      // a node that appears smaller is fine enough: 128 cells, so a pixel each
  const kRequests = 6;         // at the same time, what browsers allow to one server
  const kKept = 2.5;           // loaded points that are kept, as a multiple of those that may be shown

  const vertexShader = `
    attribute vec3 values;
    uniform float mode, low, high, size, pixels, most, least;
    varying float at;
    void main() {
      vec4 seen = modelViewMatrix * vec4(position, 1.0);
      gl_Position = projectionMatrix * seen;
      gl_PointSize = clamp(size * pixels / max(gl_Position.w, 0.01), least, most);
      float value = mode < 0.5 ? position.z : mode < 1.5 ? values.x : mode < 2.5 ? values.y : values.z;
      at = mode > 2.5 ? (mod(value, 250.0) + 0.5) / 256.0 : clamp((value - low) / (high - low), 0.002, 0.998);
    }`;
  const fragmentShader = `
    uniform sampler2D ramp;
    varying float at;
    void main() {
      vec2 p = gl_PointCoord - 0.5;
      if (dot(p, p) > 0.27) discard;
      gl_FragColor = vec4(texture2D(ramp, vec2(at, 0.5)).rgb, 1.0);
    }`;

  const modes = ['height', 'intensity', 'time', 'drive'];

  class Node {
    constructor(tiles, depth, x, y, z) {
      Object.assign(this, {depth, x, y, z, name: `${depth}-${x}-${y}-${z}`, state: 'new', mesh: null, used: 0});
      const edge = tiles.edge / 2 ** depth;
      const low = [x, y, z].map((k, i) => tiles.bounds[i] + k * edge - tiles.origin[i]);
      this.box = new THREE.Box3(new THREE.Vector3(...low), new THREE.Vector3(...low.map(v => v + edge)));
      this.sphere = this.box.getBoundingSphere(new THREE.Sphere());
      this.children = null;
    }

    childrenIn(tiles) {
      if (this.children) return this.children;
      this.children = [];
      for (let i = 0; i < 8; ++i) {
        const child = new Node(tiles, this.depth + 1, 2 * this.x + (i & 1), 2 * this.y + (i >> 1 & 1), 2 * this.z + (i >> 2));
        if (tiles.counts[child.name] !== undefined) this.children.push(child);
      }
      return this.children;
    }
  }

  /** The value below which this part of a sorted list lies. */
  function quantile(sorted, part) {
    return sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))];
  }

  class Points {
    constructor(tiles, resolution, changed) {
      this.tiles = tiles;
      this.changed = changed;  // called when a node has come
      this.budget = 2e6;
      this.loading = 0;
      this.loaded = new Set();
      this.visible = [];
      this.frame = 0;
      this.shown = 0;
      this.scene = new THREE.Scene();
      this.resolution = resolution;
      this.ranges = {height: [0, 1], intensity: [0, 1], time: [0, 1], drive: [0, 1]};
      this.root = new Node(tiles, 0, 0, 0, 0);
      this.material = new THREE.ShaderMaterial({
        vertexShader, fragmentShader,
        uniforms: {mode: {value: 0}, low: {value: 0}, high: {value: 1}, size: {value: resolution},
          pixels: {value: 1}, least: {value: 2}, most: {value: 40}, ramp: {value: null}},
      });
      this.setSize(1);
      this.setColour('height');
    }

    setColour(name) {
      this.colour = name;
      const bytes = lm.ramp(name);
      const texture = new THREE.DataTexture(bytes, 256, 1, THREE.RGBFormat);
      texture.needsUpdate = true;
      if (this.material.uniforms.ramp.value) this.material.uniforms.ramp.value.dispose();
      this.material.uniforms.ramp.value = texture;
      this.material.uniforms.mode.value = modes.indexOf(name);
      [this.material.uniforms.low.value, this.material.uniforms.high.value] = this.ranges[name];
    }

    setSize(factor) {
      this.material.uniforms.size.value = 1.7 * factor * this.resolution;  // centroids lie up to two edges apart
      this.material.uniforms.least.value = 2.2 * factor;  // pixels: no gaps between cells
    }

    /** Ranges of the colours: all but the outermost hundredths of the points of the root. */
    measure(parsed) {
      const heights = [], intensities = [];
      for (let i = 0; i < parsed.count; ++i) {
        heights.push(parsed.positions[3 * i + 2]);
        intensities.push(parsed.values[3 * i]);
      }
      const number = (a, b) => a - b;
      heights.sort(number);
      intensities.sort(number);
      const range = (sorted, least) => {
        const low = quantile(sorted, 0.01);
        return [low, Math.max(quantile(sorted, 0.98), low + least)];
      };
      this.ranges.height = range(heights, 1);
      this.ranges.intensity = range(intensities, 1e-4);
      this.setColour(this.colour);
    }

    request(node) {
      if (node.state !== 'new' || this.loading >= kRequests) return;
      node.state = 'loading';
      ++this.loading;
      const whole = this.tiles.counts[node.name] === -1 ? this.tiles.loadHierarchy(node.name) : Promise.resolve();
      whole.then(() => this.tiles.load(node.name)).then(parsed => this.show(node, parsed)).catch(error => {
        node.state = 'failed';
        lm.problem(error);
      }).then(() => {
        --this.loading;
        this.changed();
      });
    }

    show(node, parsed) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(parsed.positions, 3));
      geometry.setAttribute('values', new THREE.BufferAttribute(parsed.values, 3));
      geometry.boundingSphere = node.sphere;
      node.mesh = new THREE.Points(geometry, this.material);
      node.mesh.frustumCulled = false;  // nodes out of view are not in the scene
      node.mesh.matrixAutoUpdate = false;
      node.count = parsed.count;
      node.state = 'loaded';
      this.loaded.add(node);
      if (node === this.root) this.measure(parsed);
    }

    /** Chooses the nodes for this view and asks for those that are missing. */
    update(camera, height) {
      ++this.frame;
      const frustum = new THREE.Frustum().setFromMatrix(
        new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse));
      const perMetre = height / (2 * Math.tan(camera.fov * Math.PI / 360));
      this.material.uniforms.pixels.value = perMetre;
      const pixelsOf = node => {
        const distance = Math.max(0.1, camera.position.distanceTo(node.sphere.center) - node.sphere.radius);
        return perMetre * node.sphere.radius / distance;
      };
      const queue = [[Infinity, this.root]];
      this.visible = [];
      this.shown = 0;
      this.missing = 0;
      while (queue.length > 0) {
        let best = 0;
        for (let i = 1; i < queue.length; ++i) if (queue[i][0] > queue[best][0]) best = i;
        const [pixels, node] = queue.splice(best, 1)[0];
        const count = Math.max(0, this.tiles.counts[node.name]);
        if (this.shown + count > this.budget) break;
        node.used = this.frame;
        if (node.state === 'loaded') {
          this.visible.push(node);
          this.shown += count;
          for (const child of node.childrenIn(this.tiles)) {
            const size = pixelsOf(child);
            if (size > kMinPixels && frustum.intersectsBox(child.box)) queue.push([size, child]);
          }
        } else if (node.state !== 'failed') {
          ++this.missing;
          this.request(node);
        }
      }
      this.refill();
    }

    /** The scene holds just the visible nodes; the least used of the others are given up. */
    refill() {
      this.scene.children = this.visible.map(node => node.mesh);
      let kept = 0;
      for (const node of this.loaded) kept += node.count;
      if (kept < kKept * this.budget) return;
      for (const node of [...this.loaded].sort((a, b) => a.used - b.used)) {
        if (kept < kKept * this.budget || node.used === this.frame) return;
        kept -= node.count;
        node.mesh.geometry.dispose();
        node.mesh = null;
        node.state = 'new';
        this.loaded.delete(node);
      }
    }

    /** The visible point that a ray meets first, within a few pixels of it; null if there is none. */
    pick(ray, perPixel) {
      let best = null, bestCost = Infinity;
      const o = ray.origin, d = ray.direction;
      const tolerance = 6 * perPixel;  // of the distance: six pixels
      for (const node of this.visible) {
        const far = node.sphere.radius + tolerance * o.distanceTo(node.sphere.center);
        if (ray.distanceSqToPoint(node.sphere.center) > far * far) continue;
        const p = node.mesh.geometry.attributes.position.array;
        for (let i = 0; i < p.length; i += 3) {
          const x = p[i] - o.x, y = p[i + 1] - o.y, z = p[i + 2] - o.z;
          const along = x * d.x + y * d.y + z * d.z;
          if (along < 0.1) continue;
          const beside = x * x + y * y + z * z - along * along;
          const limit = Math.max(tolerance * along, 0.7 * this.resolution);
          if (beside > limit * limit) continue;
          const cost = along * (1 + 4 * Math.sqrt(Math.max(0, beside)) * tolerance / limit);
          if (cost < bestCost) { bestCost = cost; best = [p[i], p[i + 1], p[i + 2]]; }
        }
      }
      return best && new THREE.Vector3(...best);
    }
  }

  lm.Points = Points;
}(window.lidarMap = window.lidarMap || {}));
