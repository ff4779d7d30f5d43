#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Reads Entwine Point Tiles as their specification says, with nothing of the package.

usage: read_ept.py FOLDER [POINTS.txt]

Every node of the hierarchy has its file with so many points, they lie in its part of the cube, a node has
an ancestor, no file is left over, and all points together are as many as ept.json says. POINTS.txt lists
what has to be in them, in any order: x y z intensity drive time (m, of 65535, number, s). Ends with 1 and
a line where something is not as it should be.
"""
import json
import pathlib
import sys

import numpy as np

LETTERS = {'signed': 'i', 'unsigned': 'u', 'float': 'f'}


def check(holds, problem):
    if not holds:
        sys.exit(problem)


def read_hierarchy(folder, root='0-0-0-0'):
    """Number of points of each node; -1 stands for a file of its own."""
    counts = {}
    for name, count in json.loads((folder / 'ept-hierarchy' / f'{root}.json').read_text()).items():
        if count == -1 and name != root:
            below = read_hierarchy(folder, name)
            check(below.get(name, 0) > 0, f'{name}: its hierarchy lacks it')
            counts.update(below)
        else:
            check(count > 0, f'{name} has {count} points')
            counts[name] = count
    return counts


def coordinates(points, schema):
    axes = [next(d for d in schema if d['name'] == axis) for axis in 'XYZ']
    return np.stack([points[d['name']] * d['scale'] + d['offset'] for d in axes], axis=1)


def parent(name):
    depth, *numbers = map(int, name.split('-'))
    return '-'.join(map(str, [depth - 1] + [number // 2 for number in numbers]))


def check_metadata(ept):
    bounds, conforming = np.array(ept['bounds']), np.array(ept['boundsConforming'])
    edges = bounds[3:] - bounds[:3]
    check(np.allclose(edges, edges[0], atol=1e-6), f'the bounds are no cube: {edges}')
    check((bounds[:3] <= conforming[:3] + 1e-9).all() and (conforming[3:] <= bounds[3:] + 1e-9).all(),
          'the bounds do not contain the conforming ones')
    check(ept['dataType'] == 'binary' and ept['hierarchyType'] == 'json', 'types of the files')
    check(ept['version'] == '1.0.0' and ept['span'] > 0, 'version, span')
    for dimension in ept['schema']:
        check(dimension['size'] in (1, 2, 4, 8) and dimension['type'] in LETTERS, str(dimension))


def check_system(srs):
    """The text and the code are the same system; GDAL decides."""
    if not srs:
        return
    try:
        from osgeo import osr
    except ImportError:
        print('python3-gdal is not installed: the system is not compared')
        return
    osr.UseExceptions()
    by_text, by_code = osr.SpatialReference(), osr.SpatialReference()
    check(by_text.SetFromUserInput(srs['wkt']) == 0, 'the well-known text')
    by_code.ImportFromEPSG(int(srs['horizontal']))
    options = ['IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES', 'CRITERION=EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS']
    check(by_text.IsSame(by_code, options), f'EPSG {srs["horizontal"]} is not {srs["wkt"]}')


def read_points(folder, ept, counts):
    layout = np.dtype([(d['name'], f'<{LETTERS[d["type"]]}{d["size"]}') for d in ept['schema']])
    low, edge = np.array(ept['bounds'][:3]), ept['bounds'][3] - ept['bounds'][0]
    nodes = []
    for name, count in counts.items():
        points = np.fromfile(folder / 'ept-data' / f'{name}.bin', layout)
        check(len(points) == count, f'{name} has {len(points)} points, its hierarchy says {count}')
        depth, *numbers = map(int, name.split('-'))
        check(depth == 0 or parent(name) in counts, f'{name} has no parent')
        size = edge / 2 ** depth
        corner = low + size * np.array(numbers)
        xyz = coordinates(points, ept['schema'])
        inside = ((xyz >= corner - 1e-6) & (xyz < corner + size - 1e-6)).all(axis=1)
        check(inside.all(), f'{name}: {np.count_nonzero(~inside)} points outside of it')
        nodes.append(points)
    return np.concatenate(nodes)


def check_statistics(points, ept):
    for dimension in ept['schema']:
        values = points[dimension['name']] * dimension.get('scale', 1.0) + dimension.get('offset', 0.0)
        # Intensities are rounded after their statistics were taken.
        tolerance = 1.0 if dimension['name'] == 'Intensity' else 1e-6
        for name, value in (('minimum', values.min()), ('maximum', values.max())):
            check(abs(dimension[name] - value) <= tolerance, f'{dimension["name"]}: {name} {value}, {dimension[name]} by ept.json')
        check(dimension['count'] == len(points), dimension['name'] + ': count')
        check(abs(dimension['mean'] - values.mean()) < max(tolerance, 1e-3), dimension['name'] + ': mean')


def check_expected(points, ept, path):
    expected = np.loadtxt(path, ndmin=2)
    found = np.column_stack([coordinates(points, ept['schema']), points['Intensity'], points['PointSourceId'], points['GpsTime']])
    check(len(found) == len(expected), f'{len(found)} points in place of {len(expected)}')
    keys = [np.rint(values[:, :3] * 1000).astype(np.int64) for values in (found, expected)]
    orders = [np.lexsort((values[:, 5], values[:, 4], values[:, 3], *key.T)) for values, key in zip((found, expected), keys)]
    error = np.abs(found[orders[0]] - expected[orders[1]]).max(axis=0)
    check((error[:3] < 1.1e-3).all() and error[3] <= 1.0 and error[4] == 0 and error[5] < 1e-6,
          f'largest differences of x y z intensity drive time: {error}')


def main():
    folder = pathlib.Path(sys.argv[1])
    ept = json.loads((folder / 'ept.json').read_text())
    check_metadata(ept)
    check_system(ept['srs'])
    counts = read_hierarchy(folder)
    files = {path.stem for path in (folder / 'ept-data').iterdir()}
    check(files == set(counts), f'files and hierarchy differ: {sorted(files ^ set(counts))[:5]}')
    check(sum(counts.values()) == ept['points'], f'{sum(counts.values())} points, ept.json says {ept["points"]}')
    points = read_points(folder, ept, counts)
    check_statistics(points, ept)
    if len(sys.argv) > 2:
        check_expected(points, ept, sys.argv[2])
    levels = [sum(n for name, n in counts.items() if name.startswith(f'{d}-')) for d in range(15)]
    print(f'{ept["points"]} points in {len(counts)} nodes, by level: {[n for n in levels if n > 0]}')


if __name__ == '__main__':
    main()
