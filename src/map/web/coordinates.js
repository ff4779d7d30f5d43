// SPDX-License-Identifier: BSD-3-Clause
// Metres of a UTM zone to degrees of WGS 84.
(function (lm) {
  'use strict';

  // The transverse Mercator projection by Krueger's series in the third flattening n (Karney 2011,
  // equations 12, 14 and 36, cut after n^4): the rest is some micrometres within a zone.
  const a = 6378137;  // m, semi-major axis of WGS 84
  const f = 1 / 298.257223563;  // flattening of WGS 84
  const n = f / (2 - f);
  const n2 = n * n, n3 = n2 * n, n4 = n3 * n;
  const radius = a / (1 + n) * (1 + n2 / 4 + n4 / 64);
  const beta = [n / 2 - 2 / 3 * n2 + 37 / 96 * n3 - n4 / 360, n2 / 48 + n3 / 15 - 437 / 1440 * n4,
    17 / 480 * n3 - 37 / 840 * n4, 4397 / 161280 * n4];
  const delta = [2 * n - 2 / 3 * n2 - 2 * n3 + 116 / 45 * n4, 7 / 3 * n2 - 8 / 5 * n3 - 227 / 45 * n4,
    56 / 15 * n3 - 136 / 35 * n4, 4279 / 630 * n4];
  const scale = 0.9996;  // on the central meridian, by the definition of UTM

  function zoneOf(epsg) {
    const south = epsg > 32700;
    const zone = epsg - (south ? 32700 : 32600);
    return zone >= 1 && zone <= 60 ? {zone, south} : null;  // none for the polar systems
  }

  /** Latitude and longitude in degrees; null where the system is no UTM zone. */
  lm.degrees = function (epsg, easting, northing) {
    const system = zoneOf(epsg);
    if (!system) return null;
    const xi = (northing - (system.south ? 1e7 : 0)) / (scale * radius);
    const eta = (easting - 5e5) / (scale * radius);
    let xi1 = xi, eta1 = eta;
    beta.forEach((b, i) => {
      const k = 2 * (i + 1);
      xi1 -= b * Math.sin(k * xi) * Math.cosh(k * eta);
      eta1 -= b * Math.cos(k * xi) * Math.sinh(k * eta);
    });
    const chi = Math.asin(Math.sin(xi1) / Math.cosh(eta1));
    let latitude = chi;
    delta.forEach((d, i) => { latitude += d * Math.sin(2 * (i + 1) * chi); });
    const longitude = Math.atan2(Math.sinh(eta1), Math.cos(xi1));
    return [latitude * 180 / Math.PI, longitude * 180 / Math.PI + 6 * system.zone - 183];
  };

  /** A line of text for a place in the coordinates of the tiles. */
  lm.placeText = function (epsg, p) {
    const metres = v => v.toFixed(2);
    if (!epsg) return `x ${metres(p[0])}  y ${metres(p[1])}  z ${metres(p[2])} m`;
    const text = `E ${metres(p[0])}  N ${metres(p[1])}  h ${metres(p[2])} m  (EPSG:${epsg})`;
    const at = lm.degrees(epsg, p[0], p[1]);
    return at ? `${text}   ${at[0].toFixed(7)}°, ${at[1].toFixed(7)}°` : text;
  };
}(window.lidarMap = window.lidarMap || {}));
