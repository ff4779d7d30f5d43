#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Make the page that shows a session's report.

usage: make_report.py REPORT.json PICTURE_DATA_DIR PAGE.html
Called by map_quality --report; the page holds all of its pictures.
"""
import base64
import io
import json
import math
import os
import pathlib
import sys

import jinja2
import matplotlib

matplotlib.use('Agg')
import matplotlib.pyplot as plt  # noqa: E402
import matplotlib.collections  # noqa: E402
import matplotlib.ticker  # noqa: E402
import numpy as np  # noqa: E402

INK, GREY, FAINT = '#1f2933', '#7b8794', '#e4e7eb'
BLUE, ORANGE, RED, GREEN = '#1463a5', '#d97706', '#b91c1c', '#2f855a'
YELLOW = '#f2c94c'
WIDTH = 5.8  # inches of a picture in one of the two columns
GAP = 40.0  # m between key frames that are not joined by a line: parts of the map
LOOP_COLOURS = {'accepted': GREEN, 'refused': GREY, 'undecided': ORANGE}

plt.rcParams.update({
    'font.size': 9, 'font.family': 'sans-serif', 'text.color': INK, 'axes.edgecolor': '#cbd2d9',
    'axes.labelcolor': INK, 'axes.grid': True, 'grid.color': FAINT, 'grid.linewidth': 0.8,
    'xtick.color': GREY, 'ytick.color': GREY, 'axes.spines.top': False,
    'axes.spines.right': False, 'axes.axisbelow': True, 'legend.frameon': False,
    'axes.titlesize': 9, 'axes.titleweight': 'bold',
    'svg.hashsalt': 'report', 'figure.constrained_layout.use': True})


def table(part):
    """The rows of a part of the report as columns by name."""
    rows = np.array(part['rows'], dtype=float).reshape(-1, len(part['columns']))
    return {name: rows[:, i] for i, name in enumerate(part['columns'])}


def embedded(figure, kind='svg'):
    """The figure as an image source."""
    buffer = io.BytesIO()
    metadata = {'Date': None} if kind == 'svg' else None
    # Tight: a title longer than its axis is not cut.
    figure.savefig(buffer, format=kind, dpi=130, metadata=metadata, bbox_inches='tight',
                   pad_inches=0.04)
    plt.close(figure)
    mime = {'svg': 'image/svg+xml', 'png': 'image/png'}[kind]
    return f'data:{mime};base64,' + base64.b64encode(buffer.getvalue()).decode()


def embedded_file(path):
    return 'data:image/png;base64,' + base64.b64encode(path.read_bytes()).decode()


def positions(trajectory):
    """Position of each key frame by its number."""
    return {int(k): (x, y) for k, x, y in
            zip(trajectory['key_frame'], trajectory['x'], trajectory['y'])}


def draw_loops(axis, report, at, verdict, label, **style):
    drawn = False
    for loop in report['loops']['candidates']:
        if loop['verdict'] != verdict or loop['from'] not in at or loop['to'] not in at:
            continue
        a, b = at[loop['from']], at[loop['to']]
        axis.plot([a[0], b[0]], [a[1], b[1]], '-o', color=LOOP_COLOURS[verdict], markersize=2.5,
                  label=None if drawn else label, **style)
        drawn = True


def draw_doubt(axis, report, trajectory):
    """Sections of the path that are doubtful, under the trajectory."""
    labels = {True: 'doubtful', False: 'not to be trusted'}
    placed = [section for section in report['doubt']['sections'] if section['rows']]
    for section in sorted(placed, key=lambda s: not s['trusted']):
        rows = slice(section['rows'][0], section['rows'][1] + 1)
        trusted = section['trusted']
        axis.plot(trajectory['x'][rows], trajectory['y'][rows], '-',
                  color=YELLOW if trusted else RED, linewidth=6, alpha=0.55, solid_capstyle='round',
                  label=labels.pop(trusted, None), zorder=1.5)


def plan_size(trajectory):
    """Size of a picture in which the drive fills the width, or the height if it is a tall one."""
    wide = np.ptp(trajectory['x']) + 20.0
    tall = np.ptp(trajectory['y']) + 20.0
    return WIDTH, min(max(WIDTH * tall / wide, 2.4), 5.4) + 0.7


def plan(report, trajectory):
    """Trajectory from above, with loops, GNSS, and odometry alone."""
    figure, axis = plt.subplots(figsize=plan_size(trajectory))
    gnss = table(report['gnss'])
    if len(gnss['x']) and report['gnss']['used_by_graph']:
        axis.plot(gnss['x'], gnss['y'], '.', color='#9fb3c8', markersize=5, label='GNSS')
    axis.plot(trajectory['odometry_x'], trajectory['odometry_y'], '--', color=GREY, linewidth=1,
              label='odometry alone')
    draw_doubt(axis, report, trajectory)
    axis.plot(trajectory['x'], trajectory['y'], color=BLUE, linewidth=1.6, label='map')
    at = positions(trajectory)
    draw_loops(axis, report, at, 'refused', 'candidate refused', linewidth=0.8, zorder=3)
    draw_loops(axis, report, at, 'undecided', 'candidate undecided', linewidth=0.8, zorder=3)
    draw_loops(axis, report, at, 'accepted', 'loop accepted', linewidth=1.6, zorder=4)
    axis.plot(trajectory['x'][:1], trajectory['y'][:1], 's', color=INK, markersize=5, zorder=5,
              label='start')
    axis.set(aspect='equal', xlabel='x (m)', ylabel='y (m)')
    axis.legend(loc='lower left', bbox_to_anchor=(0.0, 1.0), ncol=4, fontsize=8)
    return embedded(figure)


def widen(axis, least):
    """Let the axis show at least this range, because smaller values are rounding errors."""
    low, high = axis.get_ylim()
    if high - low < least:
        middle = 0.5 * (low + high)
        axis.set_ylim(middle - 0.5 * least, middle + 0.5 * least)


def along(series, ylabel, least, height=2.2, from_zero=False, legend=False):
    """Lines along the path: a list of (distance, value, colour, label, style)."""
    figure, axis = plt.subplots(figsize=(WIDTH, height))
    for distance, value, colour, label, style in series:
        axis.plot(distance, value, style, color=colour, linewidth=1.4, markersize=3, label=label)
    axis.set(xlabel='distance travelled (m)', ylabel=ylabel)
    axis.margins(x=0.01, y=0.12)
    axis.ticklabel_format(useOffset=False)
    if from_zero:
        axis.set_ylim(0, max(least, axis.get_ylim()[1]))
    else:
        widen(axis, least)
    if legend:
        axis.legend(loc='lower left', bbox_to_anchor=(0.0, 1.0), ncol=4, fontsize=8)
    return embedded(figure)


def histogram(values, xlabel, least, colour=BLUE):
    figure, axis = plt.subplots(figsize=(0.5 * WIDTH, 1.9))
    axis.hist(values, bins=24, range=(0, max(least, max(values))), color=colour, rwidth=0.9)
    axis.set(xlabel=xlabel, ylabel='loops')
    axis.yaxis.set_major_locator(matplotlib.ticker.MaxNLocator(4, integer=True))
    axis.grid(axis='x', visible=False)
    axis.xaxis.set_major_locator(matplotlib.ticker.MaxNLocator(4))
    return embedded(figure)


def misalignment_plan(report, trajectory):
    """Where the map was driven twice, and how far the passes lie apart."""
    figure, axis = plt.subplots(figsize=plan_size(trajectory))
    axis.plot(trajectory['x'], trajectory['y'], color='#cbd2d9', linewidth=1.2)
    places = np.array([one['position'][:2] for one in report['misalignments']])
    sizes = 1000.0 * np.array([one['size_m'] for one in report['misalignments']])
    dots = axis.scatter(places[:, 0], places[:, 1], c=sizes, s=42, cmap='viridis_r', vmin=0,
                        vmax=max(20.0, sizes.max()), edgecolors='white', linewidths=0.6, zorder=3)
    for number, place in enumerate(places[:6]):
        axis.annotate(str(number + 1), place, textcoords='offset points', xytext=(6, 5),
                      fontsize=9, fontweight='bold', color=INK)
    figure.colorbar(dots, ax=axis, label='distance of the passes (mm)', location='bottom',
                    aspect=40, pad=0.02)
    axis.set(aspect='equal', xlabel='x (m)', ylabel='y (m)')
    return embedded(figure)


def section_line(section, trajectory):
    """Positions of the key frames of a section of the map, and of the next one if it is near."""
    first, last = section['rows']
    x, y = trajectory['x'], trajectory['y']
    # Between two drives no way is counted, so the positions tell how near it is.
    if last + 1 < len(x) and np.hypot(x[last + 1] - x[last], y[last + 1] - y[last]) < GAP:
        last += 1
    return np.column_stack([trajectory[name][first:last + 1] for name in 'xy'])


def draw_where(axis, parts, marker, colour, label):
    known = [part for part in parts if part['x'] is not None]
    if known:
        axis.plot([part['x'] for part in known], [part['y'] for part in known], marker, color=colour,
                  markersize=8, markeredgewidth=1.8, label=label, zorder=4)


def examination_plan(drive, trajectory):
    """The map's trajectory, coloured by how well the scans of another drive agreed with the map."""
    figure, axis = plt.subplots(figsize=plan_size(trajectory))
    axis.plot(trajectory['x'], trajectory['y'], color='#cbd2d9', linewidth=1.2)
    passed = [section for section in drive['sections'] if section['scans']]
    lines = matplotlib.collections.LineCollection(
        [section_line(section, trajectory) for section in passed], cmap='viridis', linewidths=4,
        capstyle='round', zorder=3)
    lines.set_array(np.array([section['agreement'] for section in passed], dtype=float))
    lines.set_clim(0.0, 1.0)
    axis.add_collection(lines)
    draw_where(axis, drive['losses'], 'x', RED, 'lost')
    draw_where(axis, drive['odometry']['jumps'], '^', ORANGE, 'jump')
    if axis.get_legend_handles_labels()[1]:
        axis.legend(loc='lower left', bbox_to_anchor=(0.0, 1.0), ncol=4, fontsize=8)
    figure.colorbar(lines, ax=axis, label='agreement of the scans with the map', location='bottom',
                    aspect=40, pad=0.02)
    axis.set(aspect='equal', xlabel='x (m)', ylabel='y (m)')
    return embedded(figure)


def examination_pictures(drive, trajectory):
    images = {'plan': examination_plan(drive, trajectory)}
    odometry = table(drive['odometry'])
    if len(odometry['distance']):
        images['odometry'] = along([(odometry['distance'], 1000.0 * odometry['error_m'], BLUE, None, '-')],
                                   f'over {drive["odometry"]["delta_m"]:g} m (mm)', 1.0, from_zero=True)
    return images


def draw_passes(axis, points, size):
    for xy, colour, name in zip(points, (BLUE, ORANGE), ('earlier passes', 'later pass')):
        axis.plot(xy[:, 0], xy[:, 1], '.', color=colour, markersize=size, alpha=0.6,
                  markeredgewidth=0, label=name)
    axis.set_aspect('equal')


def telling_corner(points):
    """Lower corner of the square of 2 m, seen from above, where both passes have most points."""
    edges = np.arange(-12.0, 12.1, 2.0)
    counts = [np.histogram2d(xy[:, 0], xy[:, 1], bins=(edges, edges))[0] for xy in points]
    column, row = np.unravel_index(np.argmax(np.minimum(*counts)), counts[0].shape)
    return edges[column], edges[row]


def place_picture(data):
    """A place from above, a corner of it enlarged, and across: the passes on top of each other."""
    above, across = ([np.array(part, dtype=float).reshape(-1, 2) / 1000.0
                      for part in data[view]['passes']] for view in ('above', 'across'))
    figure = plt.figure(figsize=(WIDTH, 4.3))
    grid = figure.add_gridspec(2, 2, height_ratios=[2.2, 1])
    view, zoom = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1])
    cut = figure.add_subplot(grid[1, :])
    draw_passes(view, above, 1.2)
    draw_passes(zoom, above, 5.0)
    draw_passes(cut, across, 1.6)
    x, y = telling_corner(above)
    view.add_patch(plt.Rectangle((x, y), 2, 2, fill=False, edgecolor=INK, linewidth=1))
    view.set(xlabel='along (m)', ylabel='left (m)')
    view.set_title(data['above']['title'], loc='left')
    zoom.set(xlim=(x, x + 2), ylim=(y, y + 2), xlabel='along (m)')
    zoom.set_title('The square, enlarged', loc='left')
    cut.set(xlabel='left (m)', ylabel='up (m)')
    cut.set_title(data['across']['title'], loc='left')
    cut.legend(loc='lower right', bbox_to_anchor=(1.0, 1.0), ncol=2, fontsize=8, markerscale=6)
    return embedded(figure, 'png')


def pictures(report, data_directory):
    trajectory = table(report['trajectory'])
    distance = trajectory['distance']
    images = {
        'map': embedded_file(data_directory / 'top_view.png'),
        'plan': plan(report, trajectory),
        'height': along([(distance, trajectory['odometry_z'], GREY, 'odometry alone', '--'),
                         (distance, trajectory['z'], BLUE, 'map', '-')], 'height (m)', 0.2,
                        legend=True)}
    if max(report['trajectory']['odometry_max_m'], 0.0) > 1e-6:  # else the map is the odometry
        images['odometry'] = along(
            [(distance, np.hypot(trajectory['odometry_x'] - trajectory['x'],
                            trajectory['odometry_y'] - trajectory['y']), BLUE, 'horizontal', '-'),
             (distance, trajectory['odometry_z'] - trajectory['z'], ORANGE, 'vertical', '-')],
            'odometry − map (m)', 0.02, legend=True)
    residuals = [1000.0 * loop['residual_m'] for loop in report['loops']['candidates']
                 if loop['verdict'] == 'accepted' and 'residual_m' in loop]
    if residuals:
        angles = [loop['residual_deg'] for loop in report['loops']['candidates']
                  if loop['verdict'] == 'accepted' and 'residual_deg' in loop]
        images['loop_metres'] = histogram(residuals, 'loop residual (mm)', 1.0, GREEN)
        images['loop_degrees'] = histogram(angles, 'loop residual (deg)', 0.01, GREEN)
    gnss = table(report['gnss'])
    if len(gnss['distance']):
        images['gnss'] = along(
            [(gnss['distance'], 1000.0 * gnss['east'], BLUE, 'east', '-'),
             (gnss['distance'], 1000.0 * gnss['north'], ORANGE, 'north', '-'),
             (gnss['distance'], 1000.0 * gnss['up'], GREY, 'up', '-')],
            'GNSS − map (mm)', 1.0, legend=True)
    uncertainty = table(report['uncertainty'])
    if len(uncertainty['distance']):
        images['uncertainty'] = along(
            [(uncertainty['distance'], uncertainty['sigma_m'], BLUE, None, '-')],
            'standard deviation (m)', 0.01, from_zero=True)
    if report['misalignments']:
        images['misalignments'] = misalignment_plan(report, trajectory)
    if report['truth']:
        truth = table(report['truth'])
        images['truth'] = along([(truth['distance'], 1000.0 * truth['error_m'], RED, None, '-')],
                                'position error (mm)', 1.0, from_zero=True)
    images['examinations'] = [examination_pictures(drive, trajectory) for drive in report['examinations']]
    places = json.loads((data_directory / 'places.json').read_text())
    images['places'] = [place_picture(place) for place in places]
    return images


def scale_bar(data_directory, share=0.2):
    """A round length and its share of the map picture's width."""
    left, right, _, _ = json.loads((data_directory / 'top_view.json').read_text())
    wanted = share * (right - left)
    power = 10.0 ** math.floor(math.log10(wanted))
    length = max(step * power for step in (1, 2, 5) if step * power <= wanted)
    return {'length': f'{length:g}', 'percent': 100.0 * length / (right - left)}


def size_of(number):
    """A number of bytes as people say it."""
    for unit in ('B', 'kB', 'MB'):
        if number < 1000:
            return f'{number:.3g} {unit}'
        number /= 1000.0
    return f'{number:.3g} GB'


def main(json_path, data_path, page_path):
    report = json.loads(pathlib.Path(json_path).read_text())
    data_directory = pathlib.Path(data_path)
    templates = jinja2.Environment(
        loader=jinja2.FileSystemLoader(os.path.dirname(os.path.realpath(__file__))),
        autoescape=True, trim_blocks=True, lstrip_blocks=True)
    templates.filters['mm'] = lambda metres: str(round(1000.0 * metres))
    templates.filters['size'] = size_of
    templates.filters['degrees'] = lambda angle: f'{round(angle, 2) + 0.0:.2f}'  # no -0.00
    page = templates.get_template('report.html.j2').render(
        report=report, images=pictures(report, data_directory), scale=scale_bar(data_directory))
    temporary = pathlib.Path(page_path + '.part')
    temporary.write_text(page)
    temporary.rename(page_path)


if __name__ == '__main__':
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
