#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tells for each mechanism and each tuned constant whether it earns its place (doc/results/ablation.md).

A copy of the source tree is built as it is, and again with one mechanism switched off, or with one constant at half
or at twice its value. Each build runs the same short simulated drives by odometry_campaign; its figures are compared
with those of the unchanged one. What a change that means nothing does to them is measured with the unchanged build by
a range noise that differs by up to 2.5 %: each drive counts by how well its error repeats. The results are appended
to a CSV file, and what it has is not measured again. The table is written from it.
"""
import argparse
import csv
import functools
import json
import math
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
import zlib
from collections import Counter
from pathlib import Path
from typing import Callable, NamedTuple, Optional

import check_constants

ROOT = check_constants.ROOT
TARGET = 'odometry_campaign'
FACTORS = {'half': 0.5, 'twice': 2.0}
OFF = 'off'  # the variant of a mechanism
REAL = re.compile(r'double|float|auto|Weight')
WHOLE = re.compile(r'\d+[uUlL]*')
BRIER = re.compile(r'Brier score of the probability: ([\d.]+)')
MEMORY = 4 << 30  # bytes that the program may use, so that no table made larger takes the machine's
RANGE_NOISE = 0.02  # m, that of odometry_campaign
LEAST_SIGMA = 0.03  # of the logarithm of a drive's error: smaller changes of one drive are of no interest
# Figure: the least change that counts; times are of a machine with other work. Those of RATIOS are factors, the others
# differences; less is better in all.
RATIOS = ('ape', 'cpu')
LEAST = {'ape': math.log(1.01), 'worst_sigmas': 5.0, 'wrong': 1.5, 'silent': 1.5, 'false_alarms': 1.5, 'brier': 1e-3,
         'cpu': math.log(1.15)}
NOISE_SIGMAS = 3.0
COLUMNS = ['file', 'name', 'variant', 'value', 'new_value', 'status', *LEAST, 'worst_drive', 'worst_ratio', 'seconds',
           'comment', 'basis']


class Constant(NamedTuple):
    path: str  # from the root of the tree
    name: str
    first: int  # line, from 0
    last: int
    start: int  # of the value in the first line
    kind: str  # its type
    value: str
    comment: str


class Change(NamedTuple):
    """One variant of the tree."""
    path: str
    name: str
    variant: str
    value: str
    new_value: Optional[str]  # none: it cannot be changed
    comment: str
    patch: Callable[[str], str]  # from the text of the file to its new one

    @property
    def full_name(self):
        return f'{self.path}:{self.name}'


def comment_of(lines, first, last):
    """What stands in the lines of a constant, else above it or above its group."""
    beside = [line.split('//', 1)[1] for line in lines[first:last + 1] if '//' in line]
    above = []
    line = first - 1
    while line >= 0 and lines[line].strip() and not (above and not lines[line].lstrip().startswith('//')):
        if lines[line].lstrip().startswith('//'):
            above.insert(0, lines[line].split('//', 1)[1])
        line -= 1
    return ' '.join(part.strip('/<! ') for part in (beside or above))


def constants_of(path, text):
    """Every constant that check_constants.py knows in a file; a name that comes again gets a number."""
    lines = text.split('\n')
    times = Counter()
    for number, name, _ in check_constants.constants(lines):
        first = number - 1
        last = check_constants.last_line(lines, first)
        match = check_constants.CONSTANT.match(lines[first])
        statement = [check_constants.without_comment(line) for line in lines[first:last + 1]]
        start = match.end() - 1
        value = ' '.join([statement[0][start:], *map(str.strip, statement[1:])]).rstrip(';')
        times[name] += 1
        yield Constant(path, name if times[name] == 1 else f'{name}#{times[name]}', first, last, start, match.group(1),
                       value.lstrip('= ').strip(), comment_of(lines, first, last))


def all_constants(root):
    for path in sorted([*root.glob('src/**/*.[ch]pp'), *root.glob('include/**/*.hpp')]):
        yield from constants_of(str(path.relative_to(root)), path.read_text())


def changed_value(constant, factor):
    """C++ of the value times the factor; none where that changes nothing. Of a number of bits: of what they hold."""
    if constant.name.endswith('Bits') and not REAL.fullmatch(constant.kind):
        return f'{constant.value} {"+" if factor > 1.0 else "-"} 1'
    return scaled(constant.kind, constant.value, factor)


def scaled(kind, value, factor):
    """The value times the factor, a count rounded and at least 1; none where that changes nothing."""
    if value.startswith('{'):
        parts = [scaled('double', part.strip(), factor) for part in value.strip('{}').split(',')]
        return None if None in parts else '{' + ', '.join(parts) + '}'
    if kind == 'bool':
        return f'!({value})' if factor == FACTORS['half'] else None
    if REAL.fullmatch(kind):
        product = f'{factor:g} * ({value})'
        return f'static_cast<float>({product})' if kind == 'float' else product
    if not WHOLE.fullmatch(value):
        return f'static_cast<{kind}>({factor:g} * static_cast<double>({value}))'
    whole = int(value.rstrip('uUlL'))
    changed = max(1, int(math.floor(factor * whole + 0.5)))
    return None if changed == whole or whole == 0 else str(changed)


def patched(text, constant, new_value):
    """The text of a file in which one constant has another value."""
    lines = text.split('\n')
    head = lines[constant.first][:constant.start].rstrip()
    equals = '' if new_value.startswith('{') else ' = '
    lines[constant.first:constant.last + 1] = [head + equals + new_value + ';']
    return '\n'.join(lines)


def changes_of_constants(root):
    for constant in all_constants(root):
        for variant, factor in FACTORS.items():
            new_value = changed_value(constant, factor)
            yield Change(constant.path, constant.name, variant, constant.value, new_value, constant.comment,
                         functools.partial(patched, constant=constant, new_value=new_value))


def replaced(text, before, after, name):
    """The text of a file without a mechanism."""
    if text.count(before) != 1:
        sys.exit(f'{name}: its file has {text.count(before)} times: {before}')
    return text.replace(before, after)


def changes_of_mechanisms(path):
    """Those of a file with three lines for each: 'name: file', '- text', '+ text without it'."""
    lines = [line for line in path.read_text().split('\n') if line.strip() and not line.startswith('#')]
    for head, before, after in zip(lines[0::3], lines[1::3], lines[2::3]):
        name, file = head.split(': ')
        if not (before.startswith('- ') and after.startswith('+ ')):
            sys.exit(f'{path}: {name} needs a line with - and one with +')
        yield Change(file, name, OFF, before[2:], after[2:], '',
                     functools.partial(replaced, before=before[2:], after=after[2:], name=name))


def commit_of(root):
    command = ['git', '-C', root, 'rev-parse', '--short=9', 'HEAD']
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def update_copy(root, copy):
    """Makes the copy equal to the tree, as far as git knows it; what is equal already keeps its time."""
    names = subprocess.run(['git', '-C', root, 'ls-files', '-z'], check=True, capture_output=True, text=True).stdout
    for name in filter(None, names.split('\0')):
        source, target = root / name, copy / name
        if not source.is_file() or (target.is_file() and target.read_bytes() == source.read_bytes()):
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(source.read_bytes())
        target.chmod(source.stat().st_mode)


def build(copy, log):
    """Whether the programs of the copy could be built."""
    with open(log, 'w') as output:
        if not (copy / '.build/CMakeCache.txt').exists():
            launcher = ['-DCMAKE_CXX_COMPILER_LAUNCHER=ccache'] if shutil.which('ccache') else []
            # One source is changed at a time.
            subprocess.run(['cmake', '-S', copy, '-B', copy / '.build', '-DCMAKE_UNITY_BUILD=OFF', *launcher],
                           stdout=output, stderr=output, check=True)
        command = ['cmake', '--build', copy / '.build', '--target', TARGET, '-j1']
        with subprocess.Popen(command, stdout=output, stderr=output, start_new_session=True) as process:
            try:
                return process.wait() == 0
            except BaseException:  # no compiler may write an object after its source was restored
                os.killpg(process.pid, signal.SIGKILL)
                raise


def limit_memory():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def run_drives(program, cases, duration, log, limit=None):
    """Figures of each drive and Brier's score of all; none if the program fails, does not end, or finds no numbers."""
    figures = log.with_suffix('.json')
    command = [program, '--cases', cases, '--duration', str(duration), '--json', figures]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit,
                              preexec_fn=limit_memory)
    except subprocess.TimeoutExpired:
        return None
    log.write_text(done.stdout + done.stderr)
    brier = BRIER.search(done.stdout)
    if done.returncode != 0 or brier is None:
        return None
    return {'brier': float(brier.group(1)), 'runs': json.loads(figures.read_text())['runs']}


def mean(values):
    return sum(values) / len(values) if values else 0.0


def logarithms_of_errors(measured):
    return [math.log(max(run['ape_m'], 1e-6)) for run in measured['runs']]


def spread(values):
    """Mean and standard deviation."""
    middle = mean(values)
    square = sum((value - middle) ** 2 for value in values) / max(1, len(values) - 1)
    return middle, math.sqrt(square)


def changes_of_counts(references, other, key):
    """Of each drive whose number of such steps changed by more than it does anyway."""
    for i, run in enumerate(other['runs']):
        middle, sigma = spread([reference['runs'][i][key] for reference in references])
        if abs(run[key] - middle) > NOISE_SIGMAS * sigma + 1.0:
            yield run[key] - middle


def compare(references, other):
    """Figures of one build against several runs of the unchanged one: ratios or differences, see LEAST."""
    spreads = [spread(values) for values in zip(*map(logarithms_of_errors, references))]
    drives = [(value - middle, max(sigma, LEAST_SIGMA))
              for value, (middle, sigma) in zip(logarithms_of_errors(other), spreads)]
    weight = sum(sigma ** -2 for _, sigma in drives)
    sigmas = [change / sigma for change, sigma in drives]
    worst = max(range(len(drives)), key=lambda i: abs(sigmas[i]))

    def total(measured, key):
        return sum(run[key] for run in measured['runs'])

    result = {key: sum(changes_of_counts(references, other, key)) for key in ('wrong', 'silent', 'false_alarms')}
    result.update({
        'ape': math.exp(sum(change * sigma ** -2 for change, sigma in drives) / weight),
        'worst_sigmas': sigmas[worst], 'worst_drive': other['runs'][worst]['case'].split()[0],
        'worst_ratio': math.exp(drives[worst][0]),
        'brier': other['brier'] - mean([reference['brier'] for reference in references]),
        'cpu': total(other, 'cpu_ms') / mean([total(reference, 'cpu_ms') for reference in references])})
    return {key: value if isinstance(value, str) else round(value, 5) for key, value in result.items()}


def is_same(base, other):
    """Whether no figure of any drive changed but the time."""
    def figures(runs):
        return [{key: value for key, value in run.items() if key not in ('cpu_ms', 'case')} for run in runs]
    return figures(base['runs']) == figures(other['runs']) and base['brier'] == other['brier']


def deviation(row, figure):
    """Of a figure from that of the unchanged build; above 0: worse."""
    value = float(row[figure])
    return math.log(value) if figure in RATIOS else value


def noise_limits(rows):
    """Of each figure, the change beyond which it is no noise: some standard deviations of the noise runs."""
    noise = [row for row in rows if row['variant'].startswith('noise') and row['status'] != 'fails']
    limits = {}
    for figure, least in LEAST.items():
        square = mean([deviation(row, figure) ** 2 for row in noise])
        limits[figure] = max(least, NOISE_SIGMAS * math.sqrt(square))
    return limits


def beyond_noise(row, limits):
    """The figures that changed by more than noise, with how many times more; below 0: better."""
    if row['status'] != 'measured':
        return {}
    ratios = {figure: deviation(row, figure) / limit for figure, limit in limits.items()}
    return {figure: ratio for figure, ratio in ratios.items() if abs(ratio) > 1.0}


def effect(rows, limits):
    """The largest change of a constant's rows, in units of the noise; without end where nothing could be measured."""
    if any(row['status'] == 'fails' for row in rows):
        return math.inf
    return max((abs(ratio) for row in rows for ratio in beyond_noise(row, limits).values()), default=0.0)


def verdict(rows, limits):
    statuses = {row['status'] for row in rows}
    changes = [beyond_noise(row, limits) for row in rows]
    figures = {figure for change in changes for figure in change}
    if 'fails' in statuses:
        return 'matters: a program fails'
    if statuses <= {'does not compile', 'skipped'}:
        return 'not movable'
    if not figures:
        return 'moves nothing' if 'measured' in statuses else 'no figure changes'
    if figures == {'cpu'}:
        return 'matters for the time'
    better = [row['variant'] for row, change in zip(rows, changes) if change and max(change.values()) < 0.0]
    return f'matters; better at {better[0]}' if better else 'matters'


def cell_of(row, limits):
    """What changed beyond noise, as text."""
    if row['status'] != 'measured':
        return row['status']
    words = []
    for figure in beyond_noise(row, limits):
        value = float(row[figure])
        if figure == 'worst_sigmas':
            words.append(f'{row["worst_drive"]} {float(row["worst_ratio"]):.2f}')
        else:
            number = f'{value:.2f}' if figure in RATIOS else f'{value:+.2g}'
            words.append(f'{figure.replace("_", " ")} {number}')
    return ', '.join(words) or 'noise'


def grouped(rows, variants):
    """The rows of each constant or mechanism that has such variants."""
    groups = {}
    for row in rows:
        if row['variant'] in variants:
            groups.setdefault((row['file'], row['name']), []).append(row)
    return groups.values()


def table_of(rows, variants, kind, with_value):
    """Markdown, what has the largest effect first."""
    limits = noise_limits(rows)
    heads = [kind, 'file', *(['value'] if with_value else []), *variants, 'verdict']
    lines = [heads, ['---'] * len(heads)]
    for group in sorted(grouped(rows, variants), key=lambda group: -effect(group, limits)):
        cells = {row['variant']: cell_of(row, limits) for row in group}
        file = re.sub(r'^(src|include/lidar_mapping)/', '', group[0]['file'])
        lines.append([f'`{group[0]["name"]}`', file, *([group[0]['value']] if with_value else []),
                      *(cells.get(variant, '') for variant in variants), verdict(group, limits)])
    return ''.join('| ' + ' | '.join(line) + ' |\n' for line in lines)


def table(rows):
    return (table_of(rows, [OFF], 'mechanism', False) + '\n' + table_of(rows, list(FACTORS), 'constant', True))


def limits_text(rows):
    parts = []
    for figure, limit in noise_limits(rows).items():
        number = f'{100.0 * math.expm1(limit):.1f} %' if figure in RATIOS else f'{limit:.2g}'
        parts.append(f'{figure.replace("_", " ")} {number}')
    return 'beyond noise: ' + ', '.join(parts)


def read_rows(path):
    if not path.exists():
        return []
    with open(path, newline='') as file:
        return list(csv.DictReader(file))


def append_row(path, row):
    is_new = not path.exists()
    with open(path, 'a', newline='') as file:
        writer = csv.DictWriter(file, COLUMNS, restval='')
        if is_new:
            writer.writeheader()
        writer.writerow(row)


def chosen_cases(text, pattern):
    """The lines of a file of cases but those of drives whose name does not match."""
    return ''.join(line for line in text.splitlines(keepends=True)
                   if line.startswith('#') or not line.strip() or re.match(pattern, line.split()[0]))


class Ablation:
    """The copy, its builds and the file of results."""

    def __init__(self, options):
        self.options = options
        self.copy = options.folder
        self.copy.mkdir(parents=True, exist_ok=True)
        self.logs = self.copy / '.build/ablation'
        self.program = self.copy / '.build/devel/lib/lidar_mapping' / TARGET
        self.logs.mkdir(parents=True, exist_ok=True)
        self.cases = self.logs / 'cases.txt'
        self.cases.write_text(chosen_cases(options.cases.read_text(), options.drives))
        drives = zlib.crc32(self.cases.read_bytes() + f'{options.duration} {options.noise}'.encode())
        self.basis = f'{options.basis or commit_of(ROOT)} {drives:08x}'
        self.rows = read_rows(options.output)
        if any(row['basis'] != self.basis for row in self.rows):
            sys.exit(f'{options.output} is of other drives or another commit than {self.basis}; give another --output')
        self.references = []
        self.base_seconds = 0.0

    def prepare(self):
        """Builds the unchanged tree and measures it, and how well that repeats."""
        update_copy(ROOT, self.copy)
        if not build(self.copy, self.logs / 'build.log'):
            sys.exit(f'the unchanged tree does not build: {self.logs / "build.log"}')
        if not self.program.exists():
            self.program = next((self.copy / '.build').glob(f'**/{TARGET}'))
        known = self.logs / 'unchanged_runs.json'
        if known.exists() and json.loads(known.read_text())['basis'] == self.basis:
            self.references, self.base_seconds = map(json.loads(known.read_text()).get, ('runs', 'seconds'))
            return
        begin = time.monotonic()
        base = self.drives(self.cases, 'unchanged')
        self.base_seconds = round(time.monotonic() - begin, 1)
        if base is None:
            sys.exit(f'{TARGET} fails without any change: {self.logs / "unchanged.log"}')
        self.references = [base, *self.noise_runs()]
        known.write_text(json.dumps({'basis': self.basis, 'seconds': self.base_seconds, 'runs': self.references}))

    def drives(self, cases, name, limit=None):
        return run_drives(self.program, cases, self.options.duration, self.logs / f'{name}.log', limit)

    def noise_runs(self):
        """The unchanged build with a range noise that differs by 0.5 % and more."""
        for i in range(self.options.noise):
            value = f'{RANGE_NOISE * (1.0 + 0.005 * (i // 2 + 1) * (-1) ** i):.6g}'
            cases = self.logs / 'noise_cases.txt'
            cases.write_text('\n'.join(f'{line} range_noise={value}' if re.match(r'\s*\w', line) else line
                                       for line in self.cases.read_text().split('\n')))
            yield self.drives(cases, f'noise_{i + 1}')

    def add_noise(self):
        """Each run of the unchanged build against all of them."""
        for i, other in enumerate(self.references):
            if not self.has('', '', f'noise {i}'):
                figures = compare(self.references, other)
                self.add({'file': '', 'name': '', 'variant': f'noise {i}', 'status': 'measured',
                          'seconds': self.base_seconds, **figures})

    def add(self, row):
        row['basis'] = self.basis
        append_row(self.options.output, row)
        self.rows.append({key: str(value) for key, value in row.items()})
        print(f'{row["status"]:>17} {row["seconds"]:6.0f} s  {row["file"]}:{row["name"]} {row["variant"]}',
              flush=True)

    def has(self, file, name, variant):
        return any((row['file'], row['name'], row['variant']) == (file, name, variant) for row in self.rows)

    def measure(self, name):
        """Status and figures of the program as it is built now."""
        other = self.drives(self.cases, name, 10.0 * self.base_seconds + 60.0)
        if other is None:
            return {'status': 'fails'}
        status = 'no change' if is_same(self.references[0], other) else 'measured'
        return {'status': status, **compare(self.references, other)}

    def measure_change(self, change):
        """Builds and measures one variant; the copy is as before afterwards."""
        begin = time.monotonic()
        figures = {'status': 'skipped'}
        if change.new_value is not None:
            path = self.copy / change.path
            text = path.read_text()
            try:
                path.write_text(change.patch(text))
                name = f'{Path(change.path).name}_{change.name}_{change.variant}'
                figures = {'status': 'does not compile'}
                if build(self.copy, self.logs / 'build.log'):
                    figures = self.measure(name)
            finally:
                path.write_text(text)
        self.add({'file': change.path, 'name': change.name, 'variant': change.variant, 'value': change.value,
                  'new_value': change.new_value or '', 'comment': change.comment,
                  'seconds': round(time.monotonic() - begin, 1), **figures})

    def run(self, changes):
        """Everything that the file of results does not have yet, until the time is over."""
        end = time.monotonic() + 60.0 * self.options.minutes
        todo = [change for change in changes if not self.has(change.path, change.name, change.variant)]
        if todo:
            self.prepare()
            print(f'the drives take {self.base_seconds:.0f} s; {len(todo)} changes', flush=True)
            self.add_noise()
        for change in todo:
            if time.monotonic() > end:
                print('the time is over; the same command goes on')
                return
            self.measure_change(change)


def selected(options):
    """In the order of the patterns, so that what is named first is measured first."""
    def first_match(change):
        return next((i for i, pattern in enumerate(options.match) if re.search(pattern, change.full_name)), None)
    changes = [] if options.chosen else list(changes_of_mechanisms(options.mechanisms))
    changes += changes_of_constants(ROOT)
    changes = [change for change in changes if first_match(change) is not None]
    if options.chosen:
        changes = [change for change in changes if re.search(r'\bchosen\b', change.comment, re.IGNORECASE)]
    names = sorted({change.full_name for change in changes})
    if options.sample and options.sample < len(names):
        print(f'{options.sample} of {len(names)} names, drawn with --seed {options.seed}')
        names = set(random.Random(options.seed).sample(names, options.sample))
        changes = [change for change in changes if change.full_name in names]
    return sorted(changes, key=first_match)


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--match', nargs='+', default=['front_end/', 'registration/'],
                        help='regular expressions of FILE:NAME, the most urgent first (%(default)s)')
    parser.add_argument('--chosen', action='store_true', help="only constants whose comment says 'chosen'")
    parser.add_argument('--sample', type=int, help='only so many constants and mechanisms, drawn at random')
    parser.add_argument('--seed', type=int, default=1, help='of --sample')
    parser.add_argument('--list', action='store_true', help='say what would be changed, measure nothing')
    parser.add_argument('--cases', type=Path, default=ROOT / 'test/campaign/ablation_cases.txt',
                        help='drives, one a line (doc/campaign.md)')
    parser.add_argument('--drives', default='', help='only drives whose name begins with this regular expression')
    parser.add_argument('--mechanisms', type=Path, default=ROOT / 'test/campaign/ablation_mechanisms.txt',
                        help='what is switched off')
    parser.add_argument('--duration', type=float, default=4.0, help='seconds of each drive (%(default)s)')
    parser.add_argument('--noise', type=int, default=10, help='runs that tell the noise (%(default)s)')
    parser.add_argument('--minutes', type=float, default=1e6, help='begin nothing new after this time')
    parser.add_argument('--folder', type=Path, default=ROOT / '.build_ablation', help='copy of the tree and its build')
    parser.add_argument('--output', type=Path, default=ROOT / '.build_ablation/ablation.csv', help='CSV file')
    parser.add_argument('--table', type=Path, help='Markdown file to write')
    parser.add_argument('--basis', help='go on with a CSV file of this commit, whose code is the same')
    return parser.parse_args(arguments)


def main(arguments):
    options = parse(arguments)
    changes = selected(options)
    if options.list:
        for change in changes:
            print(f'{change.full_name} {change.variant}: {change.value} -> {change.new_value or "skipped"}'
                  f'  // {change.comment}')
        print(f'{len(changes)} changes')
        return
    for number in (signal.SIGINT, signal.SIGTERM):  # in the background, too
        signal.signal(number, signal.default_int_handler)
    ablation = Ablation(options)
    try:
        ablation.run(changes)
    except KeyboardInterrupt:
        print('stopped; the same command goes on')
    print(limits_text(ablation.rows))
    if options.table:
        options.table.write_text(table(ablation.rows))
    else:
        print(table(ablation.rows))


if __name__ == '__main__':
    main(sys.argv[1:])
