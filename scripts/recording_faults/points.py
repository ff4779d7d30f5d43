# SPDX-License-Identifier: BSD-3-Clause
"""The points of PointCloud2 messages as arrays of NumPy, and back."""
import numpy as np
from sensor_msgs.msg import PointField

from recording_faults.records import CLOUDS, messages_of

TYPES = {"f4": PointField.FLOAT32, "f8": PointField.FLOAT64, "u1": PointField.UINT8,
         "u2": PointField.UINT16, "u4": PointField.UINT32}
XYZ = [("x", "f4"), ("y", "f4"), ("z", "f4")]
XYZI = XYZ + [("intensity", "f4")]


def points_of(cloud):
    """The points of a message, with its fields."""
    names = {number: name for name, number in TYPES.items()}
    return np.frombuffer(cloud.data, np.dtype({
        "names": [field.name for field in cloud.fields],
        "formats": ["<" + names[field.datatype] for field in cloud.fields],
        "offsets": [field.offset for field in cloud.fields], "itemsize": cloud.point_step})).copy()


def set_points(cloud, points, height=1):
    """Replaces the points of a message, and its fields by those of the points."""
    cloud.fields = [PointField(name, points.dtype.fields[name][1],
                               TYPES[points.dtype.fields[name][0].str[1:]], 1)
                    for name in points.dtype.names]
    cloud.point_step = points.dtype.itemsize
    cloud.height, cloud.width = height, len(points) // height
    cloud.row_step = cloud.width * cloud.point_step
    cloud.data = points.tobytes()


def with_types(points, types, offsets=None, size=None):
    """The points with these fields [(name, type)]; those that the points do not have are 0."""
    names, formats = zip(*types)
    layout = {"names": names, "formats": ["<" + kind for kind in formats]}
    if offsets:
        layout.update(offsets=offsets, itemsize=size)
    result = np.zeros(len(points), np.dtype(layout))
    for name in names:
        if name in points.dtype.names:
            result[name] = points[name]
    return result


def each_cloud(records, change):
    """Replaces the points of each cloud by change(points, index of the cloud)."""
    for index, cloud in enumerate(messages_of(records, CLOUDS)):
        set_points(cloud, change(points_of(cloud), index))
    return records


def each_cloud_with_types(records, types, offsets=None, size=None):
    return each_cloud(records, lambda points, _: with_types(points, types, offsets, size))


def with_scaled_axes(records, **factors):
    """The clouds with coordinates that are multiplied: x=-1.0 mirrors them."""
    def change(points, _):
        for axis, factor in factors.items():
            points[axis] *= factor
        return points
    return each_cloud(records, change)
