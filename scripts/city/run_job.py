# SPDX-License-Identifier: BSD-3-Clause
"""One job of a city: runs the command of its stage, moves its result into place, writes its state.

Whatever ends a job early leaves nothing that looks finished: results are made aside (in a folder that is
called .part, or by the commands themselves) and moved when they are whole, and the state comes last.
"""
import contextlib
import fcntl
import os
import re
import resource
import shutil
import signal
import socket
import subprocess
import time

from city import report
from city.jobs import WHOLE, write_json

# Signals that end a job from outside. They say nothing about its recording, so the job has no result and is
# run again; any other signal is a crash by what is in the recording.
FROM_OUTSIDE = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGXCPU)
LAST_LINES = 8  # of the log, in the state and the report of a job that failed
UNREADABLE = 2  # exit status of check_bag
STOPPED = (3, 130)  # exit status of map_bag and of shells: ended by Ctrl-C
DOUBTFUL = 4  # exit status of map_bag: parts of the map cannot be trusted
FAULT = re.compile(r'\s+(FAULT|WARNING|remedy:) ')  # how lines of check_bag begin that say what is wrong
ESCAPES = re.compile(r'\x1b\[[0-9;]*[A-Za-z]')


class JobFailed(Exception):
    """The command of a job failed by what is in its input; the text is its reason."""


class Interrupted(Exception):
    """The job was ended from outside."""


class JobRun:
    """A run of one job. `programs` is the folder of the package's commands."""

    def __init__(self, city, stage, name, programs):
        self.city = city
        self.stage = stage
        self.name = name
        self.programs = programs
        self.threads = str(city.project.resources(stage)['threads'])
        self.log = None
        self.lock = None
        self.extra = {}

    def run(self):
        """Runs the job unless it is done. Raises Interrupted, and OSError of a disk that fails."""
        self.city.state_file(self.stage, self.name).parent.mkdir(parents=True, exist_ok=True)
        with open(self.city.lock_file(self.stage, self.name), 'w') as self.lock:
            # Waits for what is left of a job whose engine was killed.
            fcntl.flock(self.lock, fcntl.LOCK_EX)
            if not self.city.is_up_to_date(self.stage, self.name):
                self._run_anew()
            self.city.done_file(self.stage, self.name).write_text(self.city.state(self.stage, self.name)['key'] + '\n')

    def _run_anew(self):
        key = self.city.key(self.stage, self.name)
        self.city.state_file(self.stage, self.name).unlink(missing_ok=True)
        begin = time.time()
        with open(self.city.log_file(self.stage, self.name), 'w') as self.log:
            try:
                result, reason = getattr(self, f'_{self.stage}')() or 'done', None
            except JobFailed as failure:
                result, reason = 'failed', str(failure)
        if isinstance(result, tuple):
            result, reason = result
        state = {'key': key, 'result': result, 'reason': reason, **self.extra}
        if reason is not None:
            state['last_lines'] = self.last_lines()
        self._write_times(time.time() - begin)
        write_json(self.city.state_file(self.stage, self.name), state)

    def _write_times(self, seconds):
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        write_json(self.city.times_file(self.stage, self.name), {
            'seconds': round(seconds, 2), 'processor_seconds': round(usage.ru_utime + usage.ru_stime, 2),
            'memory_mb': usage.ru_maxrss // 1024, 'host': socket.gethostname()})

    def lines(self):
        text = self.city.log_file(self.stage, self.name).read_text(errors='replace')
        lines = [ESCAPES.sub('', line.split('\r')[-1]).rstrip() for line in text.splitlines()]
        return [line for line in lines if line]

    def last_lines(self):
        return self.lines()[-LAST_LINES:]

    def command(self, program, *words, good=(0,)):
        """Runs a command of the package with its output in the log; its status, if that is good."""
        words = [str(self.programs / program), *(str(word) for word in words)]
        self.log.write('$ ' + ' '.join(words) + '\n')
        self.log.flush()
        # The command holds the lock, too: as long as it lives, nobody begins the job again.
        done = subprocess.run(words, stdin=subprocess.DEVNULL, stdout=self.log, stderr=subprocess.STDOUT,
                              pass_fds=[self.lock.fileno()], cwd=self.city.output)
        if done.returncode in good:
            return done.returncode
        if done.returncode in STOPPED or -done.returncode in FROM_OUTSIDE:
            raise Interrupted(f'{program} was ended from outside (status {done.returncode})')
        how = f'status {done.returncode}' if done.returncode > 0 else f'signal {-done.returncode}'
        lines = [line for line in self.last_lines() if not line.startswith('$ ')]
        raise JobFailed(lines[-1] if lines else f'{program} ended with {how}')

    # The stages.
    def _check(self):
        drive = self.city.project.drives[self.name]
        if not drive.is_bags():
            return 'skipped', 'a folder of scans has no messages to check'
        status = self.command('check_bag', *drive.paths, *drive.check_arguments(), good=(0, 1, UNREADABLE))
        if status == UNREADABLE:
            return 'refused', self.last_lines()[-1]
        self.extra['faults'] = faults_in(self.lines())
        return None

    def _map(self):
        if self.city.result('check', self.name) in ('refused', 'failed'):
            return 'refused', self.city.state('check', self.name)['reason']
        drive = self.city.project.drives[self.name]
        session = self.city.session(self.name)
        with aside(session) as part:
            status = self.command('map_bag', *drive.paths, '-o', part, '--no-map', '--threads', self.threads,
                                  *drive.map_arguments(), good=(0, DOUBTFUL))
            self.extra['is_doubtful'] = status == DOUBTFUL
            self._report_of(part)
            self.command('join_drives', 'describe', part, '-o', self.city.pieces_file(self.name))
        return None

    def _report_of(self, session):
        """The report of a session. That a map is too small to be judged is no failure of the job."""
        if self.city.project.settings['reports']:
            with contextlib.suppress(JobFailed):
                self.command('map_quality', session, '--report')

    def _pairs(self):
        drives = self.city.mapped()
        self.extra['chunks'] = []
        if not drives:
            raise JobFailed('no drive could be mapped, so there is no city; the drives above say why')
        folder = self.city.output / 'pairs'
        with aside(folder) as part:
            part.mkdir()
            self.command('join_drives', 'pairs', *(self.city.pieces_file(drive) for drive in drives), '-o', part)
        self.extra['chunks'] = sorted(file.stem for file in folder.glob('*.json'))
        return None

    def _loops(self):
        self.command('join_drives', 'loops', self.city.chunk_file(self.name), '--sessions',
                     self.city.output / 'drives', '-o', self.city.loops_file(self.name), *self._config())

    def _join(self):
        self._need('pairs')
        chunks = set(self.city.searched())
        loops = self.city.output / 'loops'
        loops.mkdir(exist_ok=True)
        for file in loops.glob('*.json'):
            if file.stem not in chunks:
                file.unlink()
        datum = self.city.project.settings['datum']
        with aside(self.city.joined) as part:
            self.command('join_drives', 'graph', *(self.city.session(drive) for drive in self.city.mapped()),
                         '--loops', loops, '-o', part, *(['--datum', *datum] if datum else []), *self._config())

    def _products(self):
        self._need('join')
        settings = self.city.project.settings['map']
        options = [word for key in ('resolution', 'tile_size') if settings[key] is not None
                   for word in ('--' + key.replace('_', '-'), settings[key])]
        with aside(self.city.products) as part:
            self.command('build_map', self.city.joined, '-o', part, '--threads', self.threads, '--formats',
                         ','.join(settings['formats']), *options)
        self._report_of(self.city.joined)

    def _report(self):
        report.write_report(self.city)

    def _config(self):
        config = self.city.project.settings['config']
        return ['--config', config] if config is not None else []

    def _need(self, stage):
        if self.city.result(stage, WHOLE) != 'done':
            raise JobFailed(f'{stage} has no result: {(self.city.state(stage, WHOLE) or {}).get("reason")}')


def faults_in(lines):
    """All that check_bag calls a fault or a warning, with remedies, behind the line of the input that has them."""
    found = []
    of_input = None
    for line in lines:
        if not FAULT.match(line):
            of_input = line
            continue
        if of_input is not None:
            found.append(of_input)
            of_input = None
        found.append(line.strip())
    return found


@contextlib.contextmanager
def aside(target):
    """A folder beside the target, in .part; it takes the target's place at the end of the block."""
    part = target.parent / '.part' / target.name
    shutil.rmtree(part, ignore_errors=True)
    part.parent.mkdir(parents=True, exist_ok=True)
    try:
        yield part
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise
    # A folder of its own: in .part, another target could have any name that is made of this one's.
    old = target.parent / '.old' / target.name
    shutil.rmtree(old, ignore_errors=True)
    old.parent.mkdir(exist_ok=True)
    if target.exists():
        os.rename(target, old)
    os.rename(part, target)
    shutil.rmtree(old, ignore_errors=True)
