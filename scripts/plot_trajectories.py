#!/usr/bin/python3
"""Plot two trajectories and the error along the way.

usage: plot_trajectories.py DATA.json PICTURE.png
DATA.json: a list of [way, true x y z, estimated x y z, error in m, error in degrees] per pose.
"""
import json
import sys

import matplotlib

matplotlib.use('Agg')
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

TRUTH, ESTIMATE, ERROR = '0.55', '#0b6fb8', '#c2410c'


def main(data_path, picture_path):
    with open(data_path) as file:
        poses = np.array(json.load(file))
    way, truth, estimate, metres, degrees = (
        poses[:, 0], poses[:, 1:4], poses[:, 4:7], poses[:, 7], poses[:, 8])
    figure = plt.figure(figsize=(12, 7), constrained_layout=True)
    grid = figure.add_gridspec(3, 2, width_ratios=[3, 2])
    view = figure.add_subplot(grid[:, 0])
    height, distance, angle = (figure.add_subplot(grid[row, 1]) for row in range(3))
    view.plot(truth[:, 0], truth[:, 1], color=TRUTH, linewidth=4, label='truth')
    view.plot(estimate[:, 0], estimate[:, 1], color=ESTIMATE, linewidth=1.4, label='estimate')
    view.plot(*truth[0, :2], 'o', color='black', markersize=6, label='start')
    view.set(aspect='equal', xlabel='x (m)', ylabel='y (m)', title='Seen from above')
    view.legend(frameon=False)
    height.plot(way, truth[:, 2], color=TRUTH, linewidth=4)
    height.plot(way, estimate[:, 2], color=ESTIMATE, linewidth=1.4)
    height.set(ylabel='height (m)', title='Along the way')
    distance.plot(way, metres, color=ERROR)
    distance.set(ylabel='position error (m)', ylim=(0, None))
    angle.plot(way, degrees, color=ERROR)
    angle.set(ylabel='angle error (deg)', xlabel='way (m)', ylim=(0, None))
    for axis in (view, height, distance, angle):
        axis.grid(color='0.9')
        axis.spines[['top', 'right']].set_visible(False)
    figure.savefig(picture_path, dpi=110)


if __name__ == '__main__':
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
