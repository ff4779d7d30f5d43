#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measure localisation on simulated drives of other days (doc/results/localization.md).

Makes a map of each world from one drive, then localises other drives through it, from many starts: other traffic and
parked cars, the opposite direction, another sensor. Errors are against the truth of the simulation, which no other
program reads. Maps, bags and results stay in the folder, and what is there is not made again. The package must be
built (LIDAR_MAPPING_BUILD: its build folder).

usage: measure_localization.py FOLDER [--worlds town twins] [--starts 6] [--seconds 15] [--table FILE]
"""
import argparse
import csv
import json
import math
import os
import pathlib
import subprocess
import sys
from typing import NamedTuple

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = pathlib.Path(os.environ.get('LIDAR_MAPPING_BUILD', ROOT / '.build'))
PROGRAMS = BUILD / 'devel/lib/lidar_mapping'
WRONG_M, WRONG_DEG = 0.5, 2.0  # a pose that is farther off is wrong
SOON = 3.0  # s, within which a place should be found
SHORTER = 6.0  # s, by which another day's drive may end earlier than the mapping one
GAP = 0.2  # s, between poses of the truth that are interpolated at most
# Drive of simulate_drive and its seconds that are mapped: all of it.
WORLDS = {'town': ('town', 160), 'twins': ('twins', 120), 'car_park': ('car_park', 175),
          'figure_eight': ('figure_eight', 130), 'field': ('open_road', 100), 'hill': ('open_road', 100)}
SEEDS = {'hill': 3}  # another round of the hilly road than `field`
MAPPING_LIDAR = 'os1_64'


class Drive(NamedTuple):
    name: str
    words: tuple  # for simulate_drive


DRIVES = (Drive('other day', ('--lidar', 'os1_64', '--pass', '1', '--parked', '1')),
          Drive('16 beams', ('--lidar', 'vlp16', '--pass', '2', '--parked', '2')),
          Drive('way back', ('--lidar', 'hdl64', '--pass', '3', '--parked', '3', '--reverse')))


def run(*words, statuses=(0,)):
    result = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if result.returncode not in statuses:
        sys.exit('measure_localization: failed: ' + ' '.join(map(str, words)) + '\n' + result.stdout[-2000:])
    return result


def program(name, *words, statuses=(0,)):
    return run('nice', PROGRAMS / name, *words, statuses=statuses)


class Trajectory(NamedTuple):
    stamps: np.ndarray  # s
    positions: np.ndarray  # m, a row for each
    quaternions: np.ndarray  # x y z w

    @staticmethod
    def read(path):
        rows = np.loadtxt(path, ndmin=2).reshape(-1, 8)
        # Stamps relative to a whole second: doubles have no nanoseconds since 1970.
        return Trajectory(rows[:, 0], rows[:, 1:4], rows[:, 4:8])


def rotation_of(q):
    x, y, z, w = q / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def at(trajectory, stamp):
    """Position and rotation at a stamp, or nothing outside of the trajectory."""
    i = int(np.searchsorted(trajectory.stamps, stamp))
    if i < len(trajectory.stamps) and abs(trajectory.stamps[i] - stamp) < 1e-4:
        return trajectory.positions[i], rotation_of(trajectory.quaternions[i])
    if i > 0 and abs(trajectory.stamps[i - 1] - stamp) < 1e-4:
        return trajectory.positions[i - 1], rotation_of(trajectory.quaternions[i - 1])
    if i == 0 or i == len(trajectory.stamps) or trajectory.stamps[i] - trajectory.stamps[i - 1] > GAP:
        return None
    u = (stamp - trajectory.stamps[i - 1]) / (trajectory.stamps[i] - trajectory.stamps[i - 1])
    a, b = trajectory.quaternions[i - 1], trajectory.quaternions[i]
    q = (1 - u) * a + u * (b if a @ b > 0 else -b)
    return (1 - u) * trajectory.positions[i - 1] + u * trajectory.positions[i], rotation_of(q)


def alignment(truth, estimate):
    """R, t with truth = R estimate + t (Umeyama 1991, without scale)."""
    pairs = [(at(truth, stamp), p) for stamp, p in zip(estimate.stamps, estimate.positions)]
    pairs = [(pose[0], p) for pose, p in pairs if pose is not None]
    a, b = np.array([p for p, _ in pairs]), np.array([p for _, p in pairs])
    u, _, vt = np.linalg.svd((a - a.mean(0)).T @ (b - b.mean(0)))
    r = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return r, a.mean(0) - r @ b.mean(0)


def angle_deg(r):
    return math.degrees(math.acos(max(-1.0, min(1.0, (np.trace(r) - 1) / 2))))


def error_of(row, truth, r_align, t_align):
    """Error of a localised scan in the axes of base_link (m), its angle (degrees) and normalised square for each of
    the axes of the translation; nothing where the truth has no pose."""
    true = at(truth, float(row['stamp']))
    if true is None:
        return None
    p = r_align @ np.array([float(row[c]) for c in 'xyz']) + t_align
    r = r_align @ rotation_of(np.array([float(row[c]) for c in ('qx', 'qy', 'qz', 'qw')]))
    error = r.T @ (true[0] - p)
    sigma = np.array([float(row['stddev_' + c]) for c in 'xyz'])
    return np.linalg.norm(error), angle_deg(r.T @ true[1]), float(np.mean((error / sigma) ** 2))


class World:
    """The map of a world, and drives through it."""

    def __init__(self, name, folder):
        self.drive, self.seconds = WORLDS[name]
        self.seed = SEEDS.get(name, 1)
        self.folder = folder / name
        self.folder.mkdir(parents=True, exist_ok=True)
        self.session = self.folder / 'map'
        if not (self.session / 'doubt.csv').exists():
            bag = self.simulated('mapping', ('--lidar', MAPPING_LIDAR, '--duration', self.seconds))
            program('map_bag', bag, '-o', self.session, '--no-map', '--allow-doubt')
            bag.unlink()
        self.align = alignment(Trajectory.read(self.folder / 'mapping.tum'),
                               Trajectory.read(self.session / 'trajectory/optimized.tum'))

    def simulated(self, name, words):
        bag = self.folder / f'{name}.bag'
        if self.drive == 'open_road':  # no car is parked there
            words = tuple(w for i, w in enumerate(words) if '--parked' not in words[max(0, i - 1):i + 1])
        program('simulate_drive', bag, '--drive', self.drive, '--seed', self.seed, '--truth',
                self.folder / f'{name}.tum', '--force', *words)
        return bag

    def localised(self, drive, start, seconds):
        """Rows, figures and truth of a part of a drive, which is simulated alone."""
        name = f'{drive.name.replace(" ", "_")}_from_{start:.0f}'
        figures = self.folder / f'{name}.json'
        if not figures.exists():
            bag = self.simulated(name, (*drive.words, '--start', start, '--duration', start + seconds))
            program('localize_bag', bag, self.session, '-o', self.folder / name, '--figures', figures, statuses=(0, 5))
            bag.unlink()
        with open(self.folder / name / 'localization.csv') as file:
            rows = list(csv.DictReader(file))
        return rows, json.loads(figures.read_text()), Trajectory.read(self.folder / f'{name}.tum')

    def starts(self, count, seconds):
        """Evenly over the drive, which lasts nearly as long on each day."""
        stamps = Trajectory.read(self.folder / 'mapping.tum').stamps
        last = float(stamps[-1] - stamps[0]) - seconds - SHORTER
        return [round(i * last / max(1, count - 1)) for i in range(count)]


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values)) if values else float('nan')


class Row:
    """What is gathered of all starts of a drive."""

    def __init__(self, world, drive):
        self.world, self.drive = world, drive
        self.found, self.states = [], dict.fromkeys(('searching', 'following', 'beside_map', 'lost'), 0)
        self.errors, self.angles, self.squares = [], [], []
        self.wrong = 0  # starts with a wrong pose
        self.beside_errors = []
        self.following, self.searching = [], []

    def add(self, rows, figures, truth, align):
        """Takes one start in; returns the number of wrong poses."""
        after = figures['found_after']
        self.found.append(after['seconds'] if after else math.inf)
        wrong = 0
        for row in rows:
            self.states[row['state']] += 1
            error = error_of(row, truth, *align) if row['x'] else None
            if error is None:
                continue
            wrong += error[0] > WRONG_M or error[1] > WRONG_DEG
            if row['state'] == 'following':
                self.errors.append(error[0])
                self.angles.append(error[1])
                self.squares.append(error[2])
            else:
                self.beside_errors.append(error[0])
        self.wrong += wrong > 0
        for kind, times in (('following', self.following), ('searching', self.searching)):
            if figures['milliseconds'][kind]:
                times.append((figures['milliseconds'][kind]['mean'], figures['milliseconds'][kind]['p99']))
        return wrong

    def cells(self):
        scans = max(1, sum(self.states.values()))
        share = {state: 100 * count / scans for state, count in self.states.items()}
        soon = sum(seconds <= SOON for seconds in self.found)
        ever = sum(math.isfinite(seconds) for seconds in self.found)
        return [self.world, self.drive, f'{len(self.found)}', f'{soon}', f'{ever}', f'{self.wrong}',
                f'{100 * rms(self.errors):.1f}', f'{rms(self.angles):.3f}',
                f'{100 * max(self.errors, default=float("nan")):.0f}',
                f'{np.mean(self.squares) if self.squares else float("nan"):.2f}',
                f'{share["following"]:.0f} / {share["beside_map"]:.1f} / {share["lost"]:.1f}',
                time_cell(self.following), time_cell(self.searching)]


def time_cell(times):
    if not times:
        return '-'
    return f'{np.mean([mean for mean, _ in times]):.1f} / {max(p99 for _, p99 in times):.1f}'


HEAD = ['map', 'drive', 'starts', 'found within 3 s', 'found', 'with a wrong pose', 'error rms, cm', 'rms, degrees',
        'greatest, cm', 'square / variance', 'followed / beside / lost, %', 'ms, mean / p99', 'searching: ms']


def table(rows):
    lines = ['| ' + ' | '.join(HEAD) + ' |', '|' + ' --- |' * len(HEAD)]
    return '\n'.join(lines + ['| ' + ' | '.join(row.cells()) + ' |' for row in rows]) + '\n'


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('folder', type=pathlib.Path)
    parser.add_argument('--worlds', nargs='+', default=list(WORLDS), choices=list(WORLDS))
    parser.add_argument('--starts', type=int, default=6, help='of each drive, evenly over its length')
    parser.add_argument('--seconds', type=float, default=15.0, help='that are localised from each start')
    parser.add_argument('--table', type=pathlib.Path, help='write the table to this file')
    given = parser.parse_args()
    rows = []
    for name in given.worlds:
        world = World(name, given.folder)
        for drive in DRIVES:
            row = Row(name, drive.name)
            for start in world.starts(given.starts, given.seconds):
                wrong = row.add(*world.localised(drive, start, given.seconds), world.align)
                print(f'{name}, {drive.name}, from {start} s: found after {row.found[-1]:.1f} s, {wrong} wrong',
                      flush=True)
            rows.append(row)
            print(' | '.join(row.cells()), flush=True)
            if given.table:
                given.table.write_text(table(rows))
    print(table(rows))


if __name__ == '__main__':
    main()
