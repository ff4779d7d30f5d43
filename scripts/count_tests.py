#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Count the test cases in catkin's result files; say which failed; end with 'N passed, N failed'.

usage: count_tests.py RESULT_FOLDER
"""
import pathlib
import sys
import xml.etree.ElementTree as ElementTree


def main(folder):
    passed, failed, skipped = 0, [], []
    for path in sorted(pathlib.Path(folder).rglob('*.xml')):
        for case in ElementTree.parse(path).iter('testcase'):
            name = f"{case.get('classname', path.stem)}.{case.get('name')}"
            if case.find('failure') is not None or case.find('error') is not None:
                failed.append(name)
            elif path.name.startswith('rostest-'):
                continue  # the wrapper around the cases in rosunit-*.xml
            elif case.find('skipped') is not None or case.get('status') == 'notrun':
                skipped.append(name)
            else:
                passed += 1
    for name in skipped:
        print(f'skipped: {name}')
    for name in failed:
        print(f'failed: {name}')
    print(f'{passed} passed, {len(failed)} failed'
          + (f', {len(skipped)} skipped' if skipped else ''))
    return 1 if failed or passed == 0 else 0


if __name__ == '__main__':
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1]))
