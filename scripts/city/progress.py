# SPDX-License-Identifier: BSD-3-Clause
"""What of a city is done, runs, waits or failed, and how long the rest may take."""
import collections
import statistics

from city.jobs import WHOLE, read_json
from city.project import STAGES


def duration_text(seconds):
    seconds = int(seconds + 0.5)
    if seconds < 60:
        return f'{seconds} s'
    if seconds < 3600:
        return f'{seconds // 60} min'
    return f'{seconds // 3600} h {seconds % 3600 // 60:02d} min'


def status_of(city, stage, name):
    """One of done, failed, refused, skipped, running, waiting."""
    if city.is_running(stage, name):
        return 'running'
    if not city.is_up_to_date(stage, name):
        return 'waiting'
    return city.result(stage, name)


def seconds_of(city, stage, name):
    """How long the last run of a job took; nothing if it has not run."""
    times = read_json(city.times_file(stage, name))
    return times['seconds'] if times else None


def time_left(statuses, seconds, workers):
    """Seconds that the known jobs may still take with so many at a time: those of a stage take as long as the
    median of those that are done, whose `seconds` are given. Nothing if a stage has none yet."""
    left = 0.0
    for stage in STAGES:
        open_jobs = [name for (of, name), status in statuses.items()
                     if of == stage and status in ('waiting', 'running')]
        if not open_jobs:
            continue
        known = [took for (of, _), took in seconds.items() if of == stage and took is not None]
        if not known:
            return None
        left += statistics.median(known) * len(open_jobs) / min(workers, len(open_jobs))
    return left


def summary(statuses):
    counts = collections.Counter(statuses.values())
    good = counts['done'] + counts['skipped']
    text = f'{good} of {len(statuses)} jobs done'
    for status in ('running', 'waiting', 'failed', 'refused'):
        if counts[status]:
            text += f', {counts[status]} {status}'
    return text


def table(city):
    """The status of every job as lines of text."""
    statuses = {job: status_of(city, *job) for job in city.jobs()}
    lines = []
    for (stage, name), status in statuses.items():
        seconds = seconds_of(city, stage, name)
        took = f' ({duration_text(seconds)})' if seconds is not None and status != 'waiting' else ''
        lines.append(f'{stage:<9}{name:<32}{status}{took}')
        state = city.state(stage, name)
        if status in ('failed', 'refused') and state:
            lines.append(f'           {state["reason"]}')
    lines.append(summary(statuses))
    if statuses['pairs', WHOLE] in ('waiting', 'running'):
        lines.append('all chunks of the loop search are known when the pairs are')
    return lines
