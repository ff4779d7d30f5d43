// SPDX-License-Identifier: BSD-3-Clause
// Orbit and fly: the camera looks at a target from a distance, along azimuth and elevation.
(function (lm) {
  'use strict';

  const kTurn = 0.005;  // rad per pixel
  const kLow = -1.45, kHigh = 1.5697;  // rad; just below 90 degrees, so that up is always defined

  class Camera {
    constructor(canvas, pick, changed) {
      this.canvas = canvas;
      this.pick = pick;  // place under a position of the pointer, or null
      this.changed = changed;
      this.camera = new THREE.PerspectiveCamera(55, 1, 0.1, 1000);
      this.camera.up.set(0, 0, 1);
      this.target = new THREE.Vector3();
      this.distance = 100;
      this.azimuth = 0;    // rad, of the direction of view from north, clockwise
      this.elevation = 0.6;  // rad, of the camera above the target
      this.flying = false;
      this.keys = new Set();
      this.pointers = new Map();
      this.enabled = true;
      this.listen();
    }

    direction() {
      const c = Math.cos(this.elevation);
      return new THREE.Vector3(Math.sin(this.azimuth) * c, Math.cos(this.azimuth) * c, -Math.sin(this.elevation));
    }

    apply(aspect, size) {
      const direction = this.direction();
      this.camera.position.copy(this.target).addScaledVector(direction, -this.distance);
      this.camera.aspect = aspect;
      this.camera.near = Math.max(0.2, Math.min(this.distance, 2000) / 400);
      this.camera.far = this.distance + 3 * size;
      this.camera.lookAt(this.target);
      this.camera.updateProjectionMatrix();
      this.camera.updateMatrixWorld();
    }

    turn(dx, dy) {
      const eye = this.target.clone().addScaledVector(this.direction(), -this.distance);
      // Turning about the target, the map follows the pointer; flying, the view does.
      const turn = kTurn * (this.flying ? 0.6 : 1);
      this.azimuth += turn * dx;
      this.elevation += turn * dy;
      this.elevation = Math.min(kHigh, Math.max(kLow, this.elevation));
      if (this.flying) this.target.copy(eye).addScaledVector(this.direction(), this.distance);
      this.changed();
    }

    move(right, up, forward) {
      const ahead = this.direction();
      const flat = new THREE.Vector3(Math.cos(this.azimuth), -Math.sin(this.azimuth), 0);
      this.target.addScaledVector(flat, right).addScaledVector(ahead, forward)
        .addScaledVector(new THREE.Vector3().crossVectors(flat, ahead), up);
      this.changed();
    }

    perPixel() {
      return 2 * Math.tan(this.camera.fov * Math.PI / 360) / this.canvas.clientHeight;
    }

    zoom(factor, at) {
      if (this.flying) return this.move(0, 0, this.distance * (1 - factor));
      if (at) this.target.lerp(at, 1 - factor);
      this.distance = Math.min(2e5, Math.max(0.5, this.distance * factor));
      this.changed();
    }

    goTo(target, distance, elevation, azimuth) {
      this.target.copy(target);
      this.distance = distance;
      if (elevation !== undefined) this.elevation = elevation;
      if (azimuth !== undefined) this.azimuth = azimuth;
      this.changed();
    }

    /** Moves as the pressed keys say; true while any is pressed. */
    fly(seconds) {
      const amount = (plus, minus) => (this.keys.has(plus) ? 1 : 0) - (this.keys.has(minus) ? 1 : 0);
      const right = amount('KeyD', 'KeyA'), forward = amount('KeyW', 'KeyS'), up = amount('KeyE', 'KeyQ');
      if (!right && !forward && !up) return false;
      // m/s: a street in some seconds from close by, a town in some seconds from above
      const speed = Math.min(150, Math.max(6, 0.6 * this.distance)) * (this.keys.has('ShiftLeft') ? 4 : 1) * seconds;
      this.move(right * speed, up * speed, forward * speed);
      return true;
    }

    drag(event) {
      const last = this.pointers.get(event.pointerId);
      if (!last) return;
      const dx = event.clientX - last.x, dy = event.clientY - last.y;
      if (this.pointers.size === 2) this.pinch(event);
      this.pointers.set(event.pointerId, {x: event.clientX, y: event.clientY, button: last.button});
      const shifts = last.button === 2 || last.button === 1 || event.shiftKey || this.pointers.size === 2;
      if (!shifts) return this.turn(dx, dy);
      const step = this.perPixel() * this.distance / (this.pointers.size === 2 ? 2 : 1);
      this.move(-dx * step, dy * step, 0);
    }

    pinch(event) {
      const others = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, p]) => p);
      const me = this.pointers.get(event.pointerId);
      const before = Math.hypot(me.x - others[0].x, me.y - others[0].y);
      const now = Math.hypot(event.clientX - others[0].x, event.clientY - others[0].y);
      if (now > 1) this.zoom(before / now, null);
    }

    listen() {
      const canvas = this.canvas;
      canvas.addEventListener('contextmenu', event => event.preventDefault());
      canvas.addEventListener('pointerdown', event => {
        canvas.setPointerCapture(event.pointerId);
        canvas.focus();
        this.pointers.set(event.pointerId, {x: event.clientX, y: event.clientY, button: event.button});
        canvas.classList.add('dragging');
      });
      canvas.addEventListener('pointermove', event => this.drag(event));
      const release = event => {
        this.pointers.delete(event.pointerId);
        canvas.classList.remove('dragging');
      };
      canvas.addEventListener('pointerup', release);
      canvas.addEventListener('pointercancel', release);
      let place = null, until = 0;
      canvas.addEventListener('wheel', event => {
        event.preventDefault();
        // One place for a whole turn of the wheel, as long as it does not rest.
        if (event.timeStamp > until) place = this.pick(event.clientX, event.clientY);
        until = event.timeStamp + 400;
        const lines = event.deltaMode === 1 ? 16 : 1;
        this.zoom(Math.exp(Math.max(-1, Math.min(1, event.deltaY * lines * 0.0015))), place);
      }, {passive: false});
      canvas.addEventListener('dblclick', event => {
        const at = this.pick(event.clientX, event.clientY);
        if (at && this.enabled) this.goTo(at, Math.min(this.distance, 60));
      });
      window.addEventListener('keydown', event => {
        if (event.target.tagName !== 'INPUT' && !event.ctrlKey && !event.metaKey) this.keys.add(event.code);
        this.changed();
      });
      window.addEventListener('keyup', event => this.keys.delete(event.code));
      window.addEventListener('blur', () => this.keys.clear());
    }

    /** The view as a part of the address, in the coordinates of the tiles. */
    toHash(origin) {
      const target = this.target.toArray().map((v, i) => (v + origin[i]).toFixed(2));
      const degrees = angle => (angle * 180 / Math.PI).toFixed(1);
      return `at=${target.join(',')}&d=${this.distance.toFixed(1)}&az=${degrees(this.azimuth)}&el=${degrees(this.elevation)}`
        + (this.flying ? '&fly=1' : '');
    }

    fromHash(values, origin) {
      const target = (values.get('at') || '').split(',').map(Number);
      if (target.length !== 3 || !target.every(Number.isFinite)) return false;
      const number = (name, fallback) => (Number.isFinite(parseFloat(values.get(name))) ? parseFloat(values.get(name)) : fallback);
      this.target.set(...target.map((v, i) => v - origin[i]));
      this.distance = Math.max(0.5, number('d', 100));
      this.azimuth = number('az', 0) * Math.PI / 180;
      this.elevation = Math.min(kHigh, Math.max(kLow, number('el', 35) * Math.PI / 180));
      this.flying = values.get('fly') === '1';
      return true;
    }
  }

  lm.Camera = Camera;
}(window.lidarMap = window.lidarMap || {}));
