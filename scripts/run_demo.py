#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Simulate a drive, map it with the nodes while rosbag plays it, judge the map, and find another drive in it.

The package must be built and its setup sourced; scripts/demo does both.
"""
import argparse
import contextlib
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import time

import yaml

import second_drive

ROOT = pathlib.Path(__file__).resolve().parent.parent
PACKAGE = 'lidar_mapping'
# The graph is solved again from the session with other constraints: name, GNSS, loops.
VARIANTS = (('odometry', False, False), ('loops', False, True), ('gnss_loops', True, True))


def say(text):
    print(f'\n== {text}', flush=True)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--drive', default='town')
    parser.add_argument('--lidar', default='hdl64')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--duration', type=float, help='seconds of the drive; default: all of it')
    parser.add_argument('--rate', type=float, default=1.0, help='speed of playing')
    parser.add_argument('--output', type=pathlib.Path, default=ROOT / 'demo')
    parser.add_argument('--keep-bag', action='store_true', help='use a bag that is there already')
    return parser.parse_args()


def run(*command, statuses=(0,), **options):
    """Run a command, with its output shown; stop the demo if it fails."""
    result = subprocess.run([str(word) for word in command], **options)
    if result.returncode not in statuses:
        sys.exit(f'demo: failed with status {result.returncode}: '
                 + ' '.join(str(word) for word in command))
    return result


def rosrun(program, *words, **options):
    return run('rosrun', PACKAGE, program, *words, **options)


def free_port():
    with contextlib.closing(socket.socket()) as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]


def simulate(options, bag, truth):
    if options.keep_bag and bag.exists() and truth.exists():
        return
    say(f'Simulating the drive {options.drive} with {options.lidar}')
    words = ['--drive', options.drive, '--lidar', options.lidar, '--seed', options.seed,
             '--truth', truth]
    if options.duration:
        words += ['--duration', options.duration]
    rosrun('simulate_drive', bag, '--force', *words)


@contextlib.contextmanager
def nodes(sessions, log):
    """The running nodes, with a master of their own."""
    port = free_port()
    os.environ['ROS_MASTER_URI'] = f'http://127.0.0.1:{port}'
    with_rviz = 'true' if os.environ.get('DISPLAY') else 'false'
    with open(log, 'w') as file:
        process = subprocess.Popen(
            ['roslaunch', '-p', str(port), PACKAGE, 'demo.launch', f'rviz:={with_rviz}',
             f'session_directory:={sessions}'],
            stdout=file, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        try:
            wait_for_services(process, log, '/optimize_map', '/save_map')
            yield process
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(timeout=90)


def wait_for_services(process, log, *names):
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and process.poll() is None:
        listed = subprocess.run(['rosservice', 'list'], capture_output=True, text=True).stdout
        if set(names) <= set(listed.split()):
            return
        time.sleep(0.5)
    sys.exit(f'demo: the nodes did not start; their output: {log}')


def call(service, request='{}'):
    answer = run('rosservice', 'call', service, request, capture_output=True, text=True).stdout
    values = yaml.safe_load(answer)
    if not values['success']:
        sys.exit(f"demo: {service} failed: {values['message']}")
    print(f"{service}: {values['message']}")
    return values


def query(session, sql):
    with contextlib.closing(sqlite3.connect(f'file:{session}/session.db?mode=ro', uri=True)) as db:
        return db.execute(sql).fetchone()[0]


def wait_until_idle(session):
    """Wait until no scan has come to the session for some seconds."""
    last, since = -1, time.monotonic()
    while time.monotonic() - since < 4.0:
        scans = query(session, 'SELECT COUNT(*) FROM scans')
        if scans != last:
            last, since = scans, time.monotonic()
        time.sleep(0.5)


def play(bag, rate, log):
    """Play the bag; on a terminal say how far it is."""
    with open(log, 'w') as file, subprocess.Popen(
            ['rosbag', 'play', '--clock', '-d', '3', '-r', str(rate), str(bag)], text=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as process:
        for line in process.stdout:  # it ends its lines with a carriage return
            file.write(line)
            played = re.search(r'Duration: ([\d.]+) / ([\d.]+)', line)
            if played and sys.stdout.isatty():
                print(f'\r{float(played[1]):.0f} of {float(played[2]):.0f} s', end='', flush=True)
        if sys.stdout.isatty():
            print('\r\033[K', end='')
    if process.returncode != 0:
        sys.exit(f'demo: rosbag play failed with status {process.returncode}; its output: {log}')


def scans_in(bag):
    topics = yaml.safe_load(run('rosbag', 'info', '-y', '-k', 'topics', bag,
                                capture_output=True, text=True).stdout)
    return next(topic['messages'] for topic in topics if topic['type'] == 'sensor_msgs/PointCloud2')


def map_drive(options, bag, sessions, log):
    """Play the bag to the nodes; return the session's folder and the answer of /save_map."""
    if options.rate != 1.0:
        say(f'Note: the bag is played at {options.rate} times the real speed')
    with nodes(sessions, log):
        say('Playing the bag to the nodes')
        play(bag, options.rate, log.with_name('play.log'))
        session = (sessions / 'latest').resolve()
        wait_until_idle(session)
        say('Optimising and saving the map')
        call('/optimize_map')
        saved = call('/save_map', '{directory: "", resolution: 0.0, formats: []}')
    return session, saved


def evaluate(session, truth, variants):
    """Solve the graph again for each variant; return its errors against the truth."""
    errors = {}
    for name, gnss, loops in VARIANTS:
        folder = variants / name
        rosrun('optimize_session', session, '--use-gnss', str(gnss).lower(), '--use-loops',
               str(loops).lower(), '--output', folder, stdout=subprocess.DEVNULL)
        figures = folder / 'errors.json'
        rosrun('evaluate_trajectory', truth, folder / 'trajectory' / 'optimized.tum', '--align', '--json', figures,
               '--plot', folder / 'trajectory.png', stdout=subprocess.DEVNULL)
        errors[name] = json.loads(figures.read_text())
    return errors


def map_again(bag, folder, played):
    """Map the same bag in one process; return the times that it reports."""
    say('Mapping the same bag without waiting')
    shutil.rmtree(folder, ignore_errors=True)
    figures = folder.with_suffix('.json')
    rosrun('map_bag', bag, '-o', folder, '--formats', 'pcd', '--figures', figures)
    times = json.loads(figures.read_text())
    print(f"nodes, with the bag played: {played:.0f} s; map_bag: {times['seconds']['mapping']:.0f} s, "
          f"with the map {times['seconds']['whole']:.0f} s")
    return times


def make_page(session):
    """The map for a browser; None without three.js, which is optional."""
    result = subprocess.run(['rosrun', PACKAGE, 'build_map', str(session), '--formats', 'web'],
                            capture_output=True, text=True)
    if result.returncode == 0:
        return session / 'map' / 'ept' / 'index.html'
    print(result.stderr.strip())
    if 'libjs-three' not in result.stderr:
        sys.exit('demo: the page for a browser failed')
    return None


def print_table(errors):
    print(f"\n{'':28}{'APE RMSE':>10}{'APE max':>10}{'drift':>10}{'rotation':>16}")
    for name, title in (('odometry', 'odometry'), ('loops', 'loops, without GNSS'),
                        ('gnss_loops', 'loops and GNSS')):
        ape, kitti = errors[name]['ape']['translation_m'], errors[name]['kitti']
        drift = (f"{kitti['translation_percent']:8.3f} %{kitti['rotation_deg_per_100m']:8.3f} deg/100m"
                 if kitti['segments'] else '  (the path is shorter than a segment)')
        print(f"{title:28}{ape['rmse']:8.3f} m{ape['max']:8.3f} m{drift}")


def print_localization(figures):
    seconds = figures['localization_found_after_seconds']
    if seconds is None:
        print('The drive of another day was not found in the map')
        return
    print(f"The drive of another day was found after {seconds:.1f} s; {figures['localization_scans_followed']} of "
          f"{figures['localization_scans']} scans followed, {1000 * figures['localization_rmse']:.0f} mm RMSE")


def cloud_of(saved, format_):
    """The map as a file of a format: 'pcd', 'ply'."""
    return next(name for name in saved['files'] if name.endswith(f'.{format_}'))


def points_in(saved):
    """The number of points in a PCD file's header."""
    with open(cloud_of(saved, 'pcd'), 'rb') as file:
        header = file.read(4096).decode('ascii', 'replace')
    return int(re.search(r'^POINTS (\d+)', header, re.MULTILINE).group(1))


def main():
    started = time.monotonic()
    options = arguments()
    demo = options.output.resolve()
    demo.mkdir(parents=True, exist_ok=True)
    bag, truth = demo / 'drive.bag', demo / 'ground_truth.tum'
    sessions, variants = demo / 'sessions', demo / 'variants'
    os.environ.setdefault('ROS_LOG_DIR', str(demo / 'logs'))

    simulate(options, bag, truth)
    begin = time.monotonic()
    session, saved = map_drive(options, bag, sessions, demo / 'nodes.log')
    again = map_again(bag, demo / 'map_bag', time.monotonic() - begin)
    say('Evaluating against the ground truth')
    errors = evaluate(session, truth, variants)
    shutil.copy(variants / 'gnss_loops' / 'trajectory.png', demo / 'trajectory.png')
    rosrun('build_map', session, '--formats', 'png', '--output', demo, stdout=subprocess.DEVNULL)

    page = make_page(session)

    say('Judging the map')
    rosrun('map_quality', session, '--report', '--truth', truth, '--places', 5)
    run(ROOT / 'scripts' / 'plot_loops.py', session / 'report.json', demo / 'loops.png')

    say('Another day: a drive finds itself in the map')
    localized = second_drive.localize(options, session, truth, demo, rosrun)
    run(ROOT / 'scripts' / 'plot_localization.py', cloud_of(saved, 'ply'), demo / 'another_day' / 'localization.csv',
        demo / 'another_day.tum', truth, session / 'trajectory' / 'optimized.tum', demo / 'localization.png')

    scans = scans_in(bag)
    summary = {f'{name}_ape_rmse': errors[name]['ape']['translation_m']['rmse']
               for name, _, _ in VARIANTS}
    summary.update({
        'scans': scans,
        'scans_dropped': scans - query(session, 'SELECT COUNT(*) FROM scans'),
        'key_frames': query(session, 'SELECT COUNT(*) FROM key_frames'),
        'loop_constraints': query(session, 'SELECT loops_used FROM revisions '
                                           'ORDER BY revision DESC LIMIT 1'),
        'map_points': points_in(saved),
        'map_bag_seconds': again['seconds']['mapping'],
        'map_bag_times_real_time': again['times_real_time']['mapping'],
        'seconds': round(time.monotonic() - started, 1),
        **localized,
    })
    (demo / 'summary.json').write_text(json.dumps(summary, indent=2) + '\n')

    print_table(errors)
    print(f"\n{summary['scans']} scans, {summary['scans_dropped']} dropped, "
          f"{summary['key_frames']} key frames, {summary['loop_constraints']} loops, "
          f"{summary['map_points']} points in the map, {summary['seconds']:.0f} s")
    print_localization(localized)
    for title, path in [('session', session), ('report', session / 'report.html'),
                        ('trajectory plot', demo / 'trajectory.png'),
                        ('loops plot', demo / 'loops.png'),
                        ('another day', demo / 'localization.png'),
                        ('view from above', demo / 'top_view.png'), ('figures', demo / 'summary.json')] + [
                            ('map', path) for path in saved['files']] + ([('browser page', page)] if page else []):
        print(f'{title + ":":18}{path}')


if __name__ == '__main__':
    main()
