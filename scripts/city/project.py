# SPDX-License-Identifier: BSD-3-Clause
"""The project file of a city: which drives, with which settings, to which products.

Every mistake is one line that names the key, the value and the remedy (ProjectError).
"""
import glob
import json
import os
import pathlib
import re

import yaml


class ProjectError(Exception):
    """What is wrong with a project file, and its remedy."""


TOPICS = ('points', 'imu', 'velocity', 'gnss')
FORMATS = ('pcd', 'ply', 'png', 'las', 'tiles', 'grid', 'ept', 'web', 'geotiff', 'geojson', 'changes')
STAGES = ('check', 'map', 'pairs', 'loops', 'join', 'products', 'report')
# Threads, memory (MB) and minutes of a job of each stage. Chosen for drives of up to an hour; the memory
# of map and products was measured at 1 to 2 GB for half of that (doc/results/city.md).
RESOURCES = {
    'check': {'threads': 1, 'mem_mb': 1000, 'runtime': 60},
    'map': {'threads': 2, 'mem_mb': 4000, 'runtime': 600},
    'pairs': {'threads': 1, 'mem_mb': 2000, 'runtime': 60},
    'loops': {'threads': 1, 'mem_mb': 2000, 'runtime': 240},
    'join': {'threads': 2, 'mem_mb': 4000, 'runtime': 240},
    'products': {'threads': 2, 'mem_mb': 4000, 'runtime': 600},
    'report': {'threads': 1, 'mem_mb': 1000, 'runtime': 60},
}
# Folders of the output that map_city fills: what else lies in them is replaced or removed.
OWN_FOLDERS = ('jobs', 'drives', 'pairs', 'loops', 'city', 'products')
# One of these is in an output from the first moment on that map_city works there.
MARKS = ('jobs/check', '.lock')
NAMES_FILE = 'jobs/names.json'  # in the output: which names its recordings have got
BAGS = ('.bag', '.db3', '.mcap', '.zstd')  # endings of what check_bag reads, of ROS 1 and 2
NAME = re.compile(r'[A-Za-z0-9_][A-Za-z0-9_.-]*')


def text_of(value):
    return 'nothing' if value is None else repr(value)


class Reader:
    """The values of a mapping of the file; says what is wrong with them."""

    def __init__(self, where, values, keys):
        self.where = where
        if not isinstance(values, dict):
            raise ProjectError(f'{where or "the project file"}: {text_of(values)}: is no list of "key: value"; write '
                               f'one of {", ".join(keys)} to a line')
        self.values = values
        for key in values:
            if key not in keys:
                raise ProjectError(f'{self.path(key)}: {text_of(values[key])}: there is no such key; write one of '
                                   f'{", ".join(keys)}')

    def path(self, key):
        return f'{self.where}.{key}' if self.where else str(key)

    def wrong(self, key, remedy):
        return ProjectError(f'{self.path(key)}: {text_of(self.values.get(key))}: {remedy}')

    def get(self, key, kind, default, remedy):
        """The value of a key if it is of this kind (a type or several), or the default without it."""
        if self.values.get(key) is None:
            return default
        value = self.values[key]
        kinds = kind if isinstance(kind, tuple) else (kind,)
        if isinstance(value, bool) and bool not in kinds or not isinstance(value, kinds):
            raise self.wrong(key, remedy)
        return value

    def number(self, key, default, least, remedy):
        value = self.get(key, (int, float), default, remedy)
        if value is not None and not value >= least:
            raise self.wrong(key, remedy)
        return value

    def part(self, key, keys):
        return Reader(self.path(key), self.values.get(key) or {}, keys)

    def texts(self, key, remedy):
        value = self.get(key, list, [], remedy)
        if not all(isinstance(entry, str) for entry in value):
            raise self.wrong(key, remedy)
        return value


class Drive:
    """A recording with its settings: the name, the files, and the arguments of map_bag."""

    def __init__(self, given_name, paths, settings):
        self.given_name = given_name
        self.name = given_name  # without one, name_drives chooses it
        self.paths = paths
        self.settings = settings

    def possible_names(self):
        """Names that follow from the path: of the file alone, and with its folder before it."""
        name = name_of(self.paths[0])
        return [name, f'{name_of(self.paths[0].parent)}_{name}']

    def recording(self, folder):
        """Which recording this is: its paths as seen from the folder of the project."""
        return '\n'.join(os.path.relpath(path, folder) for path in self.paths)

    def topic_arguments(self):
        return [word for topic, name in sorted(self.settings['topics'].items()) for word in (f'--{topic}', name)]

    def arguments(self, keys):
        words = []
        for key in keys:
            if self.settings[key] is not None:
                words += [f'--{key}', str(self.settings[key])]
        for parameter in self.settings['parameters'] + self.settings['calibration']:
            words += ['--parameter', parameter]
        return words + self.topic_arguments()

    def map_arguments(self):
        """Settings as arguments of map_bag. Those of the calibration come last and win."""
        return self.arguments(('config', 'sensor', 'preset', 'start', 'duration'))

    def check_arguments(self):
        """The same for check_bag, which looks at the whole recording."""
        return self.arguments(('config', 'sensor', 'preset'))

    def is_bags(self):
        """False for a folder of scans, which check_bag cannot read."""
        return all(path.suffix in BAGS or (path.is_dir() and any(file.suffix in BAGS for file in path.iterdir()))
                   for path in self.paths)

    def configuration_files(self):
        """Files whose content decides on the result besides the recording."""
        files = []
        for key in ('config', 'sensor', 'preset'):
            value = self.settings[key]
            if isinstance(value, pathlib.Path):
                files += sorted(value.glob('*.yaml')) if value.is_dir() else [value]
        return files


RECORDING_KEYS = ('path', 'name', 'sensor', 'preset', 'calibration', 'config', 'parameters', 'topics', 'start',
                  'duration')
DEFAULT_KEYS = tuple(key for key in RECORDING_KEYS if key not in ('path', 'name'))


def read_yaml(path, key):
    try:
        return yaml.safe_load(path.read_text())
    except OSError as error:
        raise ProjectError(f'{key}: {str(path)!r}: cannot be read ({error.strerror}); name a file that exists') from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        line = getattr(getattr(error, 'problem_mark', None), 'line', None)
        at = f' in line {line + 1}' if line is not None else ''
        raise ProjectError(f'{key}: {str(path)!r}: is no YAML{at}; write "key: value" lines') from None


class ProjectReader:
    """Reads a project file; paths in it are relative to its folder."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        self.folder = self.path.resolve().parent
        self.top = Reader('', read_yaml(self.path, 'project'),
                          ('recordings', 'defaults', 'output', 'datum', 'config', 'map', 'reports', 'resources'))

    def absolute(self, text):
        return pathlib.Path(os.path.normpath(self.folder / os.path.expanduser(text)))

    def existing(self, reader, key, remedy):
        """A path that has to exist; nothing if the key is not there."""
        text = reader.get(key, str, None, remedy)
        if text is None:
            return None
        path = self.absolute(text)
        if not path.exists():
            raise reader.wrong(key, f'there is no {path}; {remedy}')
        return path

    def overlay(self, reader, key, remedy):
        """A name that map_bag knows, or the path of a file."""
        text = reader.get(key, str, None, remedy)
        if text is None or ('/' not in text and not text.endswith('.yaml')):
            return text
        return self.existing(reader, key, remedy)

    def calibration(self, reader):
        """The values of an overlay file as parameters of map_bag, 'stage/name: value'."""
        path = self.existing(reader, 'calibration', 'name a YAML file of stages and their parameters')
        if path is None:
            return []
        stages = read_yaml(path, reader.path('calibration'))
        if not isinstance(stages, dict) or not all(isinstance(values, dict) for values in stages.values()):
            raise reader.wrong('calibration', f'{path} has to hold "stage:" and below it "name: value"')
        return [f'{stage}/{name}: {yaml.safe_dump(value, default_flow_style=True, width=10000).splitlines()[0]}'
                for stage, values in stages.items() for name, value in values.items()]

    def settings(self, reader, defaults):
        result = {
            'sensor': self.overlay(reader, 'sensor', 'name a sensor of config/sensors or a YAML file'),
            'preset': self.overlay(reader, 'preset', 'name a preset of config/presets or a YAML file'),
            'config': self.existing(reader, 'config', 'name a folder of <stage>.yaml files'),
            'start': reader.number('start', None, 0, 'write seconds to leave out, at least 0'),
            'duration': reader.number('duration', None, 0.001, 'write seconds, more than 0'),
            'parameters': reader.texts('parameters', 'write a list of texts like ["front_end/name: value"]'),
            'calibration': self.calibration(reader),
            'topics': self.topics(reader),
        }
        if defaults is None:
            return result
        return {key: result[key] if result[key] not in (None, [], {}) else defaults[key] for key in result}

    @staticmethod
    def topics(reader):
        part = reader.part('topics', TOPICS)
        return {key: part.get(key, str, None, 'write the name of a topic') for key in part.values}

    def matches(self, reader):
        """The drives of an entry, each a list of its files: one for each match of a pattern."""
        remedy = 'write the path or pattern of bags or folders, or a list of the bags of one drive'
        value = reader.get('path', (str, list), None, remedy)
        if not value or (isinstance(value, list) and not all(isinstance(entry, str) for entry in value)):
            raise reader.wrong('path', remedy)
        if isinstance(value, list):
            paths = [self.absolute(entry) for entry in value]
            missing = [path for path in paths if not path.exists()]
            if missing:
                raise reader.wrong('path', f'there is no {missing[0]}; correct the path or leave it out')
            return [paths]
        found = sorted(glob.glob(str(self.absolute(value))))
        if not found:
            raise reader.wrong('path', 'nothing there matches; correct the path (it is relative to the project file)')
        return [[pathlib.Path(match)] for match in found]

    def drives(self):
        entries = self.top.get('recordings', list, [], 'write a list with "- path: ..." entries')
        if not entries:
            raise self.top.wrong('recordings', 'write a list with "- path: ..." entries')
        defaults = self.settings(self.top.part('defaults', DEFAULT_KEYS), None)
        drives = []
        for number, entry in enumerate(entries):
            reader = Reader(f'recordings[{number}]', entry, RECORDING_KEYS)
            settings = self.settings(reader, defaults)
            matches = self.matches(reader)
            given = reader.get('name', str, None, 'write a word')
            if given is not None and (len(matches) > 1 or not NAME.fullmatch(given)):
                raise reader.wrong('name', 'write one word of letters, digits, "_", "-" or "." for one drive')
            drives += [Drive(given, paths, settings) for paths in matches]
        return drives

    def datum(self):
        remedy = 'write [latitude, longitude, height] in degrees and m'
        value = self.top.get('datum', list, None, remedy)
        if value is None:
            return None
        is_number = [isinstance(v, (int, float)) and not isinstance(v, bool) for v in value]
        if len(value) != 3 or not all(is_number) or abs(value[0]) > 90 or abs(value[1]) > 180:
            raise self.top.wrong('datum', remedy)
        return [float(number) for number in value]

    def map(self):
        part = self.top.part('map', ('formats', 'resolution', 'tile_size'))
        formats = part.get('formats', list, ['tiles', 'png', 'changes'], f'write a list of {", ".join(FORMATS)}')
        if not formats or not all(entry in FORMATS for entry in formats):
            raise part.wrong('formats', f'write a list of {", ".join(FORMATS)}')
        return {'formats': formats,
                'resolution': part.number('resolution', None, 0.001, 'write metres, more than 0'),
                'tile_size': part.number('tile_size', None, 1, 'write metres, at least 1')}

    def resources(self):
        part = self.top.part('resources', STAGES)
        result = {}
        for stage, default in RESOURCES.items():
            given = part.part(stage, tuple(default))
            result[stage] = {key: given.get(key, int, value, 'write a whole number, at least 1')
                             for key, value in default.items()}
            for key, value in result[stage].items():
                if value < 1:
                    raise given.wrong(key, 'write a whole number, at least 1')
        return result

    def output(self):
        """A folder that is new, empty or a city: in any other one, jobs would replace what is not theirs."""
        remedy = 'name a folder that is new or empty, or the output of an earlier map_city'
        path = self.absolute(self.top.get('output', str, 'city', remedy))
        if path.exists() and not path.is_dir():
            raise self.top.wrong('output', f'{path} is no folder; {remedy}')
        if path.is_dir() and any(path.iterdir()) and not any((path / mark).exists() for mark in MARKS):
            raise self.top.wrong('output', f'{path} holds other files; {remedy}')
        return path

    def read(self):
        output, drives = self.output(), self.drives()
        check_places(drives, output)
        name_drives(drives, self.folder, read_names(output), earlier_names(output))
        return Project(self.path.resolve(), output, drives, {
            'datum': self.datum(),
            'config': self.existing(self.top, 'config', 'name a folder with back_end.yaml or loop_closing.yaml'),
            'map': self.map(),
            'reports': self.top.get('reports', bool, True, 'write true or false'),
            'resources': self.resources()})


def check_places(drives, output):
    """Throws for a recording in a folder of the city, whose jobs would remove it, and for one that contains the city
    and would change with every job."""
    own = [output / name for name in OWN_FOLDERS]
    folders = {*own, *(folder.resolve() for folder in own)}
    for path in (path for drive in drives for path in drive.paths):
        if not folders.isdisjoint((path, *path.parents, path.resolve(), *path.resolve().parents)):
            raise ProjectError(f'recordings: {str(path)!r}: lies in the city itself (output: {str(output)!r}), which '
                               'replaces the files there; move it elsewhere, or name another output')
        if path.resolve() in (output.resolve(), *output.resolve().parents):
            raise ProjectError(f'recordings: {str(path)!r}: contains the city itself (output: {str(output)!r}), which '
                               'changes with every job; name the bags in it, or another output')


def name_of(path):
    stem = path.stem if path.suffix == '.bag' else path.name
    name = re.sub(r'[^A-Za-z0-9_.-]+', '_', stem).lstrip('.-')
    return name or 'drive'


def read_names(output):
    """Names that recordings of a city have got before; nothing of a new one."""
    try:
        names = json.loads((output / NAMES_FILE).read_text())
    except (OSError, ValueError):
        return {}
    return names if isinstance(names, dict) else {}


def earlier_names(output):
    """Names of mapped drives, where an older map_city has not written down whose they are: it put the folder's name
    before all that were equal."""
    if (output / NAMES_FILE).exists():
        return set()
    return {path.stem for path in (output / 'jobs/map').glob('*.json')}


def name_drives(drives, folder, names, earlier):
    """Names drives that have no given name. A recording keeps that of `names`, so a new one changes none of a drive
    that is mapped; others get that of their file or, where it is taken, that of their folder before it."""
    check_names(drives, folder)
    taken = {drive.name for drive in drives}
    unnamed = [drive for drive in drives if drive.given_name is None]
    for is_known in (True, False):
        for drive in (drive for drive in unnamed if drive.name is None):
            possible = drive.possible_names()
            if is_known:
                possible = [name for name in reversed(possible)
                            if name == names.get(drive.recording(folder)) or name in earlier]
            drive.name = next((name for name in possible if name not in taken), None)
            taken.add(drive.name)
    nameless = [drive for drive in unnamed if drive.name is None]
    if nameless:
        raise ProjectError(f'recordings: {str(nameless[0].paths[0])!r}: others are called '
                           f'{" and ".join(nameless[0].possible_names())} already; give one of them a "name"')


def check_names(drives, folder):
    """Throws for a name that was given twice, and for a recording that is there twice without one."""
    seen = {}
    for drive in drives:
        key = (drive.given_name, None if drive.given_name else drive.recording(folder))
        if key in seen:
            what = f'is called {key[0]}, like {str(seen[key].paths[0])!r}' if drive.given_name else 'is there twice'
            raise ProjectError(f'recordings: {str(drive.paths[0])!r}: {what}; give one of them another "name"')
        seen[key] = drive


class Project:
    """A project file that was read: drives by name, and what is common to them."""

    def __init__(self, path, output, drives, settings):
        self.path = path
        self.output = output
        self.drives = {drive.name: drive for drive in drives}
        self.settings = settings

    def resources(self, stage):
        return self.settings['resources'][stage]

    def names(self):
        """Chosen names by recording, for NAMES_FILE."""
        return {drive.recording(self.path.parent): drive.name for drive in self.drives.values() if drive.given_name is None}


def read_project(path):
    """Reads and checks a project file. Raises ProjectError."""
    return ProjectReader(path).read()
