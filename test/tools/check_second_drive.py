#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds scripts/second_drive.py and scripts/plot_localization.py: the demo's figures and picture of another day.

check_second_drive.py: without the package's programs; the working folder is test/
"""
import argparse
import json
import pathlib
import struct
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / 'scripts'))
import plot_localization  # noqa: E402
import second_drive  # noqa: E402

COLUMNS = ('stamp,state,x,y,z,qx,qy,qz,qw,stddev_x,stddev_y,stddev_z')
SHIFT = 100.0  # m, of the simulated world against the map


def options(**changes):
    return argparse.Namespace(**{'drive': 'town', 'lidar': 'hdl64', 'seed': 1, 'duration': None, **changes})


def write_poses(path, shift):
    """Ten seconds along an L, a pose in each tenth of a second."""
    rows = []
    for i in range(101):
        x, y = (0.1 * i, 0.0) if i <= 50 else (5.0, 0.1 * (i - 50))
        rows.append(f'{0.1 * i:.1f} {x + shift} {y} 0 0 0 0 1')
    path.write_text('\n'.join(rows) + '\n')


def write_scans(path, error):
    """Two scans that are searched for, and four with a pose whose x is wrong by an error, in m."""
    rows = [COLUMNS] + [f'{0.1 * i:.1f},searching' + ',' * 10 for i in range(2)]
    rows += [f'{0.1 * i:.1f},following,{0.1 * i + error},0,0,0,0,0,1,0.1,0.1,0.1' for i in range(2, 6)]
    path.write_text('\n'.join(rows) + '\n')


def write_map(path, kind='binary_little_endian', points=((1.0, 1.0, 2.0), (2.0, 3.0, 3.0), (0.0, 0.0, 40.0))):
    names = ''.join(f'property float {name}\n' for name in ('x', 'y', 'z', 'intensity'))
    header = f'ply\nformat {kind} 1.0\nelement vertex {len(points)}\n{names}end_header\n'
    path.write_bytes(header.encode() + b''.join(struct.pack('<4f', *p, 1.0) for p in points))


class Folder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        (self.folder / 'session' / 'trajectory').mkdir(parents=True)
        write_poses(self.folder / 'mapping.tum', SHIFT)
        write_poses(self.folder / 'session' / 'trajectory' / 'optimized.tum', 0.0)


class SecondDrive(Folder):
    def localize(self, found_after, error=0.03):
        def rosrun(program, *words, statuses=(0,)):
            self.assertIn(program, ('simulate_drive', 'localize_bag'))
            if program == 'simulate_drive':
                write_poses(self.folder / 'another_day.tum', SHIFT)
                return
            self.assertEqual(statuses, (0, 5))
            self.assertFalse((self.folder / 'another_day').exists())
            (self.folder / 'another_day').mkdir()
            write_scans(self.folder / 'another_day' / 'localization.csv', error)
            (self.folder / 'another_day.json').write_text(json.dumps(
                {'scans': 6, 'states': {'following': 4}, 'found_after': found_after}))
        return second_drive.localize(options(), self.folder / 'session', self.folder / 'mapping.tum', self.folder, rosrun)

    def test_is_judged_in_the_simulated_world(self):
        figures = self.localize({'seconds': 0.2, 'metres': 0.2})
        self.assertAlmostEqual(figures.pop('localization_rmse'), 0.03, places=6)
        self.assertEqual(figures, {'localization_scans': 6, 'localization_scans_followed': 4,
                                   'localization_found_after_seconds': 0.2})

    def test_replaces_the_results_of_an_earlier_demo(self):
        self.localize({'seconds': 0.2, 'metres': 0.2})
        self.assertAlmostEqual(self.localize({'seconds': 0.2, 'metres': 0.2}, 0.05)['localization_rmse'], 0.05, places=6)

    def test_may_stay_unfound(self):
        self.assertIsNone(self.localize(None)['localization_found_after_seconds'])

    def test_drives_back_where_one_can(self):
        self.assertIn('--reverse', second_drive.words_for(options()))
        self.assertNotIn('--reverse', second_drive.words_for(options(drive='tunnel')))
        short = second_drive.words_for(options(duration=20.0))
        self.assertNotIn('--reverse', short)
        self.assertEqual(short[-2:], ['--duration', 20.0])


class Picture(Folder):
    def test_is_drawn(self):
        write_poses(self.folder / 'another_day.tum', SHIFT)
        write_scans(self.folder / 'localization.csv', 0.03)
        write_map(self.folder / 'map.ply')
        picture = self.folder / 'localization.png'
        plot_localization.main(self.folder / 'map.ply', self.folder / 'localization.csv', self.folder / 'another_day.tum',
                               self.folder / 'mapping.tum', self.folder / 'session/trajectory/optimized.tum', picture)
        self.assertEqual(picture.read_bytes()[1:4], b'PNG')

    def test_has_the_points_of_the_map(self):
        write_map(self.folder / 'map.ply')
        self.assertEqual(plot_localization.read_points(self.folder / 'map.ply').tolist(),
                         [[1.0, 1.0, 2.0], [2.0, 3.0, 3.0], [0.0, 0.0, 40.0]])

    def test_names_a_map_that_it_cannot_read(self):
        write_map(self.folder / 'map.ply', kind='ascii')
        with self.assertRaisesRegex(SystemExit, 'map.ply is not a binary PLY file'):
            plot_localization.read_points(self.folder / 'map.ply')

    def test_has_the_error_over_the_distance(self):
        write_poses(self.folder / 'another_day.tum', SHIFT)
        write_scans(self.folder / 'localization.csv', 0.03)
        scans = plot_localization.read_scans(self.folder / 'localization.csv')
        truth = plot_localization.Trajectory.read(self.folder / 'another_day.tum')
        align = plot_localization.alignment(truth, plot_localization.Trajectory.read(
            self.folder / 'session/trajectory/optimized.tum'))
        errors = plot_localization.errors_along(scans, truth, align)
        self.assertEqual(errors.shape, (4, 3))
        self.assertAlmostEqual(errors[0, 0], 0.2, places=6)
        self.assertAlmostEqual(errors[0, 1], 0.03, places=6)


if __name__ == '__main__':
    unittest.main()
