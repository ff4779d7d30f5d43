#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""What README.md and the pages of doc/ hold: commands, inline code, links. See check_documentation.py.

usage: pages.py PAGE HEADING PROGRAM    prints the bash block under the heading that begins with the program
"""
import dataclasses
import pathlib
import re
import sys

FENCE = re.compile(r'^\s*```(\w*)')
SPAN = re.compile(r'`([^`\n]+)`')
LINK = re.compile(r'\]\(([^)\s]+)\)')
HEADING = re.compile(r'^#+\s+(.*)')
ROS_COMMAND = re.compile(r'^(rosrun|roslaunch|rosservice|rosbag|rostopic|rosnode|rosparam|catkin_make)\s')


@dataclasses.dataclass
class Text:
    """A piece of a page and where it stands."""
    page: str
    line: int
    text: str

    def __str__(self):
        return f'{self.page}:{self.line}: {self.text}'


class Page:
    """A page, taken apart line by line."""

    def __init__(self, path, name):
        self.name = name
        self.lines = path.read_text().splitlines()
        self.blocks = []     # of bash: lists of commands
        self.block_headings = []
        self.misplaced = []  # commands that stand in another kind of block
        self.prose = []
        self.headings = []
        self._take_apart()

    def _take_apart(self):
        language = None
        for number, line in enumerate(self.lines, 1):
            fence = FENCE.match(line)
            if fence:
                language = None if language is not None else fence.group(1)
                if language == 'bash':
                    self.blocks.append([])
                    self.block_headings.append(self.headings[-1] if self.headings else '')
                continue
            self._take_line(Text(self.name, number, line), language)

    def _take_line(self, line, language):
        if language == 'bash':
            self._add_command(line)
        elif language is not None or line.text.startswith('    '):
            if ROS_COMMAND.match(line.text.strip()):
                self.misplaced.append(line)
        else:
            self.prose.append(line)
            heading = HEADING.match(line.text)
            if heading:
                self.headings.append(heading.group(1))

    def _add_command(self, line):
        block = self.blocks[-1]
        if block and block[-1].text.endswith('\\'):
            block[-1].text += '\n' + line.text
        elif line.text.strip() and not line.text.lstrip().startswith('#'):
            block.append(line)

    def spans(self):
        """Inline code."""
        return [Text(line.page, line.line, span) for line in self.prose for span in SPAN.findall(line.text)]

    def links(self):
        return [Text(line.page, line.line, link) for line in self.prose
                for link in LINK.findall(SPAN.sub('', line.text))]

    def anchors(self):
        """The names under which headings can be linked to."""
        words = (re.sub(r'[^\w\- ]', '', heading.lower()) for heading in self.headings)
        return {word.strip().replace(' ', '-') for word in words}


def main(path, heading, program):
    page = Page(pathlib.Path(path), path)
    for block, above in zip(page.blocks, page.block_headings):
        if above == heading and block[0].text.startswith(program + ' '):
            print('\n'.join(command.text for command in block))
            return 0
    return f'{path} has no block of {program} under {heading}'


if __name__ == '__main__':
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
