#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds scripts/spoilt_recordings.py: its verdicts, its tables, and which variants it examines.

check_spoilt_recordings.py: without the package's programs, with ROS's modules; the working folder is test/
"""
import argparse
import contextlib
import io
import json
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / 'scripts'))
import spoilt_recordings  # noqa: E402
from recording_faults import examination, verdicts  # noqa: E402


def outcome(name='gnss_frozen', said=(), ape=0.005, **changes):
    return {'name': name, 'sensors': 'all', 'check_status': 0, 'check_bag': [], 'map_status': 0,
            'map_bag': list(said), 'ape': ape, 'coverage': 1.0, **changes}


class Verdicts(unittest.TestCase):
    def expect(self, verdict, **changes):
        self.assertEqual(verdicts.judge(outcome(**changes), 0.002), verdict, changes)

    def test_of_a_map_that_is_as_exact(self):
        limit = 3 * 0.002 + 0.03  # m
        self.expect('good', ape=limit - 1e-6)
        self.expect('good', coverage=0.9, said=['  gnss      10.0 Hz'])
        self.expect('alarm', said=['    WARNING: the points have no times'])
        self.expect('alarm', check_status=1)
        self.expect('alarm', map_status=4)

    def test_of_a_map_that_is_worse_or_missing(self):
        for worse in ({'ape': 0.0361}, {'coverage': 0.89}, {'ape': None, 'coverage': 0.0}):
            self.expect('SILENT', **worse)
            self.expect('named', said=['it is doubtful'], **worse)
            self.expect('named', check_status=1, **worse)
            self.expect('named', map_status=1, **worse)

    def test_of_a_program_that_was_ended_by_a_signal(self):
        self.expect('CRASH', check_status=-11)
        self.expect('CRASH', map_status=-6, said=['error'], ape=None)

    def test_compare_with_the_clean_recording_of_the_same_sensors(self):
        results = [outcome('imu_clean', ape=0.004), outcome('all_clean', ape=0.003), outcome('clouds_clean', ape=None)]
        self.assertEqual(verdicts.reference_error(results, 'all'), 0.003)
        self.assertEqual(verdicts.reference_error(results, 'clouds'), 0.0)
        self.assertEqual(verdicts.reference_error(results, 'gnss'), verdicts.UNKNOWN_REFERENCE_M)


class Tables(unittest.TestCase):
    RESULTS = [outcome(name, verdict=verdict, ape=ape) for name, verdict, ape in (
        ('all_clean', 'good', 0.002), ('gnss_frozen', 'alarm', 0.0121), ('gnss_at_0_0', 'alarm', 0.002),
        ('gnss_in_radians', 'SILENT', 0.5), ('times_missing', 'named', None), ('truncated', 'CRASH', None),
        ('of_an_earlier_version', 'good', 0.002))]

    def test_have_a_row_for_each_result(self):
        rows = verdicts.table(self.RESULTS).splitlines()[2:]
        self.assertEqual(rows[1], '| `gnss_frozen` | all | 12.1 | alarm |')
        self.assertEqual(rows[4], '| `times_missing` | all |  | named |')
        self.assertEqual(len(rows), len(self.RESULTS))

    def test_have_counts_that_add_up(self):
        cells = [[cell.strip() for cell in line.strip('|').split('|')]
                 for line in verdicts.counts(self.RESULTS).splitlines()]
        self.assertEqual(cells[0], ['kind', 'variants', *verdicts.VERDICTS])
        rows = {row[0]: [int(cell) for cell in row[1:]] for row in cells[2:]}
        self.assertEqual(rows['gnss'], [3, 0, 2, 0, 1, 0])
        for kind, row in rows.items():
            self.assertEqual(row[0], sum(row[1:]), kind)
        total = rows.pop('all')
        self.assertEqual(total, [len(self.RESULTS), 2, 2, 1, 1, 1])
        self.assertEqual(total, [sum(column) for column in zip(*rows.values())])


class Examination(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = scratch.name
        self.results = scratch.name + '/results.jsonl'

    def examined(self, *only):
        """Names that were examined, by programs that leave no trace of gnss_frozen and fail for truncated."""
        names = []

        def examine(name, options, clean):
            names.append(name)
            if name == 'truncated':
                raise OSError('disk full')
            return outcome(name, ape=None if name == 'gnss_frozen' else 0.003)
        options = argparse.Namespace(output=self.folder, only=only, keep=False)
        self.printed = io.StringIO()
        with mock.patch.multiple(spoilt_recordings, examine=examine, simulate=mock.DEFAULT,
                                 read_records=mock.DEFAULT), \
                contextlib.redirect_stdout(self.printed):
            spoilt_recordings.examine_all(options, self.results)
        return names

    def test_keeps_results_and_goes_on_after_a_variant_that_cannot_be_made(self):
        self.assertEqual(self.examined('truncated', 'all_clean', 'gnss_frozen'),
                         ['all_clean', 'gnss_frozen', 'truncated'])
        self.assertIn("truncated could not be made: OSError('disk full')", self.printed.getvalue())
        self.assertIn('== gnss_frozen (all): SILENT, APE -, 100 % of the time', self.printed.getvalue())
        self.assertEqual(self.examined('all_', 'gnss_froz', 'trunc'), ['truncated'])
        kept = [json.loads(line) for line in pathlib.Path(self.results).read_text().splitlines()]
        self.assertEqual([(r['name'], r['verdict']) for r in kept], [('all_clean', 'good'), ('gnss_frozen', 'SILENT')])

    def test_shifts_the_truth_by_whole_nanoseconds(self):
        truth = pathlib.Path(self.folder, 'truth.tum')
        truth.write_text('1317384506.05 1 2 3 0 0 0 1\n1317384506.999999999 1 2 3 0 0 0 1\n')
        moved = examination.shifted_truth(str(truth), self.folder + '/moved.tum', 0.1)
        self.assertEqual([line.split()[0] for line in pathlib.Path(moved).read_text().splitlines()],
                         ['1317384506.150000000', '1317384507.099999999'])

    def test_finds_no_time_span_in_an_empty_trajectory(self):
        empty = pathlib.Path(self.folder, 'empty.tum')
        empty.write_text('# stamp x y z\n')
        self.assertEqual(examination.error_of(self.folder, 'no truth', str(empty), 0.0), (None, 0.0))


if __name__ == '__main__':
    unittest.main()
