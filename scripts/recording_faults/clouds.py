# SPDX-License-Identifier: BSD-3-Clause
"""Faults of what clouds hold: units, axes, frames, points and scans that are missing or added."""
import math

import numpy as np
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from recording_faults.points import each_cloud, points_of, set_points, with_scaled_axes
from recording_faults.records import (CLOUDS, LIDAR_POSITION, SWEEP, TRUTH, Record, messages_of,
                                      shift_stamp, time_of, without)
from recording_faults.variants import variant


# Units and axes

@variant("clouds")
def points_in_millimetres(records):
    return with_scaled_axes(records, x=1000.0, y=1000.0, z=1000.0)


@variant("clouds")
def points_in_centimetres(records):
    return with_scaled_axes(records, x=100.0, y=100.0, z=100.0)


@variant("all")
def y_to_the_right(records):
    """A driver with axes of the left hand: everything is mirrored."""
    return with_scaled_axes(records, y=-1.0)


@variant("all")
def lidar_turned_by_90_degrees_without_a_word(records):
    def change(points, _):
        points["x"], points["y"] = points["y"].copy(), -points["x"]
        return points
    return each_cloud(records, change)


@variant("all")
def lidar_upside_down_without_a_word(records):
    return with_scaled_axes(records, y=-1.0, z=-1.0)


# A fixed frame

def rotation_matrix(q):
    x, y, z, w = q.x, q.y, q.z, q.w
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def true_poses(clean):
    """Poses of base_link by the nanoseconds of their stamps."""
    return {message.header.stamp.to_nsec(): message.pose.pose
            for message in messages_of(clean, TRUTH)}


def in_fixed_frame(records, poses, frame):
    """The clouds as if somebody had moved their points to the frame of the poses."""
    for cloud in messages_of(records, CLOUDS):
        pose = poses[cloud.header.stamp.to_nsec()]
        points = points_of(cloud)
        xyz = np.stack([points[axis] + way for axis, way in zip("xyz", LIDAR_POSITION)], 1)
        xyz = xyz @ rotation_matrix(pose.orientation).T
        xyz += [pose.position.x, pose.position.y, pose.position.z]
        points["x"], points["y"], points["z"] = xyz.T
        cloud.header.frame_id = frame
        set_points(cloud, points)
    return records


@variant("clouds", beside_clean=True)
def clouds_in_a_world_without_tf(records, clean):
    return in_fixed_frame(records, true_poses(clean), "map")


@variant("clouds", beside_clean=True)
def clouds_in_a_world_with_tf(records, clean):
    poses = true_poses(clean)
    moves = []
    for stamp, pose in poses.items():
        t = TransformStamped()
        t.header.frame_id, t.child_frame_id = "odom", "base_link"
        t.header.stamp = time_of(stamp)
        t.transform.translation.x, t.transform.translation.y = pose.position.x, pose.position.y
        t.transform.translation.z, t.transform.rotation = pose.position.z, pose.orientation
        moves.append(Record("/tf", TFMessage([t]), stamp * 1e-9))
    return in_fixed_frame(records, poses, "odom") + moves


# Too many clouds, or their parts

def each_cloud_as(records, replacements):
    """The recording with replacements(record) in the place of each cloud."""
    return [replacement for record in records
            for replacement in (replacements(record) if record.topic == CLOUDS else [record])]


@variant("clouds")
def two_lidars_on_one_topic(records):
    def both(record):
        other = record.copy()
        points = points_of(other.message)
        points["x"] -= 2.0
        set_points(other.message, points[::2].copy())
        other.message.header.frame_id = "rear"
        shift_stamp(other.message, 0.003)
        other.time += 0.003
        return [record, other]
    return each_cloud_as(records, both)


@variant("clouds")
def every_cloud_twice(records):
    return each_cloud_as(records, lambda record: [record, record.copy()])


@variant("clouds")
def sectors_of_36_degrees_as_messages(records):
    step = SWEEP / 10

    def sector(record, points, part):
        result = record.copy()
        cut = points[(points["time"] >= step * part) & (points["time"] < step * (part + 1))]
        cut["time"] -= step * part
        set_points(result.message, cut)
        shift_stamp(result.message, step * part)
        result.time += step * (part - 9)
        return result

    def sectors(record):
        points = points_of(record.message)
        return [sector(record, points, part) for part in range(10)]
    return each_cloud_as(records, sectors)


@variant("clouds")
def two_turns_in_each_message(records):
    held = []

    def both(record):
        held.append(record)
        if len(held) < 2:
            return []
        first, second = held
        held.clear()
        later = points_of(second.message)
        later["time"] += SWEEP
        set_points(first.message, np.concatenate([points_of(first.message), later]))
        first.time = second.time
        return [first]
    return each_cloud_as(records, both)


# Parts that are missing

@variant("clouds")
def half_of_the_view(records):
    return each_cloud(records, lambda points, _: points[points["x"] > 0.0])


@variant("clouds")
def every_second_packet_missing(records):
    """A turn of a VLP-16 is about 75 packets."""
    return each_cloud(records, lambda points, _: points[
        np.floor(points["time"] / SWEEP * 75).astype(int) % 2 == 0])


@variant("clouds")
def every_second_scan_missing(records):
    return without(records, CLOUDS, lambda record, index: index % 2 == 0)


@variant("clouds")
def half_of_the_scans_missing_at_random(records):
    noise = np.random.default_rng(1)
    return without(records, CLOUDS, lambda record, index: noise.random() >= 0.5)


@variant("clouds")
def sparse_points(records):
    return each_cloud(records, lambda points, _: points[::40].copy())


@variant("clouds")
def first_scans_empty(records):
    return each_cloud(records, lambda points, index: points[:0] if index < 20 else points)


# Points of the vehicle

def with_points_of_vehicle(records, fraction, place):
    """Adds a fraction of the number of points, where place(noise, added) puts them."""
    def change(points, index):
        noise = np.random.default_rng(index)
        added = np.zeros(int(fraction * len(points)), points.dtype)
        place(noise, added)
        added["time"] = np.sort(noise.uniform(0.0, 0.0999, len(added)))
        return np.concatenate([points, added])
    return each_cloud(records, change)


@variant("clouds")
def roof_of_the_vehicle_in_each_scan(records):
    def place(noise, roof):
        roof["x"] = noise.uniform(-2.2, 1.2, len(roof))
        roof["y"] = noise.uniform(-0.8, 0.8, len(roof))
        roof["z"] = noise.normal(-0.25, 0.01, len(roof))
    return with_points_of_vehicle(records, 0.2, place)


@variant("clouds")
def vehicle_with_a_frame_around_the_sensor(records):
    """A rack at 3 m on all sides, which moves with the sensor: 40 % of the points."""
    def place(noise, rack):
        angle = noise.integers(0, 8, len(rack)) * math.pi / 4
        angle += noise.uniform(-0.05, 0.05, len(rack))
        rack["x"], rack["y"] = 3.0 * np.cos(angle), 3.0 * np.sin(angle)
        rack["z"] = noise.uniform(-1.5, 1.0, len(rack))
    return with_points_of_vehicle(records, 0.4, place)
