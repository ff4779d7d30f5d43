#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds scripts/ablate.py: constants are found, one at a time is changed, figures are compared as documented.

check_ablate.py: without a compiler; the working folder is test/
"""
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / 'scripts'))
import ablate  # noqa: E402

SOURCE = '''// Of the search: kept small.
constexpr std::size_t kStarts = 5;
constexpr double kStep = 0.3;  // m; chosen
constexpr double kLong =
    60.0;  // s
constexpr double kTwiceStep = kTwo * kStep;

/// Metres.
constexpr float kEdge = 0.5F;
constexpr Weight kWeight{0.25, -0.5};
constexpr int kTableBits = 14;
constexpr int kOne = 1;
'''


def run(ape, wrong=0, cpu=10.0):
    return {'case': 'x', 'ape_m': ape, 'wrong': wrong, 'silent': 0, 'false_alarms': 0, 'cpu_ms': cpu}


def row(name, variant, status='measured', **changes):
    figures = {figure: 1.0 if figure in ablate.RATIOS else 0.0 for figure in ablate.LEAST}
    figures.update(changes)
    return {'file': 'src/a.cpp', 'name': name, 'variant': variant, 'value': '2', 'status': status,
            **{figure: str(value) for figure, value in figures.items()}}


class Constants(unittest.TestCase):
    def setUp(self):
        self.constants = {c.name: c for c in ablate.constants_of('src/a.cpp', SOURCE)}

    def test_are_found_with_value_and_comment(self):
        self.assertEqual(list(self.constants), ['kStarts', 'kStep', 'kLong', 'kEdge', 'kWeight', 'kTableBits', 'kOne'])
        self.assertEqual(self.constants['kLong'].value, '60.0')
        self.assertEqual(self.constants['kStep'].comment, 'm; chosen')
        self.assertEqual(self.constants['kStarts'].comment, 'Of the search: kept small.')
        self.assertEqual(self.constants['kWeight'].comment, 'Metres.')

    def test_are_halved_and_doubled(self):
        def changed(name):
            return [ablate.changed_value(self.constants[name], factor) for factor in (0.5, 2.0)]
        self.assertEqual(changed('kStarts'), ['3', '10'])
        self.assertEqual(changed('kStep'), ['0.5 * (0.3)', '2 * (0.3)'])
        self.assertEqual(changed('kEdge')[0], 'static_cast<float>(0.5 * (0.5F))')
        self.assertEqual(changed('kWeight')[1], '{2 * (0.25), 2 * (-0.5)}')
        self.assertEqual(changed('kTableBits'), ['14 - 1', '14 + 1'])
        self.assertEqual(changed('kOne'), [None, '2'])
        self.assertEqual([ablate.scaled('bool', 'true', factor) for factor in (0.5, 2.0)], ['!(true)', None])

    def test_one_is_patched(self):
        before = SOURCE.split('\n')
        after = ablate.patched(SOURCE, self.constants['kStep'], '9').split('\n')
        self.assertEqual(after[2], 'constexpr double kStep = 9;')
        self.assertEqual(before[:2] + before[3:], after[:2] + after[3:])
        self.assertIn('constexpr Weight kWeight{1, 2};', ablate.patched(SOURCE, self.constants['kWeight'], '{1, 2}'))
        long = ablate.patched(SOURCE, self.constants['kLong'], '9')
        self.assertIn('constexpr double kLong = 9;\nconstexpr double kTwiceStep', long)

    def test_of_this_package_can_be_changed(self):
        constants = list(ablate.all_constants(ablate.ROOT))
        self.assertGreater(len(constants), 500)
        for constant in constants:
            text = (ablate.ROOT / constant.path).read_text()
            self.assertIn(constant.value.split()[0], text)
            value = ablate.changed_value(constant, 2.0)
            if value is None:  # twice nothing is nothing
                self.assertEqual(float(constant.value), 0.0)
                continue
            after = {c.name: c for c in ablate.constants_of(constant.path, ablate.patched(text, constant, value))}
            self.assertEqual(after[constant.name].value, value)


class Mechanisms(unittest.TestCase):
    def test_are_where_the_list_says(self):
        changes = list(ablate.changes_of_mechanisms(ablate.ROOT / 'test/campaign/ablation_mechanisms.txt'))
        self.assertGreater(len(changes), 30)
        self.assertEqual(len({change.name for change in changes}), len(changes))
        for change in changes:
            text = (ablate.ROOT / change.path).read_text()
            self.assertIn(change.new_value, change.patch(text))

    def test_stop_the_program_where_the_list_is_old(self):
        with self.assertRaises(SystemExit):
            ablate.replaced('a b a', 'a', 'c', 'name')


class Figures(unittest.TestCase):
    def test_are_ratios_and_differences(self):
        base = {'brier': 0.05, 'runs': [run(0.1), run(0.4, 2)]}
        other = {'brier': 0.06, 'runs': [run(0.2, 1, 15.0), run(0.4, 5)]}
        figures = ablate.compare([base, base], other)
        self.assertAlmostEqual(figures['ape'], 2.0 ** 0.5, 4)
        self.assertAlmostEqual(figures['worst_ratio'], 2.0, 4)
        self.assertEqual(figures['wrong'], 3)  # a single step of the first drive is no change
        self.assertAlmostEqual(figures['brier'], 0.01)
        self.assertAlmostEqual(figures['cpu'], 1.25)

    def test_count_by_how_well_they_repeat(self):
        references = [{'brier': 0.05, 'runs': [run(0.1), run(0.1 * factor)]} for factor in (1.0, 2.0, 4.0)]
        other = {'brier': 0.05, 'runs': [run(0.12), run(0.8)]}
        figures = ablate.compare(references, other)
        self.assertAlmostEqual(figures['ape'], 1.2, 2)  # the second drive says next to nothing
        self.assertAlmostEqual(figures['worst_ratio'], 1.2, 4)
        self.assertAlmostEqual(figures['worst_sigmas'], 0.1823 / ablate.LEAST_SIGMA, 2)

    def test_are_of_chosen_drives(self):
        text = '# Drives\na drive=town\nab seed=1\nb seed=2\n'
        self.assertEqual(ablate.chosen_cases(text, ''), text)
        self.assertEqual(ablate.chosen_cases(text, 'a$|b'), '# Drives\na drive=town\nb seed=2\n')

    def test_are_the_same_whatever_the_time(self):
        base = {'brier': 0.05, 'runs': [run(0.1)]}
        self.assertTrue(ablate.is_same(base, {'brier': 0.05, 'runs': [run(0.1, cpu=11.0)]}))
        self.assertFalse(ablate.is_same(base, {'brier': 0.05, 'runs': [run(0.1000001)]}))


class Table(unittest.TestCase):
    def test_says_what_matters(self):
        rows = [row('', 'noise 1', ape=1.01), row('', 'noise 2', ape=1 / 1.01),
                row('kNothing', 'half', ape=1.02), row('kNothing', 'twice', status='no change'),
                row('kBetter', 'half', ape=1.1), row('kBetter', 'twice', ape=0.95),
                row('kLarge', 'half', wrong=60), row('kLarge', 'twice', ape=1.4),
                row('kFixed', 'half', status='does not compile'), row('kFixed', 'twice', status='does not compile'),
                row('kUnused', 'half', status='no change'), row('kUnused', 'twice', status='no change'),
                row('kSlow', 'half', cpu=0.5), row('kSlow', 'twice', cpu=1.2)]
        lines = ablate.table_of(rows, list(ablate.FACTORS), 'constant', True).splitlines()[2:]
        verdicts = {line.split('|')[1].strip(' `'): line.split('|')[-2].strip() for line in lines}
        self.assertEqual(verdicts, {'kNothing': 'moves nothing', 'kBetter': 'matters; better at twice',
                                    'kLarge': 'matters', 'kFixed': 'not movable', 'kUnused': 'no figure changes',
                                    'kSlow': 'matters for the time'})
        self.assertEqual(list(verdicts)[:2], ['kLarge', 'kSlow'])
        self.assertIn('ape 1.40', lines[0])


class Drives(unittest.TestCase):
    def figures(self, score):
        """Of a program that writes one drive and prints that Brier's score."""
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder) / 'program'
            program.write_text('#!/bin/sh\n'
                               f"echo 'Brier score of the probability: {score}'\n"
                               """for file; do :; done; echo '{"runs": []}' >"$file"\n""")
            program.chmod(0o755)
            return ablate.run_drives(program, 'cases.txt', 4.0, pathlib.Path(folder) / 'a.log')

    def test_have_a_score_that_is_a_number(self):
        self.assertEqual(self.figures('0.05'), {'brier': 0.05, 'runs': []})
        self.assertIsNone(self.figures('nan'))


class Resumption(unittest.TestCase):
    def test_leaves_out_what_the_file_has_and_restores(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            arguments = ['--match', 'coasting.cpp:kRest', '--folder', str(folder / 'copy'), '--noise', '2',
                         '--output', str(folder / 'a.csv'), '--table', str(folder / 'a.md'), '--basis', 'none']
            original = (ablate.ROOT / 'src/front_end/motion/coasting.cpp').read_text()
            copied = folder / 'copy/src/front_end/motion/coasting.cpp'
            built = []

            def build(*_):
                built.append(copied.read_text() != original)
                return True

            figures = {'brier': 0.05, 'runs': [run(0.1)]}
            for path in (copied, folder / 'copy/.build' / ablate.TARGET):
                path.parent.mkdir(parents=True)
                path.write_text('')
            with mock.patch.object(ablate, 'build', build), mock.patch('builtins.print'), \
                    mock.patch.object(ablate, 'update_copy', lambda *_: copied.write_text(original)), \
                    mock.patch.object(ablate, 'run_drives', lambda *_: figures):
                ablate.main(arguments)
                self.assertEqual(built, [False, True, True, True, True])
                ablate.main(arguments)
            self.assertEqual(len(built), 5)
            self.assertEqual(len(ablate.read_rows(folder / 'a.csv')), 7)
            self.assertEqual(copied.read_text(), original)
            self.assertIn('no figure changes', (folder / 'a.md').read_text())


if __name__ == '__main__':
    unittest.main()
