#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Plot a session's trajectory with its loops, before and after optimisation.

usage: plot_loops.py REPORT.json PICTURE.png
REPORT.json: what map_quality --report wrote, with --truth for the errors.
"""
import json
import sys

import matplotlib

matplotlib.use('Agg')
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from plot_trajectories import plan_height  # noqa: E402

BEFORE, AFTER, TAKEN, REFUSED = '#d97706', '#1463a5', '#2f855a', '#9aa5b1'


def table(part):
    rows = np.array(part['rows'], dtype=float).reshape(-1, len(part['columns']))
    return {name: rows[:, i] for i, name in enumerate(part['columns'])}


def draw_plan(axis, report):
    path = table(report['trajectory'])
    axis.plot(path['odometry_x'], path['odometry_y'], '--', color=BEFORE, linewidth=1.2,
              label='before: odometry')
    axis.plot(path['x'], path['y'], color=AFTER, linewidth=1.6, label='after optimisation')
    at = {int(k): (x, y) for k, x, y in zip(path['key_frame'], path['x'], path['y'])}
    for verdict, colour in (('refused', REFUSED), ('accepted', TAKEN)):
        label = 'loop' if verdict == 'accepted' else f'candidate {verdict}'
        for loop in report['loops']['candidates']:
            if loop['verdict'] == verdict and loop['from'] in at and loop['to'] in at:
                a, b = at[loop['from']], at[loop['to']]
                axis.plot([a[0], b[0]], [a[1], b[1]], '-o', color=colour, markersize=2.5,
                          linewidth=1.4 if verdict == 'accepted' else 0.8, label=label)
                label = None
    axis.set(aspect='equal', xlabel='x (m)', ylabel='y (m)')
    axis.legend(loc='lower left', bbox_to_anchor=(0.0, 1.0), ncol=4, frameon=False)


def draw_residuals(axis, report):
    used = [loop for loop in report['loops']['candidates']
            if loop['verdict'] == 'accepted' and 'residual_m' in loop]
    for name, colour, label in (('odometry_residual_m', BEFORE, 'before'),
                                ('residual_m', AFTER, 'after')):
        values = np.sort([1000.0 * loop[name] for loop in used])
        axis.step(values, np.arange(1, len(values) + 1), color=colour, label=label)
    axis.set(xlabel='residual of a loop (mm)', ylabel='loops below', xlim=(0, None),
             ylim=(0, None))
    axis.legend(loc='lower right', frameon=False)


def draw_errors(axis, report):
    if not report['truth']:
        axis.set_visible(False)
        return
    errors = table(report['truth'])
    axis.plot(errors['distance'], 1000.0 * errors['odometry_error_m'], color=BEFORE, label='before')
    axis.plot(errors['distance'], 1000.0 * errors['error_m'], color=AFTER, label='after')
    axis.set(xlabel='distance travelled (m)', ylabel='position error (mm)', ylim=(0, None))
    axis.legend(loc='upper left', ncol=2, frameon=False)


def main(report_path, picture_path):
    with open(report_path) as file:
        report = json.load(file)
    path = table(report['trajectory'])
    plan = plan_height(np.column_stack([path['x'], path['y']]))
    figure = plt.figure(figsize=(12, plan + 3), constrained_layout=True)
    grid = figure.add_gridspec(2, 2, height_ratios=[plan, 3])
    axes = [figure.add_subplot(cell) for cell in (grid[0, :], grid[1, 0], grid[1, 1])]
    for axis, draw in zip(axes, (draw_plan, draw_errors, draw_residuals)):
        draw(axis, report)
        axis.grid(color='0.9')
        for side in ('top', 'right'):
            axis.spines[side].set_visible(False)
    figure.savefig(picture_path, dpi=110)


if __name__ == '__main__':
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
