#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Reads the GeoTIFF or the GeoJSON files of a map with GDAL.

usage: read_gis_files.py geotiff FOLDER EPSG POINTS.txt PIXEL
       read_gis_files.py geojson FOLDER DRIVES LOOPS DOUBTS

POINTS.txt lists the points of the map: x y z intensity, in the system of the rasters (EPSG 0: in the map
frame). Ends with 77 where GDAL's Python module is not installed, and with 1 and a line where something is
not as it should be.
"""
import json
import pathlib
import sys

try:
    import numpy as np
    from osgeo import gdal, ogr, osr
except ImportError as missing:
    print(f'python3-gdal is not installed for this Python ({missing.name}): the files were not read')
    sys.exit(77)


def check(holds, problem):
    if not holds:
        sys.exit(problem)


def check_georeference(raster, epsg, name):
    system = osr.SpatialReference(raster.GetProjection()) if raster.GetProjection() else None
    if epsg == 0:
        check(system is None, f'{name} has a system without a datum')
        return
    check(system is not None and int(system.GetAuthorityCode(None)) == epsg, f'{name}: system {system}')


def check_geotiff(folder, epsg, points_file, pixel):
    points = np.loadtxt(points_file, ndmin=2)
    bands = {}
    for name in ('height', 'intensity', 'density'):
        raster = gdal.Open(str(folder / f'{name}.tif'))
        check(raster is not None, f'{name}.tif cannot be read')
        check_georeference(raster, epsg, name)
        west, width, _, north, _, height = raster.GetGeoTransform()
        check(width == pixel and height == -pixel, f'{name}: pixels of {width} by {height}')
        check(abs(west / pixel - round(west / pixel)) < 1e-6, f'{name} begins at {west}')
        bands[name] = raster.GetRasterBand(1).ReadAsArray()
    expected = {}
    for x, y, z, intensity in points:
        expected.setdefault((int((north - y) / pixel), int((x - west) / pixel)), []).append((z, intensity))
    check(np.count_nonzero(~np.isnan(bands['height'])) == len(expected), 'pixels with a height')
    for cell, values in expected.items():
        values = np.array(values)
        check(abs(bands['height'][cell] - values[:, 0].max()) < 2e-3, f'height of {cell}')
        check(abs(bands['intensity'][cell] - values[:, 1].mean()) < 1e-3, f'intensity of {cell}')
        check(abs(bands['density'][cell] - len(values) / pixel ** 2) < 1e-3, f'density of {cell}')
    total = bands['density'].sum(dtype=float) * pixel ** 2
    check(abs(total - len(points)) < 1e-3 * len(points), f'{total} points by the density')
    print(f'{bands["height"].shape[1]} by {bands["height"].shape[0]} pixels')


def check_geojson(folder, drives, loops, doubts):
    for name, wanted in (('trajectory', drives), ('loops', loops), ('doubt', doubts)):
        path = folder / f'{name}.geojson'
        collection = json.loads(path.read_text())
        check(collection['type'] == 'FeatureCollection', f'{name}: {collection["type"]}')
        check(len(collection['features']) == wanted, f'{name}: {len(collection["features"])} features')
        source = ogr.Open(str(path))
        check(source is not None, f'{name}.geojson cannot be read')
        layer = source.GetLayer(0)
        check(layer.GetFeatureCount() == wanted, f'{name}: GDAL reads {layer.GetFeatureCount()}')
        for feature in layer:
            envelope = feature.GetGeometryRef().GetEnvelope()
            check(-180 <= envelope[0] <= envelope[1] <= 180 and -90 <= envelope[2] <= envelope[3] <= 90,
                  f'{name}: {envelope} are no degrees')


def main():
    kind, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    if kind == 'geotiff':
        check_geotiff(folder, int(sys.argv[3]), sys.argv[4], float(sys.argv[5]))
    else:
        check_geojson(folder, *map(int, sys.argv[3:6]))


if __name__ == '__main__':
    main()
