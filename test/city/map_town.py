#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Simulates drives through parts of one town on different days, with different sensors and some of them bad, maps
them with map_city, and prints the table of doc/results/city.md.

usage: map_town.py PROGRAMS FOLDER [--jobs N] [--seed N] [--cluster WHAT]
Recordings that are in FOLDER already are used again.
"""
import argparse
import json
import pathlib
import subprocess
import sys

sys.dont_write_bytecode = True
MAP_CITY = pathlib.Path(__file__).resolve().parents[2] / 'scripts' / 'map_city'
# Name: sensor, begin and end in the town's drive (s), further options. The day is the place in this list.
DRIVES = {
    'north': ('vlp16', 0, 40, ()),
    'north_again': ('vlp16', 15, 55, ()),
    'east': ('os1_64', 45, 75, ()),
    'east_no_gnss': ('vlp16', 50, 90, ('--no-gnss',)),
    'south': ('vlp16', 80, 110, ()),
    'south_noisy': ('vlp16', 85, 115, ('--gnss-noise', '0.5')),
    'west': ('vlp16', 105, 135, ()),
    # GNSS lies 30 m beside the truth all the time.
    'wrong_gnss': ('vlp16', 15, 45, tuple(word for t in range(0, 60, 10) for word in ('--gnss-jump', f'{t}:30'))),
    # So few points that the odometry is lost.
    'lost': ('vlp16', 60, 85, ('--fault', 'sparse=250', '--no-gnss', '--no-imu', '--no-velocity')),
}


def run(*words, good=(0,)):
    done = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode not in good:
        sys.exit(f'status {done.returncode}: {" ".join(map(str, words))}\n{done.stdout}')
    return done.stdout


def simulate(programs, folder, seed):
    folder.mkdir(parents=True, exist_ok=True)
    for day, (name, (lidar, begin, end, more)) in enumerate(DRIVES.items()):
        if not (folder / f'{name}.bag').exists():
            run(programs / 'simulate_drive', folder / 'part', '--lidar', lidar, '--seed', seed, '--pass', day, '--start', begin,
                '--duration', end, '--truth', folder / f'{name}.tum', '--force', *more)
            (folder / 'part').rename(folder / f'{name}.bag')
    whole = (folder / 'north.bag').read_bytes()
    (folder / 'corrupt.bag').write_bytes(whole[:len(whole) // 3])
    (folder / 'empty.bag').write_bytes(b'')


def write_project(folder):
    entries = [f'  - {{path: {name}.bag' + (f', sensor: {lidar}' if lidar == 'vlp16' else '') + '}'
               for name, (lidar, *_) in DRIVES.items()]
    entries += ['  - {path: corrupt.bag}', '  - {path: empty.bag}']
    project = folder / 'town.yaml'
    project.write_text('output: city\nmap: {formats: [tiles, png]}\nreports: false\nrecordings:\n' + '\n'.join(entries) + '\n')
    return project


def error_of(programs, folder, name, trajectory, *options):
    """RMSE of the position, m; nothing without a trajectory."""
    if not trajectory.exists():
        return None
    figures = folder / 'errors.json'
    figures.unlink(missing_ok=True)
    run(programs / 'evaluate_trajectory', folder / f'{name}.tum', trajectory, '--json', figures, *options)
    return json.loads(figures.read_text())['ape']['translation_m']['rmse']


def millimetres(value):
    return '' if value is None else f'{1000 * value:.0f}'


def errors_in_one_frame(folder):
    """RMSE of the position of each drive of the city, m, with one alignment for all of them together."""
    import numpy as np

    pairs = {}
    for name in DRIVES:
        path = folder / 'city/city/drives' / f'{name}.tum'
        if path.exists():
            truth, estimate = np.loadtxt(folder / f'{name}.tum'), np.loadtxt(path)
            nearest = np.abs(truth[:, :1] - estimate[:, 0]).argmin(axis=0)
            pairs[name] = (estimate[:, 1:4], truth[nearest, 1:4])
    estimates, truths = (np.vstack([pair[side] for pair in pairs.values()]) for side in (0, 1))
    centre, true_centre = estimates.mean(axis=0), truths.mean(axis=0)
    u, _, vt = np.linalg.svd((truths - true_centre).T @ (estimates - centre))
    rotation = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return {name: float(np.sqrt((((estimate - centre) @ rotation.T + true_centre - truth) ** 2).sum(axis=1).mean()))
            for name, (estimate, truth) in pairs.items()}


def print_drives(programs, folder):
    output = folder / 'city'
    placed = errors_in_one_frame(folder)
    print('| drive | result | alone, mm | in the city, mm | beside all others, mm | loops used, refused |')
    print('|---|---|---|---|---|---|')
    for drive in json.loads((output / 'report.json').read_text())['drives']:
        name = drive['name']
        joined = output / 'city/drives' / f'{name}.tum'
        alone = error_of(programs, folder, name, output / 'drives' / name / 'trajectory/optimized.tum', '--align')
        together = error_of(programs, folder, name, joined, '--align')
        loops = f'{drive["loops_used"]}, {drive["loops_refused"]}' if 'loops_used' in drive else ''
        print(f'| `{name}` | {drive["result"]} | {millimetres(alone)} | {millimetres(together)} | {millimetres(placed.get(name))} | '
              f'{loops} |')
        for reason in drive['reasons']:
            print(f'  {reason}')


def false_loops(folder):
    """Number of loops between drives, and of those that are wrong by more than 1 m or 5 degrees."""
    import numpy as np

    def pose(numbers):
        x, y, z, qx, qy, qz, qw = numbers
        matrix = np.eye(4)
        matrix[:3, :3] = [[1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qz * qw), 2 * (qx * qz + qy * qw)],
                          [2 * (qx * qy + qz * qw), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qx * qw)],
                          [2 * (qx * qz - qy * qw), 2 * (qy * qz + qx * qw), 1 - 2 * (qx * qx + qy * qy)]]
        matrix[:3, 3] = x, y, z
        return matrix

    def truth_of(name):
        rows = np.loadtxt(folder / f'{name}.tum')
        return rows[:, 0], rows[:, 1:]

    def key_frame_stamps(name):
        return np.loadtxt(folder / 'city/drives' / name / 'trajectory/laser_odom.tum')[:, 0]

    count = wrong = 0
    for path in sorted((folder / 'city/loops').glob('*.json')):
        pair = json.loads(path.read_text())
        sides = {side: (truth_of(pair[side]), key_frame_stamps(pair[side])) for side in ('a', 'b')}

        def true_pose(side, index):
            (stamps, poses), own = sides[side]
            return pose(poses[np.argmin(np.abs(stamps - own[index]))])
        for loop in pair['loops']:
            expected = np.linalg.inv(true_pose('a', loop['from'])) @ true_pose('b', loop['to'])
            error = np.linalg.inv(expected) @ pose(loop['T_from_to'])
            angle = np.degrees(np.arccos(np.clip((np.trace(error[:3, :3]) - 1) / 2, -1, 1)))
            count += 1
            wrong += bool(np.linalg.norm(error[:3, 3]) > 1.0 or angle > 5.0)
    return count, wrong


def print_stages(output):
    print('\n| stage | jobs | seconds | processor seconds | largest memory, MB |\n|---|---|---|---|---|')
    for stage in ('check', 'map', 'pairs', 'loops', 'join', 'products', 'report'):
        times = [json.loads(path.read_text()) for path in sorted((output / 'jobs' / stage).glob('*.time'))]
        if times:
            print(f'| {stage} | {len(times)} | {sum(t["seconds"] for t in times):.0f} | '
                  f'{sum(t["processor_seconds"] for t in times):.0f} | {max(t["memory_mb"] for t in times)} |')


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('programs', type=pathlib.Path)
    parser.add_argument('folder', type=pathlib.Path)
    parser.add_argument('--jobs', default='1')
    parser.add_argument('--seed', default='13')
    parser.add_argument('--cluster')
    options = parser.parse_args()
    programs = options.programs.resolve()
    simulate(programs, options.folder, options.seed)
    engine = ['--cluster', options.cluster] if options.cluster else ['--local']
    print(run('/usr/bin/python3', MAP_CITY, write_project(options.folder), '--programs', programs, '--jobs', options.jobs,
              *engine, good=(0, 4)))
    print_drives(programs, options.folder)
    count, wrong = false_loops(options.folder)
    print(f'\nloops between drives: {count}, wrong by more than 1 m or 5 degrees: {wrong}')
    print_stages(options.folder / 'city')


if __name__ == '__main__':
    main()
