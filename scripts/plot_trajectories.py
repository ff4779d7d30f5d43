#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Plot two trajectories and the error along the path.

usage: plot_trajectories.py DATA.json PICTURE.png
DATA.json: a list of [distance travelled, true x y z, estimated x y z, error in m, error in degrees] per pose.
"""
import json
import sys

import matplotlib

matplotlib.use('Agg')
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

TRUTH, ESTIMATE, ERROR = '0.55', '#0b6fb8', '#c2410c'


def plan_height(points):
    """Height in inches of a plan that is 11 inches wide, within the limits of a page."""
    width, depth = np.ptp(points[:, :2], axis=0)
    return float(np.clip(11.0 * depth / max(width, 1.0), 2.5, 8.0))


def main(data_path, picture_path):
    with open(data_path) as file:
        poses = np.array(json.load(file))
    distance, truth, estimate, metres, degrees = (
        poses[:, 0], poses[:, 1:4], poses[:, 4:7], poses[:, 7], poses[:, 8])
    plan = plan_height(truth)
    figure = plt.figure(figsize=(12, plan + 3), constrained_layout=True)
    grid = figure.add_gridspec(2, 3, height_ratios=[plan, 3])
    view = figure.add_subplot(grid[0, :])
    height, error, angle = (figure.add_subplot(grid[1, column]) for column in range(3))
    view.plot(truth[:, 0], truth[:, 1], color=TRUTH, linewidth=4, label='truth')
    view.plot(estimate[:, 0], estimate[:, 1], color=ESTIMATE, linewidth=1.4, label='estimate')
    view.plot(*truth[0, :2], 'o', color='black', markersize=6, label='start')
    view.set(aspect='equal', xlabel='x (m)', ylabel='y (m)')
    view.legend(loc='lower left', bbox_to_anchor=(0.0, 1.0), ncol=3, frameon=False)
    height.plot(distance, truth[:, 2], color=TRUTH, linewidth=4)
    height.plot(distance, estimate[:, 2], color=ESTIMATE, linewidth=1.4)
    height.set(ylabel='height (m)')
    error.plot(distance, 1000.0 * metres, color=ERROR, linewidth=0.9)
    error.set(ylabel='position error (mm)', ylim=(0, None))
    angle.plot(distance, degrees, color=ERROR, linewidth=0.9)
    angle.set(ylabel='angle error (deg)', ylim=(0, None))
    for axis in (height, error, angle):
        axis.set(xlabel='distance travelled (m)')
    for axis in (view, height, error, angle):
        axis.grid(color='0.9')
        axis.spines[['top', 'right']].set_visible(False)
    figure.savefig(picture_path, dpi=110)


if __name__ == '__main__':
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
