#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Maps three simulated drives of one town and a bag that is none as a city, with one job and with two, and
through Snakemake where that is installed: the same bytes, errors against the truth, the bad bag is named.

usage: check_three_drives.py PROGRAMS
"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from toy_programs import products_of as all_files_of  # noqa: E402

MAP_CITY = HERE.parents[1] / 'scripts' / 'map_city'
# Name, begin and end of the drive in the town (s), day. They are too short to be joined without GNSS.
DRIVES = (('monday', 0, 12, 0), ('tuesday', 4, 16, 1), ('wednesday', 2, 14, 2))
LARGEST_ERROR = 0.15  # m, RMSE after alignment
INCOMPLETE = 4


def run(*words, good=(0,)):
    done = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode not in good:
        sys.exit(f'status {done.returncode}: {" ".join(map(str, words))}\n{done.stdout}')
    return done.stdout


def simulate(programs, folder):
    for name, begin, end, day in DRIVES:
        run(programs / 'simulate_drive', folder / f'{name}.bag', '--lidar', 'vlp16', '--seed', 13, '--pass', day, '--start',
            begin, '--duration', end, '--truth', folder / f'{name}.tum')
    (folder / 'broken.bag').write_text('this is no bag')


def map_city(programs, folder, name, *options):
    """Maps the drives; the files that have to be the same however that is done."""
    project = folder / f'{name}.yaml'
    project.write_text(f'output: {name}\ndefaults: {{sensor: vlp16}}\nreports: false\nmap: {{formats: [pcd]}}\n'
                       'recordings:\n  - path: "*.bag"\n')
    said = run('/usr/bin/python3', MAP_CITY, project, '--programs', programs, *options, good=(INCOMPLETE,))
    if 'broken: refused' not in said:
        sys.exit(f'the broken bag is not named:\n{said}')
    return products_of(folder / name)


def products_of(output):
    """What follows from the recordings alone. Databases and run.json also hold when and how long."""
    return {name: content for name, content in all_files_of(output).items()
            if not name.endswith(('.db', 'run.json', 'lock')) and '.db-' not in name}


def compare(one, other, what):
    different = sorted(name for name in {*one, *other} if one.get(name) != other.get(name))
    if different:
        sys.exit(f'{what}: {len(different)} of {len(one)} files differ: {", ".join(different[:10])}')


def check_errors(programs, folder, output):
    for name, *_ in DRIVES:
        errors = folder / f'{name}.errors.json'
        run(programs / 'evaluate_trajectory', folder / f'{name}.tum', output / 'city/drives' / f'{name}.tum', '--align', '--json',
            errors)
        rmse = json.loads(errors.read_text())['ape']['translation_m']['rmse']
        print(f'{name}: {1000 * rmse:.0f} mm')
        if not rmse < LARGEST_ERROR:
            sys.exit(f'{name} is wrong by {rmse} m')


def main():
    programs = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        simulate(programs, folder)
        one = map_city(programs, folder, 'one', '--local')
        compare(one, map_city(programs, folder, 'two', '--local', '--jobs', 2), 'with two jobs')
        if shutil.which('snakemake'):
            compare(one, map_city(programs, folder, 'engine', '--jobs', 2), 'through Snakemake')
        check_errors(programs, folder, folder / 'one')
        drives = json.loads((folder / 'one/report.json').read_text())['drives']
        results = {drive['name']: drive['result'] for drive in drives}
        if results != {'broken': 'refused', 'monday': 'joined', 'tuesday': 'joined', 'wednesday': 'joined'}:
            sys.exit(f'not what was expected: {results}')


if __name__ == '__main__':
    main()
