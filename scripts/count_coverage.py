#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Count the lines that gcov saw run, for each stage: its sources, and its headers in include.

usage: count_coverage.py BUILD_FOLDER STAGE ...
"""
import collections
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent


def stage_of(name):
    """The stage of a file of the package, None for any other file."""
    try:
        parts = pathlib.Path(name).resolve().relative_to(ROOT).parts
    except ValueError:
        return None
    if parts[0] == 'src':
        return parts[1]
    return parts[2] if parts[:2] == ('include', 'lidar_mapping') and len(parts) > 3 else None


def reports(build):
    """gcov's report of each object; one that no program has run has notes (.gcno) alone."""
    for notes in sorted(build.rglob('*.gcno')):
        output = subprocess.run(['gcov', '--json-format', '--stdout', str(notes)], cwd=notes.parent,
                                check=True, capture_output=True, text=True).stdout
        yield from map(json.loads, output.splitlines())


def covered_lines(build, stages):
    """stage -> (file, line) -> whether it ran in any of the objects that it was compiled into"""
    lines = collections.defaultdict(dict)
    for report in reports(build):
        folder = pathlib.Path(report['current_working_directory'])
        for file in report['files']:
            name = str(folder / file['file'])
            stage = stage_of(name)
            if stage not in stages:
                continue
            for line in file['lines']:
                key = name, line['line_number']
                lines[stage][key] = lines[stage].get(key, False) or line['count'] > 0
    return lines


def main(build, stages):
    lines = covered_lines(build, stages)
    all_ran, all_lines = 0, 0
    for stage in stages:
        ran, count = sum(lines[stage].values()), len(lines[stage])
        all_ran, all_lines = all_ran + ran, all_lines + count
        print(f'{stage:20} {ran:6} of {count:6} lines, {100 * ran / max(1, count):5.1f} %')
    print(f'coverage: {all_ran} of {all_lines} lines of {len(stages)} stages, {100 * all_ran / max(1, all_lines):.1f} %')
    return 0 if all_lines else 1


if __name__ == '__main__':
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    sys.exit(main(pathlib.Path(sys.argv[1]), sys.argv[2:]))
