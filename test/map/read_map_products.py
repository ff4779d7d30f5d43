#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Reads map products as their formats are published, with nothing of the package.

usage: read_map_products.py FOLDER

FOLDER has map.las, points.txt (the points that must be in it: x y z, in their order), grid.pgm and
grid.yaml, top_view.png and top_view.pgw, and pointcloud_map/. Ends with 1 and a line where
something is not as it should be.
"""
import pathlib
import re
import struct
import sys


def check(holds, problem):
    if not holds:
        sys.exit(problem)


def read_las(path):
    """Points of a LAS file of version 1.0 to 1.3 (ASPRS), point formats 0 to 3."""
    data = path.read_bytes()
    check(data[:4] == b'LASF', 'no LAS signature')
    check(data[24:26] == b'\x01\x02', 'not version 1.2')
    offset, records, point_format, size, count = struct.unpack_from('<IIBHI', data, 96)
    check(struct.unpack_from('<H', data, 94)[0] == 227, 'header size')
    check(point_format == 0 and size == 20, 'point format')
    check(sum(struct.unpack_from('<5I', data, 111)) == count, 'points by return')
    scale, shift = struct.unpack_from('<3d', data, 131), struct.unpack_from('<3d', data, 155)
    bounds = struct.unpack_from('<6d', data, 179)
    points = []
    for i in range(count):
        raw = struct.unpack_from('<3i', data, offset + i * size)
        points.append([r * s + o for r, s, o in zip(raw, scale, shift)])
    for axis in range(3):
        values = [p[axis] for p in points]
        check(abs(max(values) - bounds[2 * axis]) < 1e-3, 'upper bound of axis %d' % axis)
        check(abs(min(values) - bounds[2 * axis + 1]) < 1e-3, 'lower bound of axis %d' % axis)
    check(len(data) == offset + count * size, 'length of the file')
    return points, records


def check_las(folder):
    points, _ = read_las(folder / 'map.las')
    lines = (folder / 'points.txt').read_text().split('\n')
    expected = [[float(word) for word in line.split()] for line in lines if line]
    check(len(points) == len(expected), '%d points in map.las' % len(points))
    for point, wanted in zip(points, expected):
        error = max(abs(a - b) for a, b in zip(point, wanted))
        check(error < 1e-3, 'map.las: %s instead of %s' % (point, wanted))


def read_yaml_fields(path):
    """The lines "name: value" of a flat file."""
    return dict(re.findall(r'^([^\s:#]+): *(.*)$', path.read_text(), re.MULTILINE))


def check_grid(folder):
    """What map_server needs."""
    fields = read_yaml_fields(folder / 'grid.yaml')
    names = {'image', 'resolution', 'origin', 'negate', 'occupied_thresh', 'free_thresh'}
    check(names <= set(fields), 'grid.yaml lacks %s' % (names - set(fields)))
    check(len(fields['origin'].strip('[]').split(',')) == 3, 'origin has x, y and yaw')
    check(float(fields['resolution']) > 0.0 and fields['negate'] == '0', 'resolution, negate')
    check(0.0 < float(fields['free_thresh']) < float(fields['occupied_thresh']) < 1.0, 'limits')
    data = (folder / fields['image']).read_bytes()
    head = re.match(rb'P5\s(?:#[^\n]*\n)*(\d+)\s+(\d+)\s+255\s', data)
    check(head is not None, 'grid.pgm is no binary PGM')
    width, height = int(head.group(1)), int(head.group(2))
    check(len(data) == head.end() + width * height, 'size of grid.pgm')
    check(set(data[head.end():]) <= {0, 205, 254}, 'values of grid.pgm')


def check_picture(folder):
    data = (folder / 'top_view.png').read_bytes()
    check(data[:8] == b'\x89PNG\r\n\x1a\n' and data[-8:-4] == b'IEND', 'top_view.png is cut')
    width, height = struct.unpack('>II', data[16:24])
    check(width > 0 and height > 0, 'size of top_view.png')
    world = [float(line) for line in (folder / 'top_view.pgw').read_text().split()]
    check(len(world) == 6 and world[0] > 0.0 and world[3] == -world[0], 'world file')
    check(world[1] == 0.0 and world[2] == 0.0, 'world file is turned')


def check_tiles(folder):
    fields = read_yaml_fields(folder / 'pointcloud_map_metadata.yaml')
    size = float(fields.pop('x_resolution'))
    check(float(fields.pop('y_resolution')) == size, 'square tiles')
    check(fields, 'there are no tiles')
    check({p.name for p in folder.glob('*.pcd')} == set(fields), 'files and metadata differ')
    for name, corner in fields.items():
        check(len(corner.strip('[]').split(',')) == 2, 'corner of ' + name)
        head = (folder / name).read_bytes()[:400]
        check(b'FIELDS x y z intensity' in head and b'DATA binary' in head, name)


def main():
    folder = pathlib.Path(sys.argv[1])
    check_las(folder)
    check_grid(folder)
    check_picture(folder)
    check_tiles(folder / 'pointcloud_map')


if __name__ == '__main__':
    main()
