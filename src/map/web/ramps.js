// SPDX-License-Identifier: BSD-3-Clause
// Colours: ramps of 256 steps from a few stops, and those of drives.
(function (lm) {
  'use strict';

  const stops = {
    height: ['#27405f', '#2f6f8f', '#3ba58c', '#8ccf6b', '#f0e26c', '#f2a149', '#d9533f'],
    intensity: ['#101418', '#4a5560', '#9aa7b2', '#f4f7fa'],
    time: ['#3b4cc0', '#4b9fe0', '#5fd3a6', '#d6d95a', '#ee8a3c', '#b40426'],
  };
  lm.driveColours = ['#59b8ff', '#ffb454', '#7fd962', '#f07178', '#c792ea', '#5ccfe6', '#ffe66d',
    '#ff8f40', '#95a7ff', '#bae67e'];
  stops.drive = lm.driveColours;

  function bytesOf(colour) {
    return [1, 3, 5].map(i => parseInt(colour.slice(i, i + 2), 16));
  }

  function mixed(colours, at) {
    const place = at * (colours.length - 1);
    const i = Math.min(Math.floor(place), colours.length - 2);
    const low = bytesOf(colours[i]), high = bytesOf(colours[i + 1]);
    return low.map((v, k) => v + (high[k] - v) * (place - i));
  }

  /** 256 colours of three bytes; for drives the colours one after the other. */
  lm.ramp = function (name) {
    const colours = stops[name];
    const bytes = new Uint8Array(256 * 3);
    for (let i = 0; i < 256; ++i) {
      const colour = name === 'drive' ? bytesOf(colours[i % colours.length]) : mixed(colours, i / 255);
      bytes.set(colour, 3 * i);
    }
    return bytes;
  };
}(window.lidarMap = window.lidarMap || {}));
