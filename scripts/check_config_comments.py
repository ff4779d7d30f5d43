#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds the comments of configuration structs against the one description of their fields, the schema.

A field's comment is its unit in brackets and the schema's sentence. Angles are in radians in the struct, whatever
their unit in files: those in degrees have to be lines angle() of the schema. `--fix` writes the comments anew.
Usage: check_config_comments.py [--fix]
"""
import re
import sys
import textwrap
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WIDTH = 100
STRING = r'"(?:[^"\\]|\\.)*"'
FIELD = re.compile(
    r'\.(real|angle|integer|boolean|text|reals|choice)\(\s*' + STRING + r'\s*,\s*&(?:\w+::)*?(\w+)::(\w+)\s*,')
# Units of angles: that of files to that of the field.
RADIANS = {'deg': 'rad', 'deg/m': 'rad/m', 'deg per 100 m': 'rad/m'}
ALIAS = re.compile(r'using (\w+) = (\w+Config);')
MEMBER = re.compile(r'^  [\w:<>]+(?:<[\w:, ]+>)? (\w+)(?: = .*|\{.*)?;')


def arguments(source, begin):
    """The rest of a call's arguments, from behind the field to its closing bracket."""
    depth, inside_string, i = 1, False, begin
    while depth > 0:
        c = source[i]
        if inside_string:
            if c == '\\':
                i += 1
            elif c == '"':
                inside_string = False
        elif c == '"':
            inside_string = True
        elif c in '({':
            depth += 1
        elif c in ')}':
            depth -= 1
        i += 1
    return source[begin:i - 1]


def strings_of(text):
    """String literals of the outermost level, neighbours joined as the compiler joins them."""
    flat = re.sub(r'\{[^{}]*\}', '{}', text)
    groups = re.findall(rf'{STRING}(?:\s*{STRING})*', flat)
    return [''.join(s[1:-1] for s in re.findall(STRING, group)).replace('\\"', '"') for group in groups]


def descriptions(source):
    """(struct, field) -> comment, of all schemas in a file."""
    aliases = dict(ALIAS.findall(source))
    result = {}
    for match in FIELD.finditer(source):
        kind, struct, field = match.groups()
        struct = aliases.get(struct, struct)
        texts = strings_of(arguments(source, match.end()))
        has_unit = kind in ('real', 'angle', 'integer', 'reals')
        unit = texts[0] if has_unit and len(texts) > 1 else ''
        if (kind == 'angle') != (unit in RADIANS):
            sys.exit(f'{struct}::{field}: angle() is for the units {", ".join(RADIANS)}, and for these alone')
        unit = RADIANS.get(unit, unit)
        result[struct, field] = (f'[{unit}] ' if unit else '') + texts[-1]
    return result


def commented(lines, described):
    """The header's lines with the comment of each described field above it."""
    result, struct = [], None
    for line in lines:
        begins = re.match(r'^struct (\w+)', line)
        struct = begins.group(1) if begins else struct
        member = MEMBER.match(line)
        key = (struct, member.group(1)) if member else None
        if key in described:
            while result and result[-1].startswith('  ///'):
                result.pop()
            result += [f'  /// {part}' for part in textwrap.wrap(described[key], WIDTH - 6)]
            line = re.sub(r'\s*///<.*', '', line)
        elif re.match(r'^ {10,}///<', line):
            continue
        result.append(line)
    return result


def main():
    described = {}
    for path in sorted([*ROOT.glob('src/**/*.cpp'), *ROOT.glob('include/**/*.hpp'), *ROOT.glob('src/**/*.hpp')]):
        described.update(descriptions(path.read_text()))
    # One file may call the struct of another by a short name: each file's own names were resolved above.
    wrong = 0
    structs = {struct for struct, _ in described}
    for path in sorted([*ROOT.glob('include/**/*.hpp'), *ROOT.glob('src/**/*.hpp')]):
        before = path.read_text()
        if not any(re.search(rf'^struct {struct} ', before, re.M) for struct in structs):
            continue
        after = '\n'.join(commented(before.split('\n'), described))
        if after == before:
            continue
        wrong += 1
        if '--fix' in sys.argv[1:]:
            path.write_text(after)
        else:
            print(f'{path.relative_to(ROOT)}: comments differ from the schema; scripts/check_config_comments.py --fix')
    print(f'configuration comments: {len(described)} fields, {wrong} files that differ')
    return 1 if wrong and '--fix' not in sys.argv[1:] else 0


if __name__ == '__main__':
    sys.exit(main())
