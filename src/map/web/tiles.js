// SPDX-License-Identifier: BSD-3-Clause
// Entwine Point Tiles: where the files come from, and what is in them.
(function (lm) {
  'use strict';

  /** Files from the server of the page. */
  lm.serverFiles = function () {
    const get = path => fetch(path).then(answer => {
      if (!answer.ok) throw new Error(`${path}: ${answer.status} ${answer.statusText}`);
      return answer;
    });
    return {json: path => get(path).then(a => a.json()), bytes: path => get(path).then(a => a.arrayBuffer())};
  };

  /** Files of a folder that the user chose: the browser gives them to a page that is a file, too. */
  lm.chosenFiles = function (list) {
    const files = new Map();
    for (const file of list) files.set(file.webkitRelativePath.split('/').slice(1).join('/'), file);
    const bytes = path => {
      if (!files.has(path)) return Promise.reject(new Error(`the folder has no ${path}; choose the one of this page`));
      return new Response(files.get(path)).arrayBuffer();
    };
    return {bytes, json: path => bytes(path).then(b => JSON.parse(new TextDecoder().decode(b)))};
  };

  /** The coarsest levels, which a script holds. */
  lm.overviewFiles = function (overview) {
    const bytes = name => Uint8Array.from(atob(overview.nodes[name]), c => c.charCodeAt(0)).buffer;
    const size = overview.ept.schema.reduce((sum, d) => sum + d.size, 0);
    const counts = {};
    for (const name of Object.keys(overview.nodes)) {
      const text = overview.nodes[name];
      const padding = text.endsWith('==') ? 2 : text.endsWith('=') ? 1 : 0;
      counts[name] = (text.length / 4 * 3 - padding) / size;
    }
    return {
      json: path => Promise.resolve(path === 'ept.json' ? overview.ept : counts),
      bytes: path => Promise.resolve(bytes(path.split('/')[1].split('.')[0])),
    };
  };

  const kRoot = '0-0-0-0';
  const getters = {
    signed: {1: 'getInt8', 2: 'getInt16', 4: 'getInt32'},
    unsigned: {1: 'getUint8', 2: 'getUint16', 4: 'getUint32'},
    float: {4: 'getFloat32', 8: 'getFloat64'},
  };

  class Tiles {
    constructor(files, ept) {
      if (ept.dataType !== 'binary') throw new Error(`tiles of type ${ept.dataType} are not read; write them as binary`);
      this.files = files;
      this.ept = ept;
      this.bounds = ept.bounds;
      this.edge = ept.bounds[3] - ept.bounds[0];
      this.counts = {};
      this.dimensions = {};
      this.pointSize = 0;
      for (const d of ept.schema) {
        this.dimensions[d.name] = Object.assign({at: this.pointSize}, d);
        this.pointSize += d.size;
      }
      // Floats of the graphics card count from here.
      this.origin = [0, 1, 2].map(i => Math.floor((ept.boundsConforming[i] + ept.boundsConforming[i + 3]) / 2));
    }

    loadHierarchy(name) {
      return this.files.json(`ept-hierarchy/${name}.json`).then(counts => Object.assign(this.counts, counts));
    }

    /** A function that reads a dimension of the point that begins at a byte. */
    reader(view, name) {
      const d = this.dimensions[name];
      const get = getters[d.type][d.size];
      const scale = d.scale === undefined ? 1 : d.scale, offset = d.offset || 0;
      return byte => view[get](byte + d.at, true) * scale + offset;
    }

    /** Positions from the origin, and intensity, time (0 to 1 of their ranges) and drive. */
    parse(buffer) {
      const view = new DataView(buffer);
      const count = buffer.byteLength / this.pointSize;
      const x = this.reader(view, 'X'), y = this.reader(view, 'Y'), z = this.reader(view, 'Z');
      const intensity = this.reader(view, 'Intensity'), time = this.reader(view, 'GpsTime');
      const drive = this.reader(view, 'PointSourceId');
      const first = this.dimensions.GpsTime.minimum;
      const span = Math.max(1e-9, this.dimensions.GpsTime.maximum - first);
      const positions = new Float32Array(3 * count), values = new Float32Array(3 * count);
      for (let i = 0, byte = 0; i < count; ++i, byte += this.pointSize) {
        positions[3 * i] = x(byte) - this.origin[0];
        positions[3 * i + 1] = y(byte) - this.origin[1];
        positions[3 * i + 2] = z(byte) - this.origin[2];
        values[3 * i] = intensity(byte) / 65535;
        values[3 * i + 1] = (time(byte) - first) / span;
        values[3 * i + 2] = drive(byte);
      }
      return {count, positions, values};
    }

    load(name) {
      const bytes = name === kRoot && this.root || this.files.bytes(`ept-data/${name}.bin`);
      this.root = null;  // its bytes are needed once
      return bytes.then(buffer => this.parse(buffer));
    }
  }

  lm.openTiles = function (files) {
    // What the first picture needs is asked for at once.
    const wanted = [files.json('ept.json'), files.json(`ept-hierarchy/${kRoot}.json`)];
    const root = files.bytes(`ept-data/${kRoot}.bin`);
    root.catch(() => {});  // reported when it is used
    return Promise.all(wanted).then(([ept, counts]) => {
      const tiles = new Tiles(files, ept);
      Object.assign(tiles.counts, counts);
      tiles.root = root;
      return tiles;
    });
  };
}(window.lidarMap = window.lidarMap || {}));
