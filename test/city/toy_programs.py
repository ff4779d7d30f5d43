# SPDX-License-Identifier: BSD-3-Clause
"""Commands with the interface of the package's that take no time, for tests of the engine.

A recording is a text file: "good", "empty" or "corrupt"; other words are instructions, see PROGRAM.
"""
import pathlib

PROGRAM = '''#!/usr/bin/python3 -IS
import os, pathlib, signal, sys, time
program, words = pathlib.Path(sys.argv[0]).name, sys.argv[1:]
def value(name):
    return pathlib.Path(words[words.index(name) + 1])
def text(*paths):
    return ' '.join(sorted(pathlib.Path(path).read_text().strip() for path in paths))
with open(os.environ['TOY_LOG'], 'a') as log:
    log.write(' '.join([program] + words) + chr(10))
time.sleep(float(os.environ.get('TOY_SECONDS', '0')))
if os.environ.get('TOY_FAILS') in (program, words[0]):
    sys.exit(program + ': the disk is full')
if program == 'check_bag':
    if 'unreadable' in text(words[0]):
        print('check_bag: this is no bag; record it again')
        sys.exit(2)
    if 'faulty' in text(words[0]):
        print('points    /points: 10 Hz')
        for sensor in ('imu', 'gnss'):
            print(f'{sensor:<10}/{sensor}: 100 Hz')
            for number in range(3):
                print(f'  FAULT   {sensor} {number} is wrong' + chr(10) + f'           remedy: mend {number}')
        print('velocity  /velocity: 100 Hz')
        sys.exit(1)
elif program == 'map_bag':
    content = text(words[0])
    if 'empty' in content:
        sys.exit('map_bag: no scan could be used, so there is no map')
    if 'crash' in content:
        os.kill(os.getpid(), signal.SIGSEGV)
    if 'killed' in content:
        os.kill(os.getpid(), signal.SIGKILL)
    session = value('-o')
    session.mkdir()
    (session / 'session').write_text(content + ' ' + ' '.join(words[words.index('-o') + 2:]))
    sys.exit(4 if 'doubtful' in content else 0)
elif program == 'map_quality':
    (pathlib.Path(words[0]) / 'report.html').write_text('report')
elif words[0] == 'describe':
    value('-o').write_text(text(pathlib.Path(words[1]) / 'session'))
elif words[0] == 'pairs':
    drives = [pathlib.Path(word).name.split('.')[0] for word in words[1:words.index('-o')]]
    for a, b in zip(drives, drives[1:]):
        (value('-o') / f'{a}--{b}--000.json').write_text(f'{{"a": "{a}", "b": "{b}"}}')
elif words[0] == 'loops':
    value('-o').parent.mkdir(exist_ok=True)
    value('-o').write_text(text(words[1]))
elif words[0] == 'graph':
    city = value('-o')
    sessions = [pathlib.Path(word) for word in words[1:words.index('--loops')]]
    (city / 'drives').mkdir(parents=True)
    loops = text(*value('--loops').glob('*.json'))
    (city / 'graph').write_text(text(*(session / 'session' for session in sessions)) + loops)
    drives = []
    for number, session in enumerate(sessions):
        (city / 'drives' / (session.name + '.tum')).write_text(f'0 {number} 0 0 0 0 0 1' + chr(10) + f'1 {number} 9 0 0 0 0 1')
        drives.append('{"name": "%s", "state": "joined", "notices": [], "key_frames": 2, "key_frames_left_out": 0, '
                      '"loops_used": 1, "loops_refused": 0, "has_gnss": true, "uses_gnss": true}' % session.name)
    (city / 'city.json').write_text('{"datum": null, "loops_between_drives": 1, "drives": [%s]}' % ', '.join(drives))
elif program == 'build_map':
    value('-o').mkdir()
    (value('-o') / 'map.png').write_text(text(pathlib.Path(words[0]) / 'graph'))
'''
NAMES = ('check_bag', 'map_bag', 'map_quality', 'join_drives', 'build_map')


def write_programs(folder):
    folder.mkdir(parents=True)
    for name in NAMES:
        # build_map has no sub-commands: its first word is the session.
        text = PROGRAM.replace("elif words[0] == 'describe'", "elif program != 'build_map' and words[0] == 'describe'")
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    return folder


def write_project(folder, recordings, more=''):
    """A project with these recordings, given by their name and content."""
    (folder / 'bags').mkdir(parents=True, exist_ok=True)
    for name, content in recordings.items():
        bag = folder / 'bags' / f'{name}.bag'
        if not bag.exists() or bag.read_text() != content:
            bag.write_text(content)
    project = folder / 'project.yaml'
    project.write_text(f'recordings:\n  - path: bags/*.bag\noutput: out\n{more}')
    return project


def products_of(output):
    """Content of all files that have to be the same for the same recordings."""
    found = {}
    for folder in ('drives', 'pairs', 'loops', 'city', 'products'):
        for path in sorted((pathlib.Path(output) / folder).rglob('*')):
            if path.is_file():
                found[str(path.relative_to(output))] = path.read_bytes()
    found['report.json'] = (pathlib.Path(output) / 'report.json').read_bytes()
    return found
