// SPDX-License-Identifier: BSD-3-Clause
// The ruler: a line through points of the map that the user clicks on.
(function (lm) {
  'use strict';

  const kStill = 5;  // pixels; a pointer that moves more between down and up drags

  class Ruler {
    constructor(canvas, labels, text, pick, changed) {
      Object.assign(this, {canvas, labels, text, pick, changed, places: [], active: false});
      this.scene = new THREE.Scene();
      let down = null;
      canvas.addEventListener('pointerdown', event => { down = [event.clientX, event.clientY]; });
      canvas.addEventListener('pointerup', event => {
        if (!this.active || !down || event.button !== 0) return;
        if (Math.hypot(event.clientX - down[0], event.clientY - down[1]) > kStill) return;
        const place = this.pick(event.clientX, event.clientY);
        if (place) this.add(place);
      });
    }

    setActive(active) {
      this.active = active;
      this.canvas.classList.toggle('measuring', active);
      this.places = [];
      this.show();
    }

    add(place) {
      this.places.push(place);
      this.show();
    }

    lengths() {
      return this.places.slice(1).map((p, i) => p.distanceTo(this.places[i]));
    }

    show() {
      for (const child of this.scene.children) {
        child.geometry.dispose();
        child.material.dispose();
      }
      const ends = this.places.map(p => p.toArray());
      const pairs = ends.length === 1 ? [[ends[0], ends[0]]] : ends.slice(1).map((p, i) => [ends[i], p]);
      this.scene.children = pairs.length > 0 ? [lm.wideLines(pairs, '#ffd866', ends.length === 1 ? 7 : 3, 1)] : [];
      this.labels.textContent = '';
      this.marks = this.lengths().map((length, i) => {
        const label = document.createElement('span');
        label.textContent = `${length.toFixed(2)} m`;
        this.labels.appendChild(label);
        return {label, at: this.places[i].clone().lerp(this.places[i + 1], 0.5)};
      });
      this.text.textContent = this.summary();
      this.changed();
    }

    summary() {
      if (!this.active) return '';
      if (this.places.length < 2) return 'Click on points of the map; Esc ends.';
      const first = this.places[0], last = this.places[this.places.length - 1];
      const total = this.lengths().reduce((sum, length) => sum + length, 0);
      const flat = Math.hypot(last.x - first.x, last.y - first.y);
      return `Length ${total.toFixed(2)} m\nFirst to last: level ${flat.toFixed(2)} m, height ${(last.z - first.z).toFixed(2)} m`;
    }

    /** Puts the labels where their lines are now. */
    place(camera, width, height) {
      for (const {label, at} of this.marks || []) {
        const p = at.clone().project(camera);
        label.hidden = p.z > 1;
        label.style.left = `${(p.x + 1) / 2 * width}px`;
        label.style.top = `${(1 - p.y) / 2 * height}px`;
      }
    }
  }

  lm.Ruler = Ruler;
}(window.lidarMap = window.lidarMap || {}));
