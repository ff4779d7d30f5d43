# SPDX-License-Identifier: BSD-3-Clause
"""Faults of the layout of clouds: types and order of fields, rows, points without a return."""
import numpy as np

from recording_faults.points import (XYZ, XYZI, each_cloud, each_cloud_with_types, points_of,
                                     set_points, with_types)
from recording_faults.records import CLOUDS, messages_of
from recording_faults.variants import variant

TIME = [("time", "f4")]


@variant("clouds")
def coordinates_of_float64(records):
    doubles = [(name, "f8") for name, _ in XYZ]
    return each_cloud_with_types(records, doubles + [("intensity", "f4")] + TIME)


@variant("clouds")
def fields_in_odd_order_with_padding(records):
    types = [("time", "f4"), ("z", "f4"), ("intensity", "f4"), ("x", "f4"), ("y", "f4")]
    return each_cloud_with_types(records, types, [5, 12, 17, 24, 31], 48)


@variant("clouds")
def intensity_of_uint8(records):
    return each_cloud_with_types(records, XYZ + [("intensity", "u1")] + TIME)


@variant("clouds")
def intensity_missing(records):
    return each_cloud_with_types(records, XYZ + TIME)


@variant("clouds")
def ring_as_float(records):
    def change(points, _):
        result = with_types(points, XYZI + [("ring", "f4")] + TIME)
        result["ring"] = np.arange(len(points)) % 16
        return result
    return each_cloud(records, change)


def with_lost_points(records, lose):
    """Changes 3 of 10 points, chosen at random, by lose(points, which)."""
    def change(points, index):
        lose(points, np.random.default_rng(index).random(len(points)) < 0.3)
        return points
    return each_cloud(records, change)


def set_coordinates(points, which, value):
    for axis in "xyz":
        points[axis][which] = value


@variant("clouds")
def points_not_finite(records):
    return with_lost_points(records, lambda points, lost: set_coordinates(points, lost, np.nan))


@variant("clouds")
def points_without_return_at_the_origin(records):
    return with_lost_points(records, lambda points, lost: set_coordinates(points, lost, 0.0))


@variant("clouds")
def points_without_return_at_maximal_range(records):
    def lose(points, lost):
        scale = 120.0 / np.sqrt(points["x"] ** 2 + points["y"] ** 2 + points["z"] ** 2)
        for axis in "xyz":
            points[axis][lost] *= scale[lost]
    return with_lost_points(records, lose)


@variant("clouds")
def organised_and_said_to_be_dense(records):
    """In 16 rows, the last of which ends with points that are no numbers."""
    rows = 16
    for cloud in messages_of(records, CLOUDS):
        points = points_of(cloud)
        padded = np.zeros(-(-len(points) // rows) * rows, points.dtype)
        set_coordinates(padded, slice(None), np.nan)
        padded[:len(points)] = points
        set_points(cloud, padded, rows)
        cloud.is_dense = True
    return records


@variant("clouds")
def width_and_height_swapped(records):
    """A column of points: height N, width 1."""
    for cloud in messages_of(records, CLOUDS):
        cloud.height, cloud.width = cloud.width, 1
        cloud.row_step = cloud.point_step
    return records


@variant("clouds")
def row_step_zero(records):
    for cloud in messages_of(records, CLOUDS):
        cloud.row_step = 0
    return records
