#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds what scripts/check_documentation.py puts back before it runs a block of commands once more.

check_snapshot.py: the working folder is test/
"""
import os
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / 'scripts'))
import check_documentation  # noqa: E402


class Snapshot(unittest.TestCase):
    def test_puts_folders_back(self):
        with tempfile.TemporaryDirectory() as temporary:
            home, work = pathlib.Path(temporary) / 'home', pathlib.Path(temporary) / 'work'
            for folder in (home, work):
                folder.mkdir()
                (folder / 'file').write_text('before')
                (folder / 'latest').symlink_to('file')
            with check_documentation.snapshot(home, work) as restore:
                (home / 'file').write_text('after')
                (home / 'dump').mkdir()
                (home / 'dump' / 'data').write_text('')
                (work / 'latest').unlink()
                (work / 'latest').symlink_to('elsewhere')
                (work / 'file').unlink()
                restore()
            for folder in (home, work):
                self.assertEqual(sorted(os.listdir(folder)), ['file', 'latest'])
                self.assertEqual((folder / 'file').read_text(), 'before')
                self.assertEqual(os.readlink(folder / 'latest'), 'file')


if __name__ == '__main__':
    unittest.main()
