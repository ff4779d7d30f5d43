#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks that every numeric constant has a comment: meaning, unit, origin of the value.

The comment stands in a line of the constant, or above it or its group of constants one below another.
A constant that is made of others, without a number of its own, needs none.
Usage: check_constants.py
"""
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CONSTANT = re.compile(r'\s*(?:static |inline )*constexpr (?:static )?([^()=]*?) ?\b(k[A-Z]\w*)\s*[={]')
NUMERIC = re.compile(r'(?:double|float|int|unsigned|bool|auto|Weight|std::size_t|std::u?int\d+_t)')
NUMBER = re.compile(r'(?<![\w.])\.?\d')


def without_comment(line):
    return line.split('//')[0].rstrip()


def last_line(lines, first):
    """Index of the line in which a statement ends."""
    last = first
    while last + 1 < len(lines) and not without_comment(lines[last]).endswith(';'):
        last += 1
    return last


def constants(lines):
    """(line number, name, whether it has a comment) of each numeric constant."""
    last = -1
    group_has_comment = False
    for first, line in enumerate(lines):
        match = CONSTANT.match(line)
        if first <= last or not match:
            continue
        if first != last + 1:  # another group begins
            group_has_comment = first > 0 and lines[first - 1].lstrip().startswith('//')
        last = last_line(lines, first)
        statement = lines[first:last + 1]
        value = '\n'.join(map(without_comment, statement))[match.end():]
        if NUMERIC.fullmatch(match.group(1)) and NUMBER.search(value):
            yield first + 1, match.group(2), group_has_comment or any('//' in part for part in statement)


def main():
    count = bare = 0
    for path in sorted([*ROOT.glob('src/**/*.[ch]pp'), *ROOT.glob('include/**/*.hpp')]):
        for number, name, has_comment in constants(path.read_text().split('\n')):
            count += 1
            if not has_comment:
                bare += 1
                print(f'{path.relative_to(ROOT)}:{number}: {name} has no comment: what it is, unit, origin')
    print(f'constants: {count}, {bare} without a comment')
    return 1 if bare > 0 else 0


if __name__ == '__main__':
    sys.exit(main())
