#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Count the test cases in catkin's result files; say which failed and why; end with 'N passed, N failed'.

usage: count_tests.py RESULT_FOLDER [LOG ...]

LOG is the output of the tests: the lines of a failed test that it holds are shown, also those
of programs that the test started. Of a test that no LOG has the text of the failure is shown.
"""
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

SHOWN_LINES = 40  # per failed test, its last ones: with more the names of several no longer fit on a screen


def lines_in_log(name, log):
    """What lies between the lines of googletest that begin and end the failed test."""
    lines = []
    begun = False
    for line in log:
        if line.startswith('[ RUN ') and line.split()[-1] == name:
            lines, begun = [], True
        elif begun and line.startswith(f'[  FAILED  ] {name}'):
            return lines
        elif begun:
            lines.append(line)
    return []


def reason(name, case, logs):
    for log in logs:
        lines = lines_in_log(name, log)
        if lines:
            return lines
    return [line for kind in ('failure', 'error') for found in case.iter(kind)
            for line in (found.text or found.get('message') or '').splitlines()]


def main(folder, log_files):
    logs = [pathlib.Path(file).read_text(errors='replace').splitlines() for file in log_files]
    passed, failed, skipped = 0, {}, []
    for path in sorted(pathlib.Path(folder).rglob('*.xml')):
        for case in ElementTree.parse(path).iter('testcase'):
            name = f"{case.get('classname', path.stem)}.{case.get('name')}"
            if case.find('failure') is not None or case.find('error') is not None:
                failed[name] = reason(name, case, logs)
            elif path.name.startswith('rostest-'):
                continue  # the wrapper around the cases in rosunit-*.xml
            elif case.find('skipped') is not None or case.get('status') == 'notrun':
                skipped.append(name)
            else:
                passed += 1
    for name in skipped:
        print(f'skipped: {name}')
    for name, lines in failed.items():
        print(f'failed: {name}')
        for line in lines[-SHOWN_LINES:]:
            print(f'    {line}')
    print(f'{passed} passed, {len(failed)} failed'
          + (f', {len(skipped)} skipped' if skipped else ''))
    return 1 if failed or passed == 0 else 0


if __name__ == '__main__':
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], sys.argv[2:]))
