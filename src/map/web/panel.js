// SPDX-License-Identifier: BSD-3-Clause
// The panel at the left: what it shows of the map, and what its controls do.
(function (lm) {
  'use strict';

  const kDoubts = 100;  // in the list; the worst come first
  const kChanges = 200;  // in the list; the newest come first
  const $ = id => document.getElementById(id);

  lm.problem = function (error) {
    $('problem').textContent = error.message || String(error);
    $('problem').hidden = false;
    document.documentElement.dataset.state = 'failed';
  };

  function big(count) {
    return count >= 1e6 ? `${(count / 1e6).toFixed(1)} million` : String(Math.round(count));
  }

  lm.showTitle = function (marks, tiles) {
    const b = tiles.ept.boundsConforming;
    $('title').textContent = marks.title;
    document.title = marks.title;
    $('extent').textContent = `${big(tiles.ept.points)} points, ${(b[3] - b[0]).toFixed(0)} × ${(b[4] - b[1]).toFixed(0)} m`;
    $('loop-count').textContent = marks.loops.length;
    $('doubt-count').textContent = marks.doubts.length;
    $('change-count').textContent = marks.changes.length;
    for (const name of ['loops', 'doubts', 'changes']) {
      const count = marks[name].length;
      document.querySelector(`[data-mark=${name}]`).disabled = count === 0;
    }
  };

  function dateText(seconds) {
    return new Date(seconds * 1000).toISOString().replace('T', ' ').slice(0, 19);
  }

  /** The ramp with the values at its ends. */
  lm.showLegend = function (points, marks) {
    const ramp = lm.ramp(points.colour), context = $('ramp').getContext('2d');
    const image = context.createImageData(256, 1);
    for (let i = 0; i < 256; ++i) image.data.set([ramp[3 * i], ramp[3 * i + 1], ramp[3 * i + 2], 255], 4 * i);
    context.putImageData(image, 0, 0);
    const [low, high] = points.ranges[points.colour];
    const time = points.tiles.dimensions.GpsTime, z = points.tiles.origin[2];
    const ends = {
      height: [`${(low + z).toFixed(1)} m`, `${(high + z).toFixed(1)} m`],
      intensity: ['weak', 'strong'],
      time: [dateText(time.minimum), dateText(time.maximum).slice(11)],
      drive: ['', ''],
    }[points.colour];
    [$('low').textContent, $('high').textContent] = ends;
    $('legend').hidden = points.colour === 'drive';
    $('drives').textContent = '';
    if (points.colour !== 'drive') return;
    for (const drive of marks.drives) {
      const name = document.createElement('span'), key = document.createElement('i');
      key.className = 'key';
      key.style.background = lm.driveColours[drive.number % lm.driveColours.length];
      name.append(key, ` ${drive.number}`);
      $('drives').append(name);
    }
  };

  function doubtText(doubt) {
    const error = doubt.error === null ? 'error unknown' : `error ${doubt.error.toFixed(2)} m`;
    return `${doubt.kind}, ${doubt.length.toFixed(0)} m: ${error}${doubt.trusted ? '' : ', do not rely on it'}`;
  }

  /** A button for each doubtful section; `go` gets its middle and its length. */
  lm.listDoubts = function (marks, origin, go) {
    const severity = d => (d.trusted ? 0 : 1e9) + (d.error === null ? 1e6 : d.error);
    const sorted = [...marks.doubts].sort((a, b) => severity(b) - severity(a)).slice(0, kDoubts);
    for (const doubt of sorted) {
      const button = document.createElement('button');
      button.textContent = doubtText(doubt);
      button.addEventListener('click', () => {
        const middle = doubt.path[Math.floor(doubt.path.length / 2)].map((v, i) => v - origin[i]);
        go(new THREE.Vector3(...middle), Math.max(40, 1.5 * doubt.length));
      });
      $('doubts').append(button);
    }
  };

  /** A button for each change; `go` gets its middle and how far from it the view should be. */
  lm.listChanges = function (marks, origin, go) {
    const sorted = [...marks.changes].sort((a, b) => (a.before < b.before ? 1 : -1)).slice(0, kChanges);
    for (const change of sorted) {
      const button = document.createElement('button');
      button.textContent = lm.changeText(change);
      button.className = change.kind;
      button.addEventListener('click', () => {
        const middle = change.corners[0].map((v, i) => (v + change.corners[7][i]) / 2 - origin[i]);
        go(new THREE.Vector3(...middle), Math.max(25, 3 * Math.hypot(...change.size)));
      });
      $('changes').append(button);
    }
  };

  /** Connects the controls with the functions of `actions`. */
  lm.connectPanel = function (actions) {
    for (const button of document.querySelectorAll('[data-colour]')) {
      button.addEventListener('click', () => actions.colour(button.dataset.colour));
    }
    for (const box of document.querySelectorAll('[data-mark]')) {
      box.addEventListener('change', () => actions.mark(box.dataset.mark, box.checked));
    }
    for (const name of ['size', 'budget', 'depth']) {
      $(name).addEventListener('input', () => actions[name](Number($(name).value)));
    }
    for (const name of ['home', 'top', 'fly', 'measure']) $(name).addEventListener('click', () => actions[name]());
    $('fold').addEventListener('click', actions.fold);
    $('folder').addEventListener('change', () => actions.folder($('folder').files));
    $('link').addEventListener('click', () => actions.link().then(
      () => { $('link').textContent = 'Copied'; },
      () => { window.prompt('The address of this view:', location.href); }));
    const keys = {KeyH: 'home', KeyT: 'top', KeyF: 'fly', KeyM: 'measure', KeyP: 'fold', Escape: 'escape'};
    window.addEventListener('keydown', event => {
      if (event.target.tagName === 'INPUT' || event.ctrlKey || event.metaKey || event.altKey) return;
      if (keys[event.code]) actions[keys[event.code]]();
    });
  };

  /** Shows the state of the controls. */
  lm.showControls = function (state) {
    for (const button of document.querySelectorAll('[data-colour]')) {
      button.classList.toggle('on', button.dataset.colour === state.colour);
      button.setAttribute('aria-pressed', button.dataset.colour === state.colour);
    }
    for (const box of document.querySelectorAll('[data-mark]')) box.checked = state.marks[box.dataset.mark].visible;
    $('fly').classList.toggle('on', state.flying);
    $('measure').classList.toggle('on', state.measuring);
    $('budget-text').textContent = `${state.budget.toFixed(1)} M`;
  };

  lm.showFileNote = function (tiles) {
    const shown = Object.values(tiles.counts).reduce((sum, count) => sum + count, 0);
    $('file-note').hidden = shown >= tiles.ept.points;
    $('file-points').textContent = `${big(shown)} of ${big(tiles.ept.points)} points`;
  };

  lm.showPlace = function (text) { $('place').textContent = text; };
  lm.showLoad = function (points) {
    $('load').textContent = `${big(points.shown)} points${points.missing > 0 ? ', loading' : ''}`;
  };
}(window.lidarMap = window.lidarMap || {}));
