#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds count_tests.py against results that are known: what it counts, and what it shows of a failed test."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

COUNT_TESTS = pathlib.Path(__file__).resolve().parents[2] / 'scripts' / 'count_tests.py'

RESULTS = '''<testsuites><testsuite>
  <testcase classname="Map" name="IsRound" status="run"/>
  <testcase classname="Map" name="IsFlat" status="run"><failure message="short">Which is: 256</failure></testcase>
  <testcase classname="Map" name="IsOld" status="run"><skipped/></testcase>
</testsuite></testsuites>'''
NODE_RESULTS = '''<testsuite>
  <testcase classname="Node" name="Answers"><error>no answer</error></testcase>
</testsuite>'''
LOG = '''[ RUN      ] Map.IsRound
[       OK ] Map.IsRound (1 ms)
[ RUN      ] Map.IsFlat
helper: the height is no number
Which is: 256
[  FAILED  ] Map.IsFlat (3 ms)
[  FAILED  ] Map.IsFlat
 1 FAILED TEST
'''


class CountTests(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)
        (self.path / 'gtest-map.xml').write_text(RESULTS)

    def counted(self, *logs):
        done = subprocess.run([sys.executable, COUNT_TESTS, self.path, *logs], stdout=subprocess.PIPE,
                              universal_newlines=True, check=False)
        return done.returncode, done.stdout.splitlines()

    def test_shows_what_the_log_has_of_a_failed_test(self):
        log = self.path / 'run.log'
        log.write_text(LOG)
        self.assertEqual(self.counted(log), (1, [
            'skipped: Map.IsOld', 'failed: Map.IsFlat', '    helper: the height is no number',
            '    Which is: 256', '1 passed, 1 failed, 1 skipped']))

    def test_shows_the_failure_of_a_test_that_is_in_no_log(self):
        (self.path / 'rosunit-node.xml').write_text(NODE_RESULTS)
        self.assertEqual(self.counted(), (1, [
            'skipped: Map.IsOld', 'failed: Map.IsFlat', '    Which is: 256', 'failed: Node.Answers',
            '    no answer', '1 passed, 2 failed, 1 skipped']))

    def test_shows_the_last_lines_of_a_long_failure(self):
        log = self.path / 'run.log'
        log.write_text(LOG.replace('helper: ', 'far too long\n' * 50 + 'helper: '))
        shown = [line for line in self.counted(log)[1] if line.startswith('    ')]
        self.assertEqual(len(shown), 40)
        self.assertEqual(shown[-2:], ['    helper: the height is no number', '    Which is: 256'])

    def test_fails_where_nothing_was_run(self):
        (self.path / 'gtest-map.xml').unlink()
        self.assertEqual(self.counted(), (1, ['0 passed, 0 failed']))

    def test_passes_where_nothing_failed(self):
        (self.path / 'gtest-map.xml').write_text('<testsuite><testcase classname="Map" name="IsRound"/></testsuite>')
        self.assertEqual(self.counted(), (0, ['1 passed, 0 failed']))


if __name__ == '__main__':
    unittest.main()
