// SPDX-License-Identifier: BSD-3-Clause
// The page: opens the tiles, draws what is in view, keeps the view in the address.
(function (lm) {
  'use strict';

  // Eye-dome lighting (Boucheny 2009): a pixel is darker the more its neighbours are nearer.
  const edlVertex = 'varying vec2 at; void main() { at = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }';
  const edlFragment = `
    uniform sampler2D colours, depths;
    uniform vec2 pixel;
    uniform float near, far, strength;
    varying vec2 at;
    float logDepth(vec2 p) {
      float d = texture2D(depths, p).r;
      return d >= 1.0 ? 0.0 : log2(near * far / (far - d * (far - near)));
    }
    void main() {
      vec4 colour = texture2D(colours, at);
      float own = logDepth(at), sum = 0.0;
      bool empty = texture2D(depths, at).r >= 1.0;
      for (int i = 0; i < 8; ++i) {
        float angle = 0.7853982 * float(i);
        float other = logDepth(at + 1.4 * pixel * vec2(cos(angle), sin(angle)));
        if (other != 0.0) sum += empty ? 0.0 : clamp(own - other, 0.0, 0.03);  // a limit, so that no edge is black
      }
      float shade = exp(-strength * 40.0 * sum / 8.0);
      gl_FragColor = vec4(colour.rgb * (empty ? 1.0 : shade), 1.0);
    }`;

  class Screen {
    constructor(canvas) {
      this.canvas = canvas;
      this.renderer = new THREE.WebGLRenderer({canvas, antialias: true});
      this.renderer.autoClear = false;
      this.renderer.setClearColor('#11151a');
      this.shades = this.renderer.extensions.get('WEBGL_depth_texture') !== null;
      this.edl = new THREE.ShaderMaterial({vertexShader: edlVertex, fragmentShader: edlFragment, depthTest: false, depthWrite: false,
        uniforms: {colours: {value: null}, depths: {value: null}, pixel: {value: new THREE.Vector2()}, near: {value: 1},
          far: {value: 2}, strength: {value: 1}}});
      this.quad = new THREE.Scene();
      const mesh = new THREE.Mesh(new THREE.PlaneBufferGeometry(2, 2), this.edl);
      mesh.frustumCulled = false;
      this.quad.add(mesh);
      this.flat = new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 1);
    }

    resize() {
      const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
      const ratio = Math.min(2, window.devicePixelRatio || 1);
      if (this.width === width && this.height === height && this.ratio === ratio) return;
      Object.assign(this, {width, height, ratio});
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(width, height, false);
      const w = Math.max(1, Math.floor(width * ratio)), h = Math.max(1, Math.floor(height * ratio));
      lm.screen.value.set(width / 2, height / 2);
      if (this.buffer) this.buffer.dispose();
      this.buffer = new THREE.WebGLRenderTarget(w, h, {minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter});
      if (this.shades) {
        this.buffer.depthTexture = new THREE.DepthTexture(w, h, THREE.UnsignedIntType);
        this.buffer.depthTexture.minFilter = this.buffer.depthTexture.magFilter = THREE.NearestFilter;
      }
      this.edl.uniforms.pixel.value.set(ratio / w, ratio / h);
    }

    draw(points, over, camera) {
      const u = this.edl.uniforms;
      const shaded = this.shades && u.strength.value > 0;
      this.renderer.setRenderTarget(shaded ? this.buffer : null);
      this.renderer.clear();
      this.renderer.render(points, camera);
      if (shaded) {
        this.renderer.setRenderTarget(null);
        Object.assign(u.colours, {value: this.buffer.texture});
        Object.assign(u.depths, {value: this.buffer.depthTexture});
        u.near.value = camera.near;
        u.far.value = camera.far;
        this.renderer.clear();
        this.renderer.render(this.quad, this.flat);
      }
      over.forEach(scene => this.renderer.render(scene, camera));
    }
  }

  class Page {
    constructor(tiles, marks) {
      const canvas = document.getElementById('view');
      Object.assign(this, {tiles, marks, canvas, origin: tiles.origin, dirty: true, last: 0});
      this.screen = new Screen(canvas);
      const changed = () => { this.dirty = true; };
      const pick = (x, y) => this.pick(x, y);
      this.points = new lm.Points(tiles, marks.resolution, changed);
      this.camera = new lm.Camera(canvas, pick, changed);
      this.ruler = new lm.Ruler(canvas, document.getElementById('labels'), document.getElementById('ruler'), pick, changed);
      this.overlay = lm.markScene(marks, this.origin);
      this.overlay.groups.loops.visible = this.overlay.groups.changes.visible = false;
      const b = tiles.ept.boundsConforming;
      this.size = Math.hypot(b[3] - b[0], b[4] - b[1], b[5] - b[2]);
      this.home(false);
      this.readHash();
      this.connect();
      window.addEventListener('resize', changed);
      window.addEventListener('hashchange', () => { if (location.hash.slice(1) !== this.hash) this.readHash(); });
      this.followPointer();
      requestAnimationFrame(time => this.tick(time));
    }

    /** The place under a position of the pointer in the window. */
    pick(x, y) {
      const ndc = new THREE.Vector2(2 * x / this.canvas.clientWidth - 1, 1 - 2 * y / this.canvas.clientHeight);
      const caster = new THREE.Raycaster();
      caster.setFromCamera(ndc, this.camera.camera);
      return this.points.pick(caster.ray, this.camera.perPixel());
    }

    home(above) {
      const b = this.tiles.ept.boundsConforming, o = this.origin;
      const middle = new THREE.Vector3((b[0] + b[3]) / 2 - o[0], (b[1] + b[4]) / 2 - o[1], b[2] - o[2]);
      this.camera.flying = false;
      const width = b[3] - b[0], depth = b[4] - b[1];
      const aspect = this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight);
      if (above) return this.camera.goTo(middle, 1.02 * Math.max(width / aspect, depth), Math.PI / 2, 0);
      this.camera.goTo(middle, 0.62 * Math.hypot(width, depth) / Math.min(1, aspect) + 5, 0.62, -0.5);
      // The panel covers a part at the left.
      const covered = document.body.classList.contains('folded') || this.canvas.clientWidth < 700 ? 0 : 250;
      this.camera.move(-covered / 2 * this.camera.perPixel() * this.camera.distance, 0, 0);
    }

    connect() {
      const changed = () => { this.dirty = true; };
      const set = change => value => { change(value); changed(); };
      lm.connectPanel({
        colour: set(name => this.points.setColour(name)),
        mark: (name, on) => { this.overlay.groups[name].visible = on; changed(); },
        size: set(value => this.points.setSize(value)),
        budget: set(value => { this.points.budget = 1e6 * value; }),
        depth: set(value => { this.screen.edl.uniforms.strength.value = value; }),
        home: () => this.home(false),
        top: () => this.home(true),
        fly: () => { this.camera.flying = !this.camera.flying; changed(); },
        measure: () => this.setMeasuring(!this.ruler.active),
        escape: () => this.setMeasuring(false),
        fold: () => document.body.classList.toggle('folded'),
        folder: files => lm.start(lm.chosenFiles(files)),
        link: () => (navigator.clipboard ? navigator.clipboard.writeText(location.href) : Promise.reject(new Error('no clipboard'))),
      });
      lm.showTitle(this.marks, this.tiles);
      const show = name => (middle, distance) => {
        this.overlay.groups[name].visible = true;
        this.camera.flying = false;
        this.camera.goTo(middle, distance);
      };
      lm.listDoubts(this.marks, this.origin, show('doubts'));
      lm.listChanges(this.marks, this.origin, show('changes'));
    }

    setMeasuring(on) {
      this.ruler.setActive(on);
      this.camera.enabled = !on;  // a double click would set two points and move the view
    }

    readHash() {
      const values = new URLSearchParams(location.hash.slice(1));
      this.camera.fromHash(values, this.origin);
      if (['height', 'intensity', 'time', 'drive'].includes(values.get('c'))) this.points.setColour(values.get('c'));
      if (values.has('show')) {
        const shown = values.get('show').split(',');
        for (const name of Object.keys(this.overlay.groups)) this.overlay.groups[name].visible = shown.includes(name);
      }
      this.dirty = true;
    }

    writeHash() {
      const groups = this.overlay.groups;
      this.hash = `${this.camera.toHash(this.origin)}&c=${this.points.colour}`
        + `&show=${Object.keys(groups).filter(name => groups[name].visible).join(',')}`;
      history.replaceState(null, '', `#${this.hash}`);
    }

    followPointer() {
      let waiting = null;
      this.canvas.addEventListener('pointermove', event => {
        if (this.camera.pointers.size > 0 || waiting) return;
        waiting = setTimeout(() => {
          waiting = null;
          const at = this.pick(event.clientX, event.clientY);
          lm.showPlace(at ? this.textAt(at.toArray().map((v, i) => v + this.origin[i])) : '');
        }, 60);
      });
    }

    /** A place and, where changes are shown, what came or went there. */
    textAt(place) {
      const change = this.overlay.groups.changes.visible ? lm.changeAt(this.marks, place) : undefined;
      const text = lm.placeText(this.marks.epsg, place);
      return change ? `${text}   ${lm.changeText(change)}` : text;
    }

    tick(time) {
      const moved = this.camera.fly(Math.min(0.1, (time - this.last) / 1000));
      this.last = time;
      const resized = this.screen.width !== this.canvas.clientWidth || this.screen.height !== this.canvas.clientHeight;
      if (this.dirty || moved || resized) {
        this.dirty = false;
        this.draw();
      }
      requestAnimationFrame(next => this.tick(next));
    }

    draw() {
      this.screen.resize();
      this.camera.apply(this.screen.width / Math.max(1, this.screen.height), this.size);
      this.points.update(this.camera.camera, this.screen.height * this.screen.ratio);
      this.screen.draw(this.points.scene, [this.overlay.scene, this.ruler.scene], this.camera.camera);
      this.ruler.place(this.camera.camera, this.screen.width, this.screen.height);
      this.showState();
      clearTimeout(this.hashTimer);
      this.hashTimer = setTimeout(() => this.writeHash(), 300);
    }

    showState() {
      lm.showControls({colour: this.points.colour, flying: this.camera.flying, measuring: this.ruler.active,
        budget: this.points.budget / 1e6, marks: this.overlay.groups});
      lm.showLegend(this.points, this.marks);
      lm.showLoad(this.points);
      // What a test reads: how many points are drawn, and when the first were.
      const data = document.documentElement.dataset;
      data.points = this.points.shown;
      if (this.points.shown > 0 && data.firstPicture === undefined) data.firstPicture = Math.round(performance.now());
      data.state = this.points.missing > 0 || this.points.shown === 0 ? 'loading' : 'ready';
    }
  }

  /** Shows the tiles that these files hold. */
  lm.start = function (files) {
    lm.openTiles(files).then(tiles => {
      if (location.protocol === 'file:') lm.showFileNote(tiles);
      if (!lm.page) {
        lm.page = new Page(tiles, lm.marks);
        return;
      }
      const colour = lm.page.points.colour;
      lm.page.points = new lm.Points(tiles, lm.marks.resolution, () => { lm.page.dirty = true; });
      lm.page.points.setColour(colour);
      lm.page.dirty = true;
    }).catch(lm.problem);
  };

  function loadScript(path) {
    return new Promise((resolve, reject) => {
      const script = document.createElement('script');
      script.src = path;
      script.onload = resolve;
      script.onerror = () => reject(new Error(`${path} is missing; copy the whole folder of the page`));
      document.head.append(script);
    });
  }

  try {
    if (!window.THREE || !lm.marks) throw new Error('viewer/three.min.js or viewer/marks.js is missing; copy the whole folder of the page');
    if (location.protocol === 'file:') {
      loadScript('viewer/overview.js').then(() => lm.start(lm.overviewFiles(lm.overview))).catch(lm.problem);
    } else {
      lm.start(lm.serverFiles());
    }
  } catch (error) {
    lm.problem(error);
  }
}(window.lidarMap = window.lidarMap || {}));
