#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measure localisation on simulated drives of other days (doc/results/localization.md).

Makes a map of each world from one drive, then localises other drives through it, from many starts: other traffic and
parked cars, the opposite direction, another sensor. Errors are against the truth of the simulation, which no other
program reads. Maps, bags and results stay in the folder, and what is there is not made again. The package must be
built (LIDAR_MAPPING_BUILD: its build folder). With --cases the drives are interrupted instead (--cases all, or some of
interrupted_drives.CASES): where, is drawn with --seeds.

usage: measure_localization.py FOLDER [--worlds town twins] [--starts 6] [--seconds 15] [--table FILE]
       measure_localization.py FOLDER --cases all [--worlds town city] [--lidars vlp16 os1_64] [--seeds 1 2]
"""
import argparse
import csv
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
from typing import NamedTuple

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import interrupted_drives as interrupted  # noqa: E402
from localization_truth import Trajectory, alignment, error_of  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = pathlib.Path(os.environ.get('LIDAR_MAPPING_BUILD', ROOT / '.build'))
PROGRAMS = BUILD / 'devel/lib/lidar_mapping'
SOON = 3.0  # s, within which a place should be found
SHORTER = 6.0  # s, by which another day's drive may end earlier than the mapping one
# Drive of simulate_drive and its seconds that are mapped: all of it.
WORLDS = {'town': ('town', 160), 'twins': ('twins', 120), 'car_park': ('car_park', 175),
          'figure_eight': ('figure_eight', 130), 'field': ('open_road', 100), 'hill': ('open_road', 100),
          'city': ('city', 200)}  # of the city the first 1.6 km
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


class World:
    """The map of a world, and drives through it."""

    def __init__(self, name, given):
        self.name = name
        self.drive, self.seconds = WORLDS[name]
        seed, lidar = given.world_seed, given.mapping_lidar
        self.seed = seed or SEEDS.get(name, 1)
        self.folder = given.folder / '_'.join([name] + [str(seed)] * bool(seed) + [lidar] * (lidar != MAPPING_LIDAR))
        self.folder.mkdir(parents=True, exist_ok=True)
        self.session = self.folder / 'map'
        if not (self.session / 'doubt.csv').exists():
            bag = self.simulated('mapping', ('--lidar', lidar, '--duration', self.seconds))
            program('map_bag', bag, '-o', self.session, '--no-map', '--allow-doubt')
            bag.unlink()
        self.truth = Trajectory.read(self.folder / 'mapping.tum')
        self.align = alignment(self.truth, Trajectory.read(self.session / 'trajectory/optimized.tum'))

    def words(self, words):
        if self.drive == 'open_road':  # no car is parked there
            words = tuple(w for i, w in enumerate(words) if '--parked' not in words[max(0, i - 1):i + 1])
        return ('--drive', self.drive, '--seed', self.seed, *words,
                *(('--rounds', 1) if self.drive == 'city' else ()))

    def simulated(self, name, words):
        bag = self.folder / f'{name}.bag'
        program('simulate_drive', bag, '--truth', self.folder / f'{name}.tum', '--force', *self.words(words))
        return bag

    def truth_of(self, name, words):
        """Of a whole drive, whose measurements are not simulated."""
        path = self.folder / f'{name}.tum'
        program('simulate_drive', '--truth', path, '--force', *self.words(words))
        return Trajectory.read(path)

    def localised(self, drive, start, seconds):
        """Rows, figures and truth of a part of a drive, which is simulated alone."""
        name = f'{drive.name.replace(" ", "_")}_from_{start:.0f}'
        figures = self.folder / f'{name}.json'
        if not figures.exists():
            bag = self.simulated(name, (*drive.words, '--start', start, '--duration', start + seconds))
            program('localize_bag', bag, self.session, '-o', self.folder / name, '--figures', figures, statuses=(0, 5))
            bag.unlink()
        return (read_rows(self.folder / name), json.loads(figures.read_text()),
                Trajectory.read(self.folder / f'{name}.tum'))

    def places(self):
        """Positions of the key frames, which are numbered from 0, in the simulated world."""
        r, t = self.align
        return Trajectory.read(self.session / 'trajectory/optimized.tum').positions @ r.T + t

    def starts(self, count, seconds):
        """Evenly over the drive, which lasts nearly as long on each day."""
        stamps = self.truth.stamps
        last = float(stamps[-1] - stamps[0]) - seconds - SHORTER
        return [round(i * last / max(1, count - 1)) for i in range(count)]


def read_rows(folder):
    with open(folder / 'localization.csv') as file:
        return list(csv.DictReader(file))


def interrupt(world, case, lidar, seed):
    """Outcome of an interrupted drive of another day, and whether the interruption is sudden; nothing if the world
    has no room for it."""
    name = f'{case}_{lidar}_{seed}'
    words = ('--lidar', lidar, '--pass', 100 + seed, '--parked', 100 + seed, '--no-gnss')
    rng = interrupted.random_of(seed, case, world.name)
    whole = world.truth_of(name, (*words, '--duration', world.seconds))
    session = world.session
    if case == interrupted.OUT_OF_MAP:
        interruption, is_out = interrupted.out_of_the_map(whole, world.places(), rng)
        session = world.folder / f'{name}_map'
    else:
        interruption = interrupted.CASES[case](whole, rng)
    if interruption is None:
        return None
    bag, path = world.folder / f'{name}.bag', world.folder / name
    if not bag.exists():
        if session != world.session:
            interrupted.without(world.session, session, np.flatnonzero(is_out))
        truth = interrupted.join(world, name, words, interruption.pieces, bag)
        np.savez(path.with_suffix('.npz'), *truth)
    truth = Trajectory(*np.load(path.with_suffix('.npz')).values())
    if path.exists():
        shutil.rmtree(path)
    program('localize_bag', bag, session, '-o', path, statuses=(0, 5))
    return interrupted.judge(read_rows(path), truth, world.align, interruption), interruption.is_sudden


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values)) if values else float('nan')


class Row:
    """What is gathered of all starts of a drive."""

    def __init__(self, world, drive):
        self.world, self.drive = world, drive
        self.found, self.states = [], dict.fromkeys(('searching', 'following', 'beside_map', 'lost'), 0)
        self.errors, self.angles, self.squares = [], [], []
        self.wrong = 0  # starts with a wrong pose
        self.following, self.searching = [], []

    def add(self, rows, figures, truth, align):
        """Takes one start in; returns the number of wrong poses."""
        after = figures['found_after']
        self.found.append(after['seconds'] if after else math.inf)
        wrong = 0
        for row in rows:
            self.states[row['state']] += 1
            error = error_of(row, truth, *align)
            if error is None:
                continue
            wrong += error.is_wrong()
            if row['state'] == 'following':
                self.errors.append(error.metres)
                self.angles.append(error.degrees)
                self.squares.append(error.square)
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


def table(head, rows):
    lines = ['| ' + ' | '.join(head) + ' |', '|' + ' --- |' * len(head)]
    return '\n'.join(lines + ['| ' + ' | '.join(row) + ' |' for row in rows]) + '\n'


def report(head, rows, given):
    print(' | '.join(rows[-1]), flush=True)
    if given.table:
        given.table.write_text(table(head, rows))


def measure_starts(given):
    rows = []
    for name in given.worlds or [name for name in WORLDS if name != 'city']:
        world = World(name, given)
        for drive in DRIVES:
            row = Row(name, drive.name)
            for start in world.starts(given.starts, given.seconds):
                wrong = row.add(*world.localised(drive, start, given.seconds), world.align)
                print(f'{name}, {drive.name}, from {start} s: found after {row.found[-1]:.1f} s, {wrong} wrong',
                      flush=True)
            rows.append(row.cells())
            report(HEAD, rows, given)
    print(table(HEAD, rows))


def measure_interruptions(given):
    cases = list(interrupted.CASES) if given.cases == ['all'] else given.cases
    rows = []
    for name in given.worlds or ('town', 'city'):
        world = World(name, given)
        for case in cases:
            for lidar in given.lidars:
                outcomes = []
                for seed in given.seeds:
                    outcome = interrupt(world, case, lidar, seed)
                    print(f'{name}, {case}, {lidar}, seed {seed}: {outcome}', flush=True)
                    if outcome:
                        outcomes.append(outcome)
                if outcomes:
                    rows.append(interrupted.cells(case, name, lidar, [o for o, _ in outcomes], outcomes[0][1]))
                    report(interrupted.HEAD, rows, given)
    print(table(interrupted.HEAD, rows))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('folder', type=pathlib.Path)
    parser.add_argument('--worlds', nargs='+', choices=list(WORLDS))
    parser.add_argument('--mapping-lidar', default=MAPPING_LIDAR, help='that makes the maps')
    parser.add_argument('--world-seed', type=int, help='of all worlds; their own ones if left out')
    parser.add_argument('--starts', type=int, default=6, help='of each drive, evenly over its length')
    parser.add_argument('--seconds', type=float, default=15.0, help='that are localised from each start')
    parser.add_argument('--cases', nargs='+', choices=['all', *interrupted.CASES],
                        help='interrupt the drives instead, in these ways')
    parser.add_argument('--lidars', nargs='+', default=['vlp16', 'os1_64'], help='of interrupted drives')
    parser.add_argument('--seeds', nargs='+', type=int, default=[1, 2],
                        help='one interrupted drive each: its day, and where it is interrupted')
    parser.add_argument('--table', type=pathlib.Path, help='write the table to this file')
    given = parser.parse_args()
    measure_interruptions(given) if given.cases else measure_starts(given)


if __name__ == '__main__':
    main()
