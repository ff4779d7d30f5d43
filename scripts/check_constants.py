#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks that every numeric constant has a comment: meaning, unit, origin of the value.

The comment stands in a line of the constant, or above it or its group of constants one below another.
A constant that is made of others, without a number of its own, needs none.

Whether meaning and unit are there is for the reader to judge. The origin has to be named by one of these:

- a choice with its reason: "chosen: ...", or the reason alone ("because", "so that", "otherwise",
  "longer than any ...", "no sensor has ...");
- a measurement: "measured on ...", "Measured: ...", "Tried: ..." ("is measured" says what something is,
  not where a value comes from);
- a paper by author and year, or what an interface, a format, a standard, a manual, a default or the
  processor demands: "by the format", "by LAS 1.2", "by sensor_msgs/Imu", "in a register of 128 bits";
- geometry, physics, statistics, a definition: "by geometry", "quantile of", "by definition";
- another constant or another place: "twice kEdge", "as in number_words.hpp", "see doc/...".

With --table it prints instead, as a table in Markdown, how many constants of each stage have which origin. A
comment that names several origins counts by the first one in the order of ORIGINS, and the words of the
constant itself go before those of its group.

Usage: check_constants.py [--table]
"""
import collections
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CONSTANT = re.compile(r'\s*(?:static |inline )*constexpr (?:static )?([^()=]*?) ?\b(k[A-Z]\w*)\s*[={]')
NUMERIC = re.compile(r'(?:double|float|int|unsigned|bool|auto|Weight|std::size_t|std::u?int\d+_t)')
NUMBER = re.compile(r'(?<![\w.])\.?\d')
# None of these words is needed to say what a constant is.
ORIGINS = {
    'measured': (
        r'(?i:(?<!not )(?<!is )(?<!are )(?<!a )\bmeasured(?= (?:on|in|at|with|for|over)\b| ?[:;,()]))|\bTried\b',),
    'chosen': (
        r'(?i:\bchosen\b)',),
    'given': (
        # a paper, a format, an interface, the processor
        r'(?:\bal\.|\b[A-Z]\w+),? \(?(?:19|20)\d\d\b|\bIEEE 754\b',
        r'(?i:\bby (?:the |its )?(?:formats?|layout|dimensions|default|definition|geometry|calculus|law)\b)',
        r'\bby [^.;:]*(?:[A-Z]{2,}|\b(?:format|manual|data sheet|standards?|benchmark)\b|\w_msgs\b)',
        r'\b(?:the default|default of|every processor has|registers? of \d+ bits)\b',
        # geometry, physics, statistics
        r'(?i:\b(?:geometry|physics|quantile of|normal distribution|normally distributed)\b)|chi-square|\bRayleigh\b'),
    'elsewhere': (
        # another constant or another place
        r'(?i:\b(?:twice|half(?: of)?|third of|quarter of|times|that of|as in|as|than|by)) k[A-Z]\w+',
        r'\bas in [\w/]+\.[ch]pp\b|\b(?:value|that|those) (?:is that )?of\s[A-Z]\w+::\w+',
        r'\b[Ss]ee (?:doc/|below|[A-Z]\w+::|\w+\.[ch]pp)'),
    'reasoned': (
        # a choice by its reason alone
        r'\b(?:because|so that|otherwise)\b',
        r'\b(?:than|above|below) (?:any|all|every)\b|\b[Nn]o \w+ (?:is|has|have|does|turns|measures)\b'),
}
ORIGIN = {name: re.compile('|'.join(patterns)) for name, patterns in ORIGINS.items()}
# Heading of a column and the origins that count there.
COLUMNS = {
    'by definition, physics, format, paper': ('given',),
    'as another constant or page says': ('elsewhere',),
    'measured': ('measured',),
    'chosen': ('chosen', 'reasoned'),
}


def without_comment(line):
    return line.split('//')[0].rstrip()


def comment_text(lines):
    return ' '.join(line.split('//', 1)[1].lstrip('/!< ').rstrip() for line in lines if '//' in line)


def indentation(line):
    return len(line) - len(line.lstrip())


def last_line(lines, first):
    """Index of the line in which a statement ends."""
    last = first
    while last + 1 < len(lines) and not without_comment(lines[last]).endswith(';'):
        last += 1
    return last


def comment_above(lines, first):
    """Of the lines directly above; those that continue a comment beside other code begin further right."""
    begin = first
    while begin > 0 and lines[begin - 1].lstrip().startswith('//') \
            and indentation(lines[begin - 1]) <= indentation(lines[first]):
        begin -= 1
    return comment_text(lines[begin:first])


def last_line_of_comment(lines, first, last):
    """Index of the line in which the comment beside a statement ends."""
    while last + 1 < len(lines) and lines[last + 1].lstrip().startswith('//') \
            and indentation(lines[last + 1]) > indentation(lines[first]):
        last += 1
    return last


def constants(lines):
    """(line number, name, comments: above its group, and its own) of each numeric constant."""
    last = -1
    of_group = ''
    for first, line in enumerate(lines):
        match = CONSTANT.match(line)
        if first <= last or not match:
            continue
        if first != last + 1:  # another group begins
            of_group = comment_above(lines, first)
        end = last_line(lines, first)
        last = last_line_of_comment(lines, first, end)
        value = '\n'.join(map(without_comment, lines[first:end + 1]))[match.end():]
        if NUMERIC.fullmatch(match.group(1)) and NUMBER.search(value):
            yield first + 1, match.group(2), (of_group, comment_text(lines[first:last + 1]))


def all_constants():
    """(path, line number, name, comments: above its group, and its own)"""
    for path in sorted([*ROOT.glob('src/**/*.[ch]pp'), *ROOT.glob('include/**/*.hpp')]):
        for constant in constants(path.read_text().split('\n')):
            yield path.relative_to(ROOT), *constant


def origin_of(comments):
    of_group, own = comments
    for comment in (own, of_group, f'{of_group} {own}'):
        for name, pattern in ORIGIN.items():
            if pattern.search(comment):
                return name
    return None


def stage_of(path):
    return path.parts[1] if path.parts[0] == 'src' else path.parts[2]


def print_table():
    counts = collections.defaultdict(collections.Counter)
    for path, _, _, comments in all_constants():
        counts[stage_of(path)][origin_of(comments)] += 1
    rows = sorted(counts.items(), key=lambda row: (-sum(row[1].values()), row[0]))
    rows.append(('all', sum(counts.values(), collections.Counter())))
    print(f'| stage | constants | {" | ".join(COLUMNS)} |')
    print('|---|' + '---:|' * (1 + len(COLUMNS)))
    for stage, origins in rows:
        numbers = [sum(origins.values()), *(sum(origins[name] for name in names) for names in COLUMNS.values())]
        print(f'| {stage} | {" | ".join(map(str, numbers))} |')


def main():
    if sys.argv[1:] == ['--table']:
        return print_table()
    if sys.argv[1:]:
        sys.exit(__doc__)
    count = faulty = 0
    for path, number, name, comments in all_constants():
        count += 1
        if origin_of(comments):
            continue
        faulty += 1
        fault = ('does not say where its value comes from' if any(comments)
                 else 'has no comment: what it is, unit, origin')
        print(f'{path}:{number}: {name} {fault}')
    print(f'constants: {count}, {faulty} without a comment or without the origin of their value')
    return 1 if faulty > 0 else 0


if __name__ == '__main__':
    sys.exit(main())
