#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Plot how a drive was localised in a map: its path upon the map's points, and its error along the way.

usage: plot_localization.py MAP.ply LOCALIZATION.csv TRUTH.tum MAPPING_TRUTH.tum MAPPING.tum PICTURE.png
MAPPING.tum: poses of the drive that made the map, in the map; MAPPING_TRUTH.tum: its true ones. Both truths are in
the frame of the simulated world.
"""
import csv
import re
import sys

import matplotlib

matplotlib.use('Agg')
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from localization_truth import Trajectory, alignment, error_of  # noqa: E402

MAP, MAPPED, ERROR = '0.6', '0.35', '#c2410c'
COLOURS = {'following': '#0b6fb8', 'beside_map': '#d97706', 'lost': '#c2410c', 'searching': '#9aa5b1'}
HEIGHTS = (1.0, 8.0)  # m above the drive: walls, without the ground and without what hangs over it
POSES = 1000  # of the drive, for heights; and points that are compared with them at once
MARGIN = 30  # m around the drive of another day
DRAWN = 300_000  # points of the map; more do not change the picture


def read_points(path):
    """x, y, z of a binary PLY file of float properties, as build_map writes it."""
    with open(path, 'rb') as file:
        data = file.read()
    end = re.search(rb'^end_header\n', data, re.MULTILINE)
    header = data[:end.start()].decode('ascii', 'replace') if end else ''
    count = re.search(r'^element vertex (\d+)$', header, re.MULTILINE)
    if not count or 'format binary_little_endian' not in header:
        sys.exit(f'plot_localization: {path} is not a binary PLY file')
    fields = re.findall(r'^property float (\w+)$', header, re.MULTILINE)
    points = np.frombuffer(data, np.dtype([(name, '<f4') for name in fields]), int(count[1]), end.end())
    return np.stack([points[name] for name in 'xyz'], axis=1)


def read_scans(path):
    with open(path) as file:
        return list(csv.DictReader(file))


def heights_above(points, mapped):
    """m, over the nearest pose of the drive that made the map: streets climb."""
    poses = mapped.positions[::len(mapped.positions) // POSES + 1]
    heights = np.empty(len(points))
    for begin in range(0, len(points), POSES):
        part = points[begin:begin + POSES]
        distances = ((part[:, None, :2] - poses[None, :, :2]) ** 2).sum(axis=2)
        heights[begin:begin + POSES] = part[:, 2] - poses[distances.argmin(axis=1), 2]
    return heights


def draw_map(axis, points, mapped):
    points = points[::len(points) // DRAWN + 1]
    heights = heights_above(points, mapped)
    walls = points[(heights > HEIGHTS[0]) & (heights < HEIGHTS[1])]
    axis.plot(walls[:, 0], walls[:, 1], ',', color=MAP, rasterized=True)
    axis.plot(mapped.positions[:, 0], mapped.positions[:, 1], color=MAPPED, linewidth=0.8,
              label='the drive that made the map')


def draw_scans(axis, scans):
    found = [scan for scan in scans if scan['x']]
    places = np.array([[float(scan['x']), float(scan['y'])] for scan in found]).reshape(-1, 2)
    for state, colour in COLOURS.items():
        there = np.array([scan['state'] == state for scan in found], dtype=bool)
        if there.any():
            axis.plot(*places[there].T, '.', color=colour, markersize=4, label=f'another day: {state.replace("_", " ")}')
    if found:
        axis.plot(*places[0], 'o', color='black', markersize=7, label='found here')
        low, high = places.min(axis=0) - MARGIN, places.max(axis=0) + MARGIN
        axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))


def errors_along(scans, truth, align):
    """Metres driven since the first scan, and the error in m and degrees, of the scans with a pose."""
    ways = truth.ways()
    rows = []
    for scan in scans:
        error = error_of(scan, truth, *align)
        if error:
            rows.append((np.interp(float(scan['stamp']), truth.stamps, ways), error.metres, error.degrees))
    return np.array(rows).reshape(-1, 3)


def draw_errors(axes, errors):
    for axis, values, unit in zip(axes, (1000.0 * errors[:, 1], errors[:, 2]), ('position error (mm)', 'angle error (deg)')):
        axis.plot(errors[:, 0], values, '.', color=ERROR, markersize=3)
        axis.set(xlabel='distance travelled (m)', ylabel=unit, xlim=(0, None), ylim=(0, None))
        axis.grid(color='0.9')


def main(map_path, scans_path, truth_path, mapping_truth_path, mapping_path, picture_path):
    scans = read_scans(scans_path)
    mapped = Trajectory.read(mapping_path)
    align = alignment(Trajectory.read(mapping_truth_path), mapped)
    figure = plt.figure(figsize=(12, 9), constrained_layout=True)
    grid = figure.add_gridspec(2, 2, height_ratios=[6, 3])
    view = figure.add_subplot(grid[0, :])
    draw_map(view, read_points(map_path), mapped)
    draw_scans(view, scans)
    view.set(aspect='equal', xlabel='x (m)', ylabel='y (m)')
    view.legend(loc='lower left', bbox_to_anchor=(0.0, 1.0), ncol=4, frameon=False)
    axes = [figure.add_subplot(grid[1, column]) for column in range(2)]
    draw_errors(axes, errors_along(scans, Trajectory.read(truth_path), align))
    for axis in (view, *axes):
        axis.spines[['top', 'right']].set_visible(False)
    figure.savefig(picture_path, dpi=110)


if __name__ == '__main__':
    if len(sys.argv) != 7:
        sys.exit(__doc__)
    main(*sys.argv[1:])
