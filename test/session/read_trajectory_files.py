#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds trajectory files against what evo and other tools expect, with nothing of the package.

usage: read_trajectory_files.py FOLDER   (with *.tum and *.txt)

TUM: stamp x y z qx qy qz qw with rising stamps and unit quaternions; KITTI: the 12 numbers of [R|t]
with a rotation in it. Ends with 1 and a line where something is not as it should be.
"""
import pathlib
import sys


def check(holds, problem):
    if not holds:
        sys.exit(problem)


def rows_of(path, columns):
    rows = [line.split(' ') for line in path.read_text().split('\n') if line]
    check(rows, '%s is empty' % path)
    for row in rows:
        check(len(row) == columns, '%s: %d columns' % (path, len(row)))
    return [[float(cell) for cell in row] for row in rows]


def check_tum(path):
    rows = rows_of(path, 8)
    stamps = [row[0] for row in rows]
    check(all(a < b for a, b in zip(stamps, stamps[1:])), '%s: stamps do not rise' % path)
    for row in rows:
        norm = sum(value * value for value in row[4:])
        check(abs(norm - 1.0) < 1e-6, '%s: quaternion of squared length %f' % (path, norm))


def check_kitti(path):
    for row in rows_of(path, 12):
        axes = [row[0:3], row[4:7], row[8:11]]
        for i in range(3):
            for j in range(3):
                product = sum(a * b for a, b in zip(axes[i], axes[j]))
                check(abs(product - float(i == j)) < 1e-6, '%s: no rotation' % path)


def main():
    folder = pathlib.Path(sys.argv[1])
    tum, kitti = sorted(folder.glob('*.tum')), sorted(folder.glob('*.txt'))
    check(tum and kitti, 'no files')
    for path in tum:
        check_tum(path)
    for path in kitti:
        check_kitti(path)


if __name__ == '__main__':
    main()
