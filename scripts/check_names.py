#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Hold the names that the documentation gives against the code.

doc/glossary.md has to be in alphabetical order and to explain every field of the messages and services
and every topic and service of the nodes. Each row of a table, there and on all other pages, has to have as
many cells as the table's first row. Each `file:function` of doc/walks.md, doc/architecture.md and
CONTRIBUTING.md has to be a function (or class) that this file defines, and each file that they name has to exist.
Each test in the column "test" of doc/reference/ancestors.md has to be in the sources of the tests.

usage: check_names.py [ROOT]
"""
import pathlib
import re
import sys

SPAN = re.compile(r'`([^`\n]+)`')
FIELD = re.compile(r'^[\w/\[\]]+\s+(\w+)\s*(?:#.*)?$', re.MULTILINE)
# advertise<Message>("name" and its like, with or without an argument before the name.
TOPIC = re.compile(r'(?:\b(?:advertise|subscribe|listen|serviceClient|key_frame_|loop_)\w*\s*(?:<[^;()]*?>)?'
                   r'\s*\(\s*(?:[\w.]+,\s*)*|\(\s*context_?,\s*)"(/?[a-z_]+)"')
PLACE = re.compile(r'^([\w./]+\.(?:cpp|hpp|py)):([\w:~]+)$')
FILE = re.compile(r'^(?:src|include|test|config|cmake|msg|srv|doc|scripts|examples|launch)/[\w./*<>-]*\w[\w.*/]*$')
# TEST(Suite, Name) and its like; Suite.Name or a file's name in a table.
TEST = re.compile(r'^TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)', re.MULTILINE)
TEST_NAME = re.compile(r'^(?:\w+\.\w+|(?:ros)?test_\w+)$')
TEST_TABLES = 'doc/reference/ancestors.md'
ROS_TOPICS = {'diagnostics', 'tf'}
WALK_LINES = 25


def sort_key(term):
    words = term.replace('`', '').lower().replace('_', ' ').replace('-', ' ')
    return words, term


def table_terms(text, heading):
    """First cells of the table below a heading."""
    part = text.split(heading, 1)[1].split('\n## ', 1)[0]
    rows = [line for line in part.splitlines() if line.startswith('| ')][1:]
    return [row.split('|')[1].strip() for row in rows]


def cells_of(line):
    """Of a row; a vertical bar with a backslash belongs to a cell."""
    return [cell.strip() for cell in re.split(r'(?<!\\)\|', line.strip())[1:-1]]


def row_problems(page, text):
    """Rows whose number of cells is not that of their table's first row."""
    wanted = None
    in_code = False
    for number, line in enumerate(text.splitlines(), 1):
        in_code ^= line.lstrip().startswith('```')
        if in_code or not line.startswith('|'):
            wanted = None
            continue
        count = len(cells_of(line))
        wanted = wanted or count
        if count != wanted:
            yield f'{page}:{number}: a row of {count} cells in a table of {wanted}'


def pages(root):
    return sorted([*root.glob('*.md'), *(root / 'doc').rglob('*.md')])


def names_of_messages(root):
    for path in sorted([*root.glob('msg/*.msg'), *root.glob('srv/*.srv')]):
        for name in FIELD.findall(path.read_text()):
            yield name, path.relative_to(root)


def names_of_topics(root):
    for folder in ('nodes', 'ros'):
        for path in sorted((root / 'src' / folder).rglob('*.cpp')):
            for name in TOPIC.findall(path.read_text()):
                yield name.lstrip('/'), path.relative_to(root)


def glossary_problems(root, text):
    for heading in ('# Glossary', '## Older words'):
        terms = table_terms(text, heading)
        for before, after in zip(terms, terms[1:]):
            if sort_key(before) > sort_key(after):
                yield f'doc/glossary.md: {after} has to stand before {before}'
    explained = {name for term in table_terms(text, '# Glossary') for name in SPAN.findall(term)}
    missing = {}
    for name, path in [*names_of_messages(root), *names_of_topics(root)]:
        if name not in explained and name not in ROS_TOPICS:
            missing.setdefault(name, path)
    for name, path in missing.items():
        yield f'doc/glossary.md: `{name}` of {path} is not explained'


def defines(text, name):
    """Whether a source file has the function or class: A::b, or b where it stands in a class A."""
    scope, _, last = name.rpartition('::')
    if not scope and re.search(rf'^\s*(class|struct|enum class|def) {last}\b(?!;)', text, re.MULTILINE):
        return True
    # A type goes before the name, and neither a keyword nor an assignment: a call is no definition.
    head = r'^ {0,2}(?!(?:if|for|while|else|return|throw|case|switch)\b)[A-Za-z][^=;().]*[ &*>]'
    if re.search(head + re.escape(name) + r'\(', text, re.MULTILINE):
        return True
    owner = scope.rpartition('::')[2]
    return bool(owner) and bool(re.search(rf'^ *(class|struct) {owner}\b(?!;)', text, re.MULTILINE)) \
        and bool(re.search(head + re.escape(last) + r'\(', text, re.MULTILINE))


def place_problems(root, page):
    for number, line in enumerate((root / page).read_text().splitlines(), 1):
        for span in SPAN.findall(line):
            place = PLACE.match(span)
            name = place.group(1) if place else span
            if (place or FILE.match(span)) and not list(root.glob(re.sub(r'<\w+>', '*', name))):
                yield f'{page}:{number}: {name} does not exist'
            elif place and not defines((root / name).read_text(), place.group(2)):
                yield f'{page}:{number}: {name} does not define {place.group(2)}'


def walk_problems(root):
    page = 'doc/walks.md'
    for walk in (root / page).read_text().split('\n## ')[1:]:
        lines = walk.rstrip().splitlines()
        if len(lines) > WALK_LINES:
            yield f'{page}: "{lines[0]}" has {len(lines)} lines; {WALK_LINES} are allowed'
        if not any(PLACE.match(span) for span in SPAN.findall(walk)):
            yield f'{page}: "{lines[0]}" names no function'


def names_of_tests(root):
    """Suite.Name of every test of googletest, and the names of the files."""
    for path in (root / 'test').rglob('*.cpp'):
        yield path.stem
        for suite, name in TEST.findall(path.read_text()):
            yield f'{suite}.{name}'


def test_problems(text, known):
    """Of tables whose last column is headed "test"."""
    in_table = False
    for number, line in enumerate(text.splitlines(), 1):
        cells = cells_of(line)
        if not line.startswith('|'):
            in_table = False
        elif cells[-1] == 'test':
            in_table = True
        elif in_table:
            for name in SPAN.findall(cells[-1]):
                if not TEST_NAME.match(name):
                    yield f'{TEST_TABLES}:{number}: {name} has not the form of a test (Suite.Name)'
                elif name not in known:
                    yield f'{TEST_TABLES}:{number}: there is no test {name}'


def check_the_check(root, glossary, known):
    """Stops if faults that are made on purpose are overlooked."""
    found = '\n'.join(glossary_problems(root, glossary.replace('`fitness`', '').replace('`points`', '')
                                        .replace('| azimuth', '| zimuth')))
    overlooked = [fault for fault in ('`fitness` of msg/', '`points` of src/nodes/', 'before zimuth')
                  if fault not in found]
    source = (root / 'src/back_end/optimization.cpp').read_text()
    overlooked += [name for name in ('no_such_function', 'BackEnd::solve', 'connect_segments', 'DriveGraph')
                   if defines(source, name)]  # the last two are used there only
    table = '| old | new | test |\n|---|---|---|\n| a | `b.c` | `LocalFrame.PointsEastNorthAndUp`, {} |\n'
    if list(test_problems(table.format('`test_local_frame`'), known)):
        overlooked.append('tests that are there')
    overlooked += [name for name in ('`LocalFrame.PointsEastNorthAndDown`', '`test_no_such_file`', '`test`')
                   if not list(test_problems(table.format(name), known))]
    rows = '| word | term |\n|---|---|\n| a \\| b | c |\n| `d` | e | f |\n\n| g |\n|---|\n'
    if list(row_problems('page', rows)) != ['page:4: a row of 3 cells in a table of 2']:
        overlooked.append('a row with a cell too many, or reports another row')
    if overlooked:
        sys.exit(f'check_names: overlooks {overlooked}; found:\n{found}')


def main(root):
    glossary = (root / 'doc/glossary.md').read_text()
    known = set(names_of_tests(root))
    check_the_check(root, glossary, known)
    problems = [*glossary_problems(root, glossary), *walk_problems(root),
                *test_problems((root / TEST_TABLES).read_text(), known)]
    for page in ('doc/walks.md', 'doc/architecture.md', 'CONTRIBUTING.md'):
        problems += place_problems(root, page)
    for page in pages(root):
        problems += row_problems(page.relative_to(root), page.read_text())
    print('\n'.join(problems + [f'names: {len(problems)} problems']))
    return 1 if problems else 0


if __name__ == '__main__':
    default = pathlib.Path(__file__).resolve().parent.parent
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else default))
