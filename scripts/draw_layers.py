#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Write the table of stages of check_layering.py into doc/architecture.md, and draw it as a picture.

usage: draw_layers.py [--check]     --check: says whether they are up to date, and changes nothing
"""
import pathlib
import sys

from check_layering import ROS_STAGES, STAGES

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / 'doc' / 'architecture.md'
PICTURE = ROOT / 'doc' / 'images' / 'layers.svg'
BEGIN, END = '<!-- stages: scripts/draw_layers.py -->\n', '<!-- end of stages -->\n'
WIDTH, HEIGHT, GAP_X, GAP_Y, MARGIN = 132, 44, 14, 46, 12


def below(stage):
    return STAGES[stage][1]


def direct(stage):
    """The stages below that no other stage below includes already."""
    indirect = set().union(*(below(other) for other in below(stage))) if below(stage) else set()
    return below(stage) - indirect


def row_of(stage):
    """Rows are counted from the top: a stage is one row below the lowest that includes it directly."""
    return 1 + max((row_of(user) for user in STAGES if stage in direct(user)), default=-1)


def table():
    lines = ['| stage | what it is | may include |', '|---|---|---|']
    for stage, (meaning, allowed) in STAGES.items():
        names = ', '.join(f'`{other}`' for other in STAGES if other in direct(stage))
        if allowed - direct(stage):
            names += ', and what these may'
        lines.append(f'| `{stage}` | {meaning} | {names or "nothing"} |')
    return '\n'.join(lines) + '\n'


def places():
    """Upper left corner of each stage's box; a stage alone in its row is below the middle of its users."""
    rows = {}
    for stage in STAGES:
        rows.setdefault(row_of(stage), []).append(stage)
    step = WIDTH + GAP_X
    widest = max(len(row) for row in rows.values())
    result = {}
    for number in sorted(rows):
        row = rows[number]
        left = MARGIN + (widest - len(row)) * step / 2
        above = [result[user][0] for user in result if row[0] in direct(user)]
        if len(row) == 1 and above:
            left = sum(above) / len(above)
        for i, stage in enumerate(row):
            result[stage] = (left + i * step, MARGIN + number * (HEIGHT + GAP_Y))
    return result


def picture():
    at = places()
    width = max(x for x, _ in at.values()) + WIDTH + MARGIN
    height = max(y for _, y in at.values()) + HEIGHT + MARGIN
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
             f'viewBox="0 0 {width:.0f} {height:.0f}" font-family="sans-serif">',
             '<rect width="100%" height="100%" fill="white"/>']
    for stage in STAGES:
        for other in sorted(direct(stage)):
            (x1, y1), (x2, y2) = at[stage], at[other]
            parts.append(f'<path d="M{x1 + WIDTH / 2:.0f} {y1 + HEIGHT:.0f}'
                         f'C{x1 + WIDTH / 2:.0f} {y1 + HEIGHT + 30:.0f} {x2 + WIDTH / 2:.0f} {y2 - 30:.0f} '
                         f'{x2 + WIDTH / 2:.0f} {y2:.0f}" fill="none" stroke="#9aa5b1" stroke-width="1.5"/>')
    for stage, (x, y) in at.items():
        fill = '#fde9d0' if stage in ROS_STAGES else '#dbe9f6'
        parts.append(f'<rect x="{x:.0f}" y="{y:.0f}" width="{WIDTH}" height="{HEIGHT}" rx="6" '
                     f'fill="{fill}" stroke="#5b6b7b"/>')
        parts.append(f'<text x="{x + WIDTH / 2:.0f}" y="{y + HEIGHT / 2 + 5:.0f}" text-anchor="middle" '
                     f'font-size="15" fill="#1f2933">{stage}</text>')
    return '\n'.join(parts + ['</svg>']) + '\n'


def main():
    page = PAGE.read_text()
    head, rest = page.split(BEGIN)
    tail = rest.split(END)[1]
    wanted = {PAGE: head + BEGIN + table() + END + tail, PICTURE: picture()}
    old = [path for path, text in wanted.items() if not path.exists() or path.read_text() != text]
    if '--check' not in sys.argv[1:]:
        for path in old:
            path.write_text(wanted[path])
        return 0
    for path in old:
        print(f'{path.relative_to(ROOT)} is not up to date: scripts/draw_layers.py writes it')
    return 1 if old else 0


if __name__ == '__main__':
    sys.exit(main())
