# SPDX-License-Identifier: BSD-3-Clause
"""Runs the jobs of a city on this machine, without any engine: as soon as what they need is done, at most
so many at a time, each by the same command as an engine would start."""
import os
import signal
import subprocess
import sys
import time

from city.jobs import WHOLE
from city.progress import duration_text, seconds_of, status_of, summary, time_left

FINISHED = ('done', 'failed', 'refused', 'skipped')


class LocalEngine:
    """`command(stage, name)` gives the words that run a job."""

    def __init__(self, city, command, workers):
        self.city = city
        self.command = command
        self.workers = workers
        self.statuses = {}
        self.seconds = {}  # of jobs that are done
        self.running = {}  # (stage, name): process
        self.begin = time.monotonic()

    def run(self):
        """Runs what is not done. The number of jobs that were ended from outside."""
        interrupted = set()
        try:
            while True:
                self._look(interrupted)
                ready = self._ready(interrupted)
                for job in ready[:self.workers - len(self.running)]:
                    self._start(job)
                if not self.running:
                    return len(interrupted)
                self._wait(interrupted)
        finally:
            self._end_all()

    def _look(self, interrupted):
        """The states of the jobs that are known by now; the keys of later ones follow from earlier ones."""
        before, self.statuses = self.statuses, {}
        for job in self.city.jobs():
            if job in self.running:
                self.statuses[job] = 'running'
            elif before.get(job) in FINISHED:
                self.statuses[job] = before[job]
            elif job in interrupted or not self._is_ready(job):
                self.statuses[job] = 'waiting'
            else:
                status = status_of(self.city, *job)
                # What is left of a run that was killed: the new job waits for its lock.
                self.statuses[job] = 'waiting' if status == 'running' else status
                if status in FINISHED:
                    self.seconds[job] = seconds_of(self.city, *job)

    def _is_ready(self, job):
        return all(self.statuses.get(needed) in FINISHED for needed in self.city.needed(*job))

    def _ready(self, interrupted):
        return [job for job, status in self.statuses.items()
                if status == 'waiting' and job not in interrupted and self._is_ready(job)]

    def _start(self, job):
        # A group of its own: Ctrl-C reaches this process alone, which then ends them all.
        self.running[job] = subprocess.Popen(self.command(*job), start_new_session=True)
        self.statuses[job] = 'running'
        self._say(f'{"/".join(job)} begins')

    def _wait(self, interrupted):
        while True:
            ended = [job for job, process in self.running.items() if process.poll() is not None]
            if ended:
                break
            time.sleep(0.05)
        for job in ended:
            status = self.running.pop(job).returncode
            state = self.city.state(*job)
            if status != 0 or not state:
                interrupted.add(job)
                self._say(f'{"/".join(job)} was ended (status {status}); it is run again at the next start')
                continue
            self.statuses[job] = state['result']
            self.seconds[job] = seconds_of(self.city, *job)
            reason = f': {state["reason"]}' if state['result'] in ('failed', 'refused') else ''
            self._say(f'{"/".join(job)} {state["result"]}{reason}')

    def _say(self, text):
        left = time_left(self.statuses, self.seconds, self.workers)
        rest = '' if left is None or left < 1 else f', about {duration_text(left)} left of what is known'
        elapsed = duration_text(time.monotonic() - self.begin)
        print(f'[{elapsed}; {summary(self.statuses)}{rest}] {text}', flush=True)

    def _end_all(self):
        for process in self.running.values():
            try:
                os.killpg(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
            process.wait()


def plan(city):
    """The jobs that a run would begin, as far as they are known, in words."""
    waiting = [job for job in city.jobs() if status_of(city, *job) in ('waiting', 'running')]
    lines = ['/'.join(job) for job in waiting]
    if ('pairs', WHOLE) in waiting:
        lines.insert(lines.index(f'pairs/{WHOLE}') + 1, 'loops/... (known when the pairs are)')
    return lines


def self_command(argv0, project, programs):
    """The words that run one job by this very command."""
    def command(stage, name):
        return [sys.executable, argv0, str(project), '--job', f'{stage}/{name}', '--programs', str(programs)]
    return command
