# SPDX-License-Identifier: BSD-3-Clause
"""The graph of jobs of a city: what each job needs, what it leaves, and when it is done.

A job leaves jobs/STAGE/NAME.json, its state, when all else that it makes is in place. The state holds a key
made of its settings and of all its inputs; a job whose state has the present key is done and not run again.
The keys alone judge. Snakemake sees only whether jobs/STAGE/NAME.done is there, which holds the key of the
state, so those that the keys contradict are removed before it looks.
"""
import contextlib
import fcntl
import hashlib
import json
import os

from city.project import MARKS, STAGES

# Part of every key; a greater number makes all jobs run again after the jobs themselves have changed.
VERSION = 1
# The name of the job of a stage that has only one.
WHOLE = 'city'


def read_json(path):
    """Content of a JSON file; nothing if it is not there or not whole."""
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError):
        return None


def write_json(path, value):
    """Writes a JSON file that is there as a whole or not at all."""
    part = path.with_name(f'.{path.name}.{os.getpid()}.part')
    part.write_text(json.dumps(value, indent=1) + '\n')
    os.replace(part, path)


def digest(*values):
    return hashlib.sha256(json.dumps(values, sort_keys=True, default=str).encode()).hexdigest()[:32]


def digest_of_file(path):
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()[:32]
    except OSError:
        return None


def identity_of(path):
    """What tells a recording from another version of itself: sizes and times of its files."""
    files = sorted(path.rglob('*')) if path.is_dir() else [path]
    return [(file.name, file.stat().st_size, file.stat().st_mtime_ns) for file in files if file.is_file()]


class City:
    """The folder of a city and its jobs."""

    def __init__(self, project):
        self.project = project
        self.output = project.output

    def make_folder(self):
        """Makes the folder, marked as that of a city."""
        (self.output / MARKS[0]).mkdir(parents=True, exist_ok=True)

    # Where the files are.
    def state_file(self, stage, name):
        return self.output / 'jobs' / stage / f'{name}.json'

    def done_file(self, stage, name):
        return self.output / 'jobs' / stage / f'{name}.done'

    def log_file(self, stage, name):
        return self.output / 'jobs' / stage / f'{name}.log'

    def lock_file(self, stage, name):
        return self.output / 'jobs' / stage / f'{name}.lock'

    def times_file(self, stage, name):
        return self.output / 'jobs' / stage / f'{name}.time'

    def session(self, drive):
        return self.output / 'drives' / drive

    def pieces_file(self, drive):
        return self.output / 'drives' / f'{drive}.pieces.json'

    def chunk_file(self, chunk):
        return self.output / 'pairs' / f'{chunk}.json'

    def loops_file(self, chunk):
        return self.output / 'loops' / f'{chunk}.json'

    @property
    def joined(self):
        return self.output / 'city'

    @property
    def products(self):
        return self.output / 'products'

    # States.
    def state(self, stage, name):
        return read_json(self.state_file(stage, name))

    def result(self, stage, name):
        """'done', 'failed', 'refused' or 'skipped' as the job left it; nothing before it has run."""
        state = self.state(stage, name)
        return state['result'] if state else None

    def is_up_to_date(self, stage, name):
        state = self.state(stage, name)
        return bool(state) and state['key'] == self.key(stage, name)

    def settled(self):
        """Jobs that are up to date, as are all that they need."""
        found = set()
        for job in self.jobs():
            if found.issuperset(self.needed(*job)) and self.is_up_to_date(*job):
                found.add(job)
        return found

    def forget_unsettled(self):
        """Leaves the .done files of settled jobs alone, and none of jobs that there were once."""
        kept = {self.done_file(*job) for job in self.settled()}
        for file in (self.output / 'jobs').glob('*/*.done'):
            if file not in kept:
                file.unlink()

    def is_running(self, stage, name):
        """Whether a process of this machine holds the lock of the job."""
        try:
            with open(self.lock_file(stage, name)) as lock, contextlib.suppress(BlockingIOError):
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return False
            return True
        except OSError:
            return False

    # The graph.
    def mapped(self):
        """Drives that have a session, in the order of the project."""
        return [drive for drive in self.project.drives if self.result('map', drive) == 'done']

    def chunks(self):
        """Chunks of the loop search, as the pairs were found last, but of no drive that has left the project."""
        found = (self.state('pairs', WHOLE) or {}).get('chunks', [])
        return [chunk for chunk in found if self.project.drives.keys() >= set(self.drives_of(chunk))]

    def searched(self):
        """Chunks whose loops are found. Of any other one, there may be loops of an earlier run."""
        return [chunk for chunk in self.chunks() if self.result('loops', chunk) == 'done']

    def drives_of(self, chunk):
        content = read_json(self.chunk_file(chunk)) or {}
        return [content[side] for side in ('a', 'b') if side in content]

    def names(self, stage):
        """Jobs of a stage that are known by now."""
        if stage in ('check', 'map'):
            return list(self.project.drives)
        return self.chunks() if stage == 'loops' else [WHOLE]

    def needed(self, stage, name):
        """Jobs that have to be done before this one, as (stage, name)."""
        if stage == 'check':
            return []
        if stage == 'map':
            return [('check', name)]
        if stage == 'pairs':
            return [('map', drive) for drive in self.project.drives]
        if stage == 'loops':
            return [('pairs', WHOLE)]
        if stage == 'join':
            return [('pairs', WHOLE)] + [('loops', chunk) for chunk in self.chunks()]
        return [(STAGES[STAGES.index(stage) - 1], WHOLE)]

    def jobs(self):
        """All jobs that are known by now, in the order of the stages."""
        return [(stage, name) for stage in STAGES for name in self.names(stage)]

    # Keys.
    def key(self, stage, name):
        """Changes with everything that decides on the result of the job."""
        return digest(VERSION, stage, name, getattr(self, f'_{stage}_inputs')(name))

    def _check_inputs(self, name):
        drive = self.project.drives[name]
        return [drive.check_arguments(), [identity_of(path) for path in drive.paths],
                [digest_of_file(path) for path in drive.configuration_files()]]

    def _map_inputs(self, name):
        drive = self.project.drives[name]
        return [drive.map_arguments(), self.key('check', name), self.result('check', name),
                self.project.settings['reports']]

    def _pairs_inputs(self, _name):
        return [(drive, self.key('map', drive), self.result('map', drive), digest_of_file(self.pieces_file(drive)))
                for drive in self.project.drives]

    def _loops_inputs(self, name):
        return [digest_of_file(self.chunk_file(name)), self._config(),
                [self.key('map', drive) for drive in self.drives_of(name)]]

    def _join_inputs(self, _name):
        return [self.project.settings['datum'], self._config(),
                [(drive, self.key('map', drive)) for drive in self.mapped()],
                [(chunk, digest_of_file(self.loops_file(chunk))) for chunk in self.searched()]]

    def _products_inputs(self, name):
        return [self.project.settings['map'], self.project.settings['reports'], self.key('join', name),
                self.result('join', name)]

    def _report_inputs(self, _name):
        return [(stage, name, (self.state(stage, name) or {}).get('key'), self.result(stage, name))
                for stage, name in self.jobs() if stage != 'report']

    def _config(self):
        folder = self.project.settings['config']
        if folder is None:
            return None
        files = sorted(folder.glob('*.yaml')) if folder.is_dir() else [folder]
        return [(file.name, digest_of_file(file)) for file in files]
