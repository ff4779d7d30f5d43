#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Maps projects through the Slurm of SLURM_CONF, see slurm_test: the same bytes as without, also after kills.

usage: check_slurm.py [PROGRAMS]
"""
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import check_three_drives  # noqa: E402
from toy_programs import products_of, write_programs, write_project  # noqa: E402

MAP_CITY = HERE.parents[1] / 'scripts' / 'map_city'
DRIVES = {**{f'd{number}': f'good {number}' for number in range(5)}, 'empty': 'empty'}
KILLS = 5


def words(project, programs, *options):
    return ['/usr/bin/python3', str(MAP_CITY), str(project), '--programs', str(programs), *map(str, options)]


def run(project, programs, *options):
    """Maps the city; one recording is bad."""
    done = subprocess.run(words(project, programs, *options), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != check_three_drives.INCOMPLETE:
        sys.exit(f'status {done.returncode} of {options}\n{done.stdout}')


def slurm_jobs():
    said = subprocess.run(['squeue', '--noheader', '--format', '%i'], capture_output=True, text=True, check=True).stdout
    return said.split()


def kill_something(project, programs, generator):
    """Starts the work through Slurm and kills the engine, a job or, by Slurm, all jobs."""
    engine = subprocess.Popen(words(project, programs, '--cluster', 'slurm', '--jobs', 4), stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, start_new_session=True)
    time.sleep(generator.uniform(5, 15))
    what = generator.choice(('engine', 'jobs', 'both'))
    if what != 'engine':
        for job in slurm_jobs():
            subprocess.run(['scancel', '--signal=KILL', '--full', job], check=False)
    if what != 'jobs':
        os.killpg(engine.pid, signal.SIGKILL)
    status = engine.wait()
    print(f'killed: {what} (status {status})', flush=True)
    while slurm_jobs():
        time.sleep(0.5)


def check_toys(folder):
    os.environ['TOY_LOG'] = str(folder / 'log')
    os.environ['TOY_SECONDS'] = '0.5'
    programs = write_programs(folder / 'programs')
    local, cluster, killed = (write_project(folder / name, DRIVES) for name in ('local', 'cluster', 'killed'))
    run(local, programs, '--local')
    expected = products_of(folder / 'local/out')
    run(cluster, programs, '--cluster', 'slurm', '--jobs', 4)
    check_three_drives.compare(expected, products_of(folder / 'cluster/out'), 'through Slurm')
    generator = random.Random(2)
    for _ in range(KILLS):
        kill_something(killed, programs, generator)
    run(killed, programs, '--cluster', 'slurm', '--jobs', 4)
    check_three_drives.compare(expected, products_of(folder / 'killed/out'), 'after kills')


def check_drives(folder, programs):
    folder.mkdir()
    check_three_drives.simulate(programs, folder)
    one = check_three_drives.map_city(programs, folder, 'one', '--local')
    by_slurm = check_three_drives.map_city(programs, folder, 'slurm', '--cluster', 'slurm', '--jobs', '2')
    check_three_drives.compare(one, by_slurm, 'three drives through Slurm')


def main():
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        check_toys(folder)
        if len(sys.argv) > 1:
            check_drives(folder / 'drives', pathlib.Path(sys.argv[1]).resolve())
    print('Slurm: the same bytes')


if __name__ == '__main__':
    main()
