#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Spoils a simulated recording in the ways in which real ones are spoilt, maps each with the
defaults and says whether the map is good or the user was told what is wrong.

    scripts/spoilt_recordings.py --output /tmp/spoilt
    scripts/spoilt_recordings.py --output /tmp/spoilt --only times_ gnss_frozen

A result that is in the output folder already is kept: delete results.jsonl for new ones. Verdicts:
    good    the map is as exact as that of the clean recording, and nothing was said
    alarm   the map is as exact, and something was said: its text shows whether rightly
    named   the map is worse or missing, and check_bag or map_bag said something: read what
    SILENT  the map is worse, and nothing was said
    CRASH   a program was ended by a signal
"""

import argparse
import copy
import json
import math
import os
import shutil
import subprocess
import sys

import genpy
import numpy as np
import rosbag
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image, PointField
from tf2_msgs.msg import TFMessage

CLOUDS = "/kitti/velo/pointcloud"
IMU = "/kitti/oxts/imu"
VELOCITY = "/kitti/oxts/gps/vel"
GNSS = "/kitti/oxts/gps/fix"
STATIC = "/tf_static"
SENSORS = {
    "clouds": [CLOUDS],
    "imu": [CLOUDS, IMU],
    "velocity": [CLOUDS, VELOCITY],
    "gnss": [CLOUDS, GNSS],
    "all": [CLOUDS, IMU, VELOCITY, GNSS],
}
LIDAR_TO_BASE = [-0.76, -0.02, -1.73]  # m, base_link in the frame of the simulated LiDAR
UPTIME_SHIFT = 100.0 - 1317384506.0  # s: a sensor that was switched on 100 s before the drive
TYPES = {"f4": PointField.FLOAT32, "f8": PointField.FLOAT64, "u1": PointField.UINT8,
         "u2": PointField.UINT16, "u4": PointField.UINT32}
# A map is as good as that of the clean recording up to this ratio of their errors, and this many
# metres beyond. Chosen: the noise of points is 2 cm, and what a user sees begins at some cm.
GOOD_RATIO = 3.0
GOOD_ERROR_M = 0.03
GOOD_COVERAGE = 0.9  # of the drive's time that has key frames; chosen
VARIANTS = {}


class Record:
    """A message of the recording, with its topic and the time when it was recorded (s)."""

    def __init__(self, topic, message, time):
        self.topic, self.message, self.time = topic, message, time

    def copy(self):
        return Record(self.topic, copy.deepcopy(self.message), self.time)


def variant(sensors, truth_shift=0.0):
    """Marks a function that changes a list of records; `truth_shift` (s) is added to the truth."""

    def mark(function):
        VARIANTS[function.__name__] = (function, sensors, truth_shift, False)
        return function

    return mark


def variant_of_files(function):
    """Marks a function that gets the clean bag and a folder, and gives the inputs of map_bag."""
    VARIANTS[function.__name__] = (function, "all", 0.0, True)
    return function


# ---------------------------------------------------------------------------------------------
# Points

def points_of(cloud):
    kinds = {number: name for name, number in TYPES.items()}
    return np.frombuffer(cloud.data, np.dtype({
        "names": [field.name for field in cloud.fields],
        "formats": ["<" + kinds[field.datatype] for field in cloud.fields],
        "offsets": [field.offset for field in cloud.fields], "itemsize": cloud.point_step})).copy()


def set_points(cloud, points, height=1):
    cloud.fields = [PointField(name, points.dtype.fields[name][1],
                               TYPES[points.dtype.fields[name][0].str[1:]], 1)
                    for name in points.dtype.names]
    cloud.point_step = points.dtype.itemsize
    cloud.height, cloud.width = height, len(points) // height
    cloud.row_step = cloud.width * cloud.point_step
    cloud.data = points.tobytes()


def with_types(points, types, offsets=None, size=None):
    """The points with these fields [(name, type)]; those that it has not are 0."""
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
    """Calls change(message, points, index), whose result replaces the points if there is one."""
    index = 0
    for record in records:
        if record.topic != CLOUDS:
            continue
        points = change(record.message, points_of(record.message), index)
        if points is not None:
            set_points(record.message, points)
        index += 1
    return records


def each(records, topics, change):
    """Calls change(message, index) for each message of the topics."""
    counts = {}
    for record in records:
        if record.topic in topics:
            change(record.message, counts.get(record.topic, 0))
            counts[record.topic] = counts.get(record.topic, 0) + 1
    return records


def stamp_plus(message, seconds):
    nanoseconds = message.header.stamp.to_nsec() + round(seconds * 1e9)
    message.header.stamp = genpy.Time(nanoseconds // 10**9, nanoseconds % 10**9)


def first_stamp(records):
    return min(r.message.header.stamp.to_sec() for r in records if hasattr(r.message, "header"))


XYZI = [("x", "f4"), ("y", "f4"), ("z", "f4"), ("intensity", "f4")]


@variant("clouds")
def clouds_clean(records):
    return records


@variant("all")
def all_clean(records):
    return records


@variant("imu")
def imu_clean(records):
    return records


@variant("velocity")
def velocity_clean(records):
    return records


@variant("clouds")
def frame_empty(records):
    return each(records, [CLOUDS], lambda m, i: setattr(m.header, "frame_id", ""))


@variant("all")
def frames_empty_of_all(records):
    return each(records, SENSORS["all"], lambda m, i: setattr(m.header, "frame_id", ""))


@variant("clouds")
def frame_with_slash(records):
    return each(records, [CLOUDS], lambda m, i: setattr(m.header, "frame_id", "/velo_link"))


@variant("clouds")
def frame_changes_in_mid_drive(records):
    return each(records, [CLOUDS],
                lambda m, i: setattr(m.header, "frame_id", "velodyne" if i > 70 else "velo_link"))


@variant("all", truth_shift=0.1)
def stamps_zero(records):
    return each(records, [CLOUDS], lambda m, i: setattr(m.header, "stamp", genpy.Time(0)))


@variant("all", truth_shift=UPTIME_SHIFT)
def stamps_of_clouds_of_uptime(records):
    return each(records, [CLOUDS], lambda m, i: stamp_plus(m, UPTIME_SHIFT))


@variant("all", truth_shift=37.0)
def stamps_of_clouds_37_s_ahead(records):
    return each(records, [CLOUDS], lambda m, i: stamp_plus(m, 37.0))


@variant("all", truth_shift=2.0)
def stamps_of_clouds_2_s_ahead(records):
    return each(records, [CLOUDS], lambda m, i: stamp_plus(m, 2.0))


@variant("clouds")
def stamps_that_repeat(records):
    def change(message, index, last=[None]):
        if index % 2:
            message.header.stamp = last[0]
        last[0] = message.header.stamp
    return each(records, [CLOUDS], change)


@variant("all")
def stamps_go_back_by_1_s(records):
    return each(records, SENSORS["all"],
                lambda m, i: stamp_plus(m, -1.0) if m.header.stamp.to_sec() > middle(records)
                else None)


def middle(records, known={}):
    key = id(records)
    if key not in known:
        known[key] = first_stamp(records) + 10.0
    return known[key]


@variant("clouds")
def stamps_of_clouds_go_back_by_1_s(records):
    return each(records, [CLOUDS], lambda m, i: stamp_plus(m, -1.0) if i > 90 else None)


@variant("all", truth_shift=0.1)
def stamps_at_the_end_of_the_sweep(records):
    for record in records:
        if record.topic == CLOUDS:
            stamp_plus(record.message, 0.1)
            record.time = record.message.header.stamp.to_sec() + 0.01
    return records


@variant("all", truth_shift=0.115)
def stamps_of_clouds_by_arrival(records):
    """Stamped by the driver's computer when the sweep is complete, with jitter."""
    noise = np.random.default_rng(1)
    for record in records:
        if record.topic == CLOUDS:
            late = 0.1 + noise.uniform(0.0, 0.03)
            stamp_plus(record.message, late)
            record.time = record.message.header.stamp.to_sec() + 0.002
    return records


@variant("all")
def received_all_at_once(records):
    for record in records:
        record.time = 1.7e9
    return records


@variant("all")
def received_years_later(records):
    for record in records:
        record.time += 1e8
    return records


@variant("all")
def received_out_of_order(records):
    noise = np.random.default_rng(1)
    for record in records:
        record.time += noise.uniform(0.0, 0.5)
    return records


@variant("clouds")
def coordinates_of_float64(records):
    return each_cloud(records, lambda m, p, i: with_types(
        p, [("x", "f8"), ("y", "f8"), ("z", "f8"), ("intensity", "f4"), ("time", "f4")]))


@variant("clouds")
def fields_in_odd_order_with_padding(records):
    types = [("time", "f4"), ("z", "f4"), ("intensity", "f4"), ("x", "f4"), ("y", "f4")]
    return each_cloud(records, lambda m, p, i: with_types(p, types, [5, 12, 17, 24, 31], 48))


@variant("clouds")
def intensity_of_uint8(records):
    return each_cloud(records, lambda m, p, i: with_types(
        p, XYZI[:3] + [("intensity", "u1"), ("time", "f4")]))


@variant("clouds")
def intensity_missing(records):
    return each_cloud(records, lambda m, p, i: with_types(p, XYZI[:3] + [("time", "f4")]))


@variant("clouds")
def points_not_finite(records):
    def change(_, points, index):
        lost = np.random.default_rng(index).random(len(points)) < 0.3
        for name in "xyz":
            points[name][lost] = np.nan
        return points
    return each_cloud(records, change)


@variant("clouds")
def points_without_return_at_the_origin(records):
    def change(_, points, index):
        lost = np.random.default_rng(index).random(len(points)) < 0.3
        for name in "xyz":
            points[name][lost] = 0.0
        return points
    return each_cloud(records, change)


@variant("clouds")
def points_without_return_at_maximal_range(records):
    def change(_, points, index):
        lost = np.random.default_rng(index).random(len(points)) < 0.3
        scale = 120.0 / np.sqrt(points["x"] ** 2 + points["y"] ** 2 + points["z"] ** 2)
        for name in "xyz":
            points[name][lost] *= scale[lost]
        return points
    return each_cloud(records, change)


@variant("clouds")
def organised_and_said_to_be_dense(records):
    def change(message, points, _):
        rows = 16
        padded = np.zeros(-(-len(points) // rows) * rows, points.dtype)
        for name in "xyz":
            padded[name] = np.nan
        padded[:len(points)] = points
        set_points(message, padded, rows)
        message.is_dense = True
    return each_cloud(records, change)


@variant("clouds")
def width_and_height_swapped(records):
    """A column of points: height N, width 1."""
    def change(message, _, __):
        message.height, message.width = message.width, 1
        message.row_step = message.point_step
    return each_cloud(records, change)


@variant("clouds")
def row_step_zero(records):
    return each(records, [CLOUDS], lambda m, i: setattr(m, "row_step", 0))


@variant("clouds")
def points_in_millimetres(records):
    def change(_, points, __):
        for name in "xyz":
            points[name] *= 1000.0
        return points
    return each_cloud(records, change)


@variant("clouds")
def points_in_centimetres(records):
    def change(_, points, __):
        for name in "xyz":
            points[name] *= 100.0
        return points
    return each_cloud(records, change)


@variant("all")
def y_to_the_right(records):
    """A driver with axes of the left hand: everything is mirrored."""
    def change(_, points, __):
        points["y"] *= -1.0
        return points
    return each_cloud(records, change)


@variant("all")
def lidar_turned_by_90_degrees_without_a_word(records):
    def change(_, points, __):
        points["x"], points["y"] = points["y"].copy(), -points["x"]
        return points
    return each_cloud(records, change)


@variant("all")
def lidar_upside_down_without_a_word(records):
    def change(_, points, __):
        points["y"] *= -1.0
        points["z"] *= -1.0
        return points
    return each_cloud(records, change)


def truth_poses(records):
    return {r.message.header.stamp.to_nsec(): r.message.pose.pose for r in records
            if r.topic == "/ground_truth"}


def rotation(q):
    x, y, z, w = q.x, q.y, q.z, q.w
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def into_world(records, poses, frame):
    def change(message, points, _):
        pose = poses[message.header.stamp.to_nsec()]
        xyz = np.stack([points["x"] + 0.76, points["y"] + 0.02, points["z"] + 1.73], 1)
        xyz = xyz @ rotation(pose.orientation).T
        xyz += [pose.position.x, pose.position.y, pose.position.z]
        points["x"], points["y"], points["z"] = xyz.T
        message.header.frame_id = frame
        return points
    return each_cloud(records, change)


@variant("clouds")
def clouds_in_a_world_without_tf(records):
    return into_world(records, truth_poses(clean_records()), "map")


@variant("clouds")
def clouds_in_a_world_with_tf(records):
    poses = truth_poses(clean_records())
    moves = []
    for stamp, pose in poses.items():
        t = TransformStamped()
        t.header.frame_id, t.child_frame_id = "odom", "base_link"
        t.header.stamp = genpy.Time(stamp // 10**9, stamp % 10**9)
        t.transform.translation.x, t.transform.translation.y = pose.position.x, pose.position.y
        t.transform.translation.z, t.transform.rotation = pose.position.z, pose.orientation
        moves.append(Record("/tf", TFMessage([t]), stamp * 1e-9))
    return into_world(records, poses, "odom") + moves


@variant("clouds")
def two_lidars_on_one_topic(records):
    result = []
    for record in records:
        result.append(record)
        if record.topic != CLOUDS:
            continue
        other = record.copy()
        points = points_of(other.message)
        points["x"] -= 2.0
        set_points(other.message, points[::2].copy())
        other.message.header.frame_id = "rear"
        stamp_plus(other.message, 0.003)
        other.time += 0.003
        result.append(other)
    return result


@variant("clouds")
def every_cloud_twice(records):
    return [copied for record in records
            for copied in ([record, record.copy()] if record.topic == CLOUDS else [record])]


def static(records, change):
    return each(records, [STATIC], lambda m, i: change(m.transforms))


@variant("all")
def tf_static_missing(records):
    return [r for r in records if r.topic != STATIC]


@variant("all")
def tf_with_a_cycle(records):
    def change(transforms):
        extra = copy.deepcopy(transforms[0])
        extra.header.frame_id, extra.child_frame_id = "velo_link", "base_link"
        transforms.append(extra)
    return static(records, change)


@variant("all")
def tf_not_normalised(records):
    def change(transforms):
        for t in transforms:
            for axis in "xyzw":
                setattr(t.transform.rotation, axis, 2.0 * getattr(t.transform.rotation, axis))
    return static(records, change)


@variant("all")
def tf_quaternion_zero(records):
    def change(transforms):
        for t in transforms:
            t.transform.rotation.w = t.transform.rotation.x = 0.0
            t.transform.rotation.y = t.transform.rotation.z = 0.0
    return static(records, change)


@variant("all")
def tf_not_a_number(records):
    def change(transforms):
        transforms[0].transform.translation.x = math.nan
    return static(records, change)


@variant("all")
def tf_in_millimetres(records):
    def change(transforms):
        for t in transforms:
            for axis in "xyz":
                setattr(t.transform.translation, axis,
                        1000.0 * getattr(t.transform.translation, axis))
    return static(records, change)


@variant("all")
def tf_named_base_footprint(records):
    def change(transforms):
        for t in transforms:
            t.header.frame_id = "base_footprint"
    return static(records, change)


@variant("all")
def tf_static_at_the_end_of_the_bag(records):
    for record in records:
        if record.topic == STATIC:
            record.time += 14.9
    return records


# ---------------------------------------------------------------------------------------------
# Rings and times

def with_time(records, kind, value, name="time"):
    """The times as this type: value(times, message)."""
    def change(message, points, _):
        result = with_types(points, XYZI + [(name, kind)])
        result[name] = value(points["time"].astype(np.float64), message)
        return result
    return each_cloud(records, change)


@variant("clouds")
def ring_as_float(records):
    def change(_, points, __):
        result = with_types(points, XYZI + [("ring", "f4"), ("time", "f4")])
        result["ring"] = np.arange(len(points)) % 16
        return result
    return each_cloud(records, change)


@variant("clouds")
def times_missing(records):
    return each_cloud(records, lambda m, p, i: with_types(p, XYZI))


@variant("clouds")
def times_in_ns_as_float(records):
    return with_time(records, "f4", lambda t, m: t * 1e9)


@variant("clouds")
def times_in_us_as_float(records):
    return with_time(records, "f4", lambda t, m: t * 1e6)


@variant("clouds")
def times_in_ns_of_another_start(records):
    return with_time(records, "u4", lambda t, m: np.round(t * 1e9) + 2.5e9, "t")


@variant("clouds")
def times_in_ns_that_wrap(records):
    """A count of 32 bits since the sensor's start, which begins anew every 4.3 s."""
    def value(times, message):
        stamp = message.header.stamp.to_nsec() % 2**32
        return np.mod(np.round(times * 1e9) + stamp, 2**32)
    return with_time(records, "u4", value, "t")


@variant("clouds")
def times_in_ns_of_the_second(records):
    def value(times, message):
        return np.mod(np.round(times * 1e9) + message.header.stamp.nsecs, 10**9)
    return with_time(records, "u4", value, "t")


@variant("clouds")
def times_in_us_of_the_hour(records):
    def value(times, message):
        return np.mod(np.round(times * 1e6) + message.header.stamp.to_nsec() // 1000, 3600 * 10**6)
    return with_time(records, "u4", value, "t")


@variant("clouds")
def times_negative(records):
    """From the stamp at the end of the sweep backwards, as velodyne_pointcloud had it."""
    each(records, [CLOUDS], lambda m, i: stamp_plus(m, 0.1))
    return with_time(records, "f4", lambda t, m: t - 0.1)


@variant("clouds", truth_shift=-0.1)
def times_backwards(records):
    return with_time(records, "f4", lambda t, m: 0.1 - t)


@variant("clouds")
def times_constant(records):
    return with_time(records, "f4", lambda t, m: np.full_like(t, 0.05))


@variant("clouds")
def times_absolute_as_float(records):
    """Absolute seconds in 32 bits, which leave steps of 128 s."""
    return with_time(records, "f4", lambda t, m: t + m.header.stamp.to_sec(), "timestamp")


@variant("clouds")
def times_absolute_of_gps(records):
    return with_time(records, "f8", lambda t, m: t + m.header.stamp.to_sec() + 18.0, "timestamp")


@variant("clouds")
def times_not_finite(records):
    def value(times, message):
        times[::100] = np.nan
        return times
    return with_time(records, "f4", value)


# ---------------------------------------------------------------------------------------------
# What the clouds show

@variant("clouds")
def half_of_the_view(records):
    return each_cloud(records, lambda m, p, i: p[p["x"] > 0.0])


@variant("clouds")
def every_second_packet_missing(records):
    """A turn of a VLP-16 is about 75 packets."""
    def change(_, points, __):
        return points[np.floor(points["time"] / 0.1 * 75).astype(int) % 2 == 0]
    return each_cloud(records, change)


@variant("clouds")
def every_second_scan_missing(records):
    counter = [0]

    def kept(record):
        if record.topic != CLOUDS:
            return True
        counter[0] += 1
        return counter[0] % 2 == 0
    return [r for r in records if kept(r)]


@variant("clouds")
def half_of_the_scans_missing_at_random(records):
    noise = np.random.default_rng(1)
    return [r for r in records if r.topic != CLOUDS or noise.random() < 0.5]


@variant("clouds")
def sectors_of_36_degrees_as_messages(records):
    result = []
    for record in records:
        if record.topic != CLOUDS:
            result.append(record)
            continue
        points = points_of(record.message)
        for part in range(10):
            inside = (points["time"] >= 0.01 * part) & (points["time"] < 0.01 * (part + 1))
            sector = record.copy()
            cut = points[inside]
            cut["time"] -= 0.01 * part
            set_points(sector.message, cut)
            stamp_plus(sector.message, 0.01 * part)
            sector.time += 0.01 * (part - 9)
            result.append(sector)
    return result


@variant("clouds")
def two_turns_in_each_message(records):
    result, held = [], None
    for record in records:
        if record.topic != CLOUDS:
            result.append(record)
        elif held is None:
            held = record
        else:
            later = points_of(record.message)
            later["time"] += 0.1
            set_points(held.message, np.concatenate([points_of(held.message), later]))
            held.time = record.time
            result.append(held)
            held = None
    return result


def add_roof(points, index, share):
    noise = np.random.default_rng(index)
    count = int(share * len(points))
    roof = np.zeros(count, points.dtype)
    roof["x"], roof["y"] = noise.uniform(-2.2, 1.2, count), noise.uniform(-0.8, 0.8, count)
    roof["z"] = noise.normal(-0.25, 0.01, count)
    roof["time"] = np.sort(noise.uniform(0.0, 0.0999, count))
    return np.concatenate([points, roof])


@variant("clouds")
def roof_of_the_vehicle_in_each_scan(records):
    return each_cloud(records, lambda m, p, i: add_roof(p, i, 0.2))


@variant("clouds")
def vehicle_with_a_frame_around_the_sensor(records):
    """A rack at 3 m on all sides, which moves with the sensor: 40 % of the points."""
    def change(_, points, index):
        noise = np.random.default_rng(index)
        count = int(0.4 * len(points))
        rack = np.zeros(count, points.dtype)
        angle = noise.integers(0, 8, count) * math.pi / 4 + noise.uniform(-0.05, 0.05, count)
        rack["x"], rack["y"] = 3.0 * np.cos(angle), 3.0 * np.sin(angle)
        rack["z"] = noise.uniform(-1.5, 1.0, count)
        rack["time"] = np.sort(noise.uniform(0.0, 0.0999, count))
        return np.concatenate([points, rack])
    return each_cloud(records, change)


@variant("clouds")
def sparse_points(records):
    return each_cloud(records, lambda m, p, i: p[::40].copy())


@variant("clouds")
def first_scans_empty(records):
    return each_cloud(records, lambda m, p, i: p[:0] if i < 20 else p)


# ---------------------------------------------------------------------------------------------
# IMU and velocity

def scaled(vector, factor):
    vector.x, vector.y, vector.z = vector.x * factor, vector.y * factor, vector.z * factor


@variant("imu")
def imu_in_g(records):
    return each(records, [IMU], lambda m, i: scaled(m.linear_acceleration, 1 / 9.80665))


@variant("imu")
def imu_in_degrees(records):
    return each(records, [IMU], lambda m, i: scaled(m.angular_velocity, 180 / math.pi))


def swap_axes(message, _):
    for v in (message.angular_velocity, message.linear_acceleration):
        v.x, v.y, v.z = v.y, v.z, v.x


@variant("imu")
def imu_axes_swapped(records):
    return each(records, [IMU], swap_axes)


def turn_over(message, _):
    for v in (message.angular_velocity, message.linear_acceleration):
        v.y, v.z = -v.y, -v.z


@variant("imu")
def imu_in_north_east_down(records):
    """x ahead, y to the right, z down; at rest it then reports -g on z."""
    return each(records, [IMU], turn_over)


@variant("imu")
def imu_gyro_of_the_wrong_sign(records):
    return each(records, [IMU], lambda m, i: scaled(m.angular_velocity, -1.0))


@variant("imu")
def imu_gyro_dead(records):
    return each(records, [IMU], lambda m, i: scaled(m.angular_velocity, 0.0))


@variant("imu")
def imu_late_by_300_ms(records):
    return each(records, [IMU], lambda m, i: stamp_plus(m, 0.3))


@variant("all")
def imu_late_by_300_ms_with_velocity(records):
    return each(records, [IMU], lambda m, i: stamp_plus(m, 0.3))


@variant("imu")
def imu_of_another_clock(records):
    first = first_stamp(records)
    return each(records, [IMU], lambda m, i: stamp_plus(m, 50.0 - first))


@variant("imu")
def imu_stamps_zero_in_bursts(records):
    each(records, [IMU], lambda m, i: setattr(m.header, "stamp", genpy.Time(0)))
    for record in records:
        if record.topic == IMU:
            record.time = math.ceil(record.time * 5) / 5
    return records


@variant("imu")
def imu_with_gaps(records):
    start = first_stamp(records)
    return [r for r in records if r.topic != IMU or (r.time - start) % 2.0 > 0.7]


@variant("imu")
def imu_at_5_hz(records):
    count = [0]

    def kept(record):
        count[0] += record.topic == IMU
        return record.topic != IMU or count[0] % 20 == 0
    return [r for r in records if kept(r)]


@variant("imu")
def imu_orientation_zero(records):
    def change(message, _):
        q = message.orientation
        q.x = q.y = q.z = q.w = 0.0
    return each(records, [IMU], change)


@variant("imu")
def imu_not_finite(records):
    def change(message, index):
        if index % 10 == 0:
            message.angular_velocity.z = math.nan
    return each(records, [IMU], change)


@variant("velocity")
def velocity_in_kmh_without_gnss(records):
    return each(records, [VELOCITY], lambda m, i: scaled(m.twist.linear, 3.6))


@variant("all")
def velocity_in_kmh(records):
    return each(records, [VELOCITY], lambda m, i: scaled(m.twist.linear, 3.6))


@variant("velocity")
def velocity_of_the_wrong_sign_without_gnss(records):
    return each(records, [VELOCITY], lambda m, i: scaled(m.twist.linear, -1.0))


@variant("all")
def velocity_of_the_wrong_sign(records):
    return each(records, [VELOCITY], lambda m, i: scaled(m.twist.linear, -1.0))


@variant("velocity")
def velocity_always_zero(records):
    return each(records, [VELOCITY], lambda m, i: scaled(m.twist.linear, 0.0))


@variant("velocity")
def velocity_sideways(records):
    def change(message, _):
        v = message.twist.linear
        v.x, v.y = -v.y, v.x
    return each(records, [VELOCITY], change)


@variant("velocity")
def velocity_late_by_500_ms(records):
    return each(records, [VELOCITY], lambda m, i: stamp_plus(m, 0.5))


@variant("clouds")
def wheel_odometry_without_covariance(records):
    return records + odometry_of_wheels(1.0)


@variant("clouds")
def wheel_odometry_backwards(records):
    return records + odometry_of_wheels(-1.0)


def odometry_of_wheels(sign):
    result, last, x = [], None, 0.0
    for record in clean_records():
        if record.topic != VELOCITY:
            continue
        message = Odometry()
        message.header.stamp = record.message.header.stamp
        message.header.frame_id, message.child_frame_id = "odom", "base_link"
        speed = sign * record.message.twist.linear.x
        stamp = message.header.stamp.to_sec()
        x += speed * (stamp - last) if last else 0.0
        last = stamp
        message.pose.pose.position.x = x
        message.pose.pose.orientation.w = 1.0
        message.twist.twist.linear.x = speed
        result.append(Record("/odom", message, record.time))
    return result


# ---------------------------------------------------------------------------------------------
# GNSS

@variant("gnss")
def gnss_clean(records):
    return records


@variant("all")
def gnss_status_without_fix(records):
    return each(records, [GNSS], lambda m, i: setattr(m.status, "status", -1))


@variant("all")
def gnss_covariances_zero(records):
    def change(message, _):
        message.position_covariance = [0.0] * 9
    return each(records, [GNSS], change)


@variant("all")
def gnss_latitude_and_longitude_swapped(records):
    def change(m, _):
        m.latitude, m.longitude = m.longitude, m.latitude
    return each(records, [GNSS], change)


@variant("all")
def gnss_jumps_by_1_km(records):
    def change(message, index):
        if index % 20 > 15:
            message.latitude += 0.009
    return each(records, [GNSS], change)


@variant("all")
def gnss_1_km_aside_from_mid_drive_on(records):
    def change(message, index):
        if index > 90:
            message.latitude += 0.009
    return each(records, [GNSS], change)


@variant("all")
def gnss_at_0_0(records):
    def change(message, _):
        message.latitude = message.longitude = message.altitude = 0.0
    return each(records, [GNSS], change)


@variant("all")
def gnss_at_0_0_at_the_start(records):
    def change(message, index):
        if index < 50:
            message.latitude = message.longitude = message.altitude = 0.0
    return each(records, [GNSS], change)


@variant("all")
def gnss_frozen(records):
    def change(message, _, first=[]):
        first.append((message.latitude, message.longitude, message.altitude))
        message.latitude, message.longitude, message.altitude = first[0]
    return each(records, [GNSS], change)


@variant("all")
def gnss_freezes_in_mid_drive(records):
    def change(message, index, last=[]):
        if index > 90:
            message.latitude, message.longitude, message.altitude = last[0]
        else:
            last[:] = [(message.latitude, message.longitude, message.altitude)]
    return each(records, [GNSS], change)


@variant("all")
def gnss_in_radians(records):
    def change(message, _):
        message.latitude, message.longitude = map(math.radians,
                                                  (message.latitude, message.longitude))
    return each(records, [GNSS], change)


@variant("all")
def gnss_in_degrees_and_minutes(records):
    """4902.1 instead of 49.035, as NMEA writes it."""
    def nmea(angle):
        return math.floor(angle) * 100.0 + (angle - math.floor(angle)) * 60.0

    def change(message, _):
        message.latitude, message.longitude = nmea(message.latitude), nmea(message.longitude)
    return each(records, [GNSS], change)


@variant("all")
def gnss_with_4_decimals(records):
    def change(message, _):
        message.latitude = round(message.latitude, 4)
        message.longitude = round(message.longitude, 4)
    return each(records, [GNSS], change)


@variant("all")
def gnss_without_altitude(records):
    return each(records, [GNSS], lambda m, i: setattr(m, "altitude", math.nan))


@variant("all")
def gnss_late_by_2_s(records):
    return each(records, [GNSS], lambda m, i: stamp_plus(m, 2.0))


@variant("all")
def gnss_covariances_as_deviations_of_a_km(records):
    def change(message, _):
        message.position_covariance = [1e6, 0, 0, 0, 1e6, 0, 0, 0, 1e6]
    return each(records, [GNSS], change)


# ---------------------------------------------------------------------------------------------
# Files

def copy_bag(source, target, compression="none", kept=lambda topic, index: True):
    with rosbag.Bag(source) as bag, rosbag.Bag(target, "w", compression=compression) as out:
        for index, (topic, message, time) in enumerate(bag.read_messages(raw=True)):
            if kept(topic, index):
                out.write(topic, message, time, raw=True)
    return target


@variant_of_files
def compressed_by_bz2(clean, folder):
    return [copy_bag(clean, folder + "/a.bag", "bz2")]


@variant_of_files
def compressed_by_lz4(clean, folder):
    return [copy_bag(clean, folder + "/a.bag", "lz4")]


@variant_of_files
def compressed_by_gzip(clean, folder):
    subprocess.run(f"gzip -1 -c {clean} > {folder}/a.bag.gz", shell=True, check=True)
    return [folder + "/a.bag.gz"]


@variant_of_files
def unindexed_and_active(clean, folder):
    """As a flat battery leaves it: no index, the last chunk cut."""
    data = bytearray(open(clean, "rb").read())
    header = data.find(b"index_pos=") + len(b"index_pos=")
    data[header:header + 8] = bytes(8)
    open(folder + "/a.bag.active", "wb").write(data[:int(len(data) * 0.97)])
    return [folder + "/a.bag.active"]


@variant_of_files
def truncated(clean, folder):
    data = open(clean, "rb").read()
    open(folder + "/a.bag", "wb").write(data[:len(data) // 2])
    return [folder + "/a.bag"]


@variant_of_files
def no_messages(clean, folder):
    rosbag.Bag(folder + "/a.bag", "w").close()
    return [folder + "/a.bag"]


@variant_of_files
def no_bytes(clean, folder):
    open(folder + "/a.bag", "w").close()
    return [folder + "/a.bag"]


@variant_of_files
def no_bag_but_text(clean, folder):
    open(folder + "/a.bag", "w").write("<html>404 Not Found</html>\n")
    return [folder + "/a.bag"]


@variant_of_files
def images_alone(clean, folder):
    with rosbag.Bag(folder + "/a.bag", "w") as bag:
        for i in range(10):
            image = Image()
            image.header.stamp = genpy.Time(1000 + i)
            bag.write("/camera/image", image, image.header.stamp)
    return [folder + "/a.bag"]


def split(clean, folder, names, overlap=0):
    with rosbag.Bag(clean) as bag:
        count = bag.get_message_count()
    third = count // 3
    ranges = [(0, third + overlap), (third, 2 * third + overlap), (2 * third, count)]
    return [copy_bag(clean, f"{folder}/{name}.bag",
                     kept=lambda topic, i, r=r: r[0] <= i < r[1] or topic == STATIC)
            for name, r in zip(names, ranges)]


@variant_of_files
def split_in_wrong_order(clean, folder):
    return split(clean, folder, "abc")[::-1]


@variant_of_files
def split_without_its_middle(clean, folder):
    return split(clean, folder, "abc")[::2]


@variant_of_files
def split_with_overlap(clean, folder):
    return split(clean, folder, "abc", 200)


@variant_of_files
def the_same_bag_twice(clean, folder):
    shutil.copy(clean, folder + "/a.bag")
    shutil.copy(clean, folder + "/b.bag")
    return [folder + "/a.bag", folder + "/b.bag"]


# ---------------------------------------------------------------------------------------------
# Running and judging

_CLEAN = {}


def clean_records():
    return _CLEAN["records"]


def read_records(path):
    with rosbag.Bag(path) as bag:
        return [Record(topic, message, time.to_sec()) for topic, message, time in
                bag.read_messages()]


def write_records(records, path):
    with rosbag.Bag(path, "w") as bag:
        for record in sorted(records, key=lambda r: r.time):
            bag.write(record.topic, record.message, genpy.Time.from_sec(max(record.time, 0.01)))


def program(name):
    folder = os.environ.get("LIDAR_MAPPING_PROGRAMS", os.path.join(
        os.path.dirname(os.path.abspath(__file__)), "../.build/devel/lib/lidar_mapping"))
    return os.path.join(folder, name)


def run(command):
    done = subprocess.run([program(command[0])] + command[1:], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, timeout=1800)
    text = done.stdout.decode(errors="replace").replace("\r", "\n")
    return done.returncode, [line for line in text.splitlines()
                             if line.strip() and not line.startswith("mapping:")]


def shifted_truth(truth, path, shift):
    with open(truth) as lines, open(path, "w") as out:
        for line in lines:
            words = line.split()
            seconds, _, fraction = words[0].partition(".")
            nanoseconds = int(seconds) * 10**9 + int(fraction.ljust(9, "0")) + round(shift * 1e9)
            words[0] = f"{nanoseconds // 10**9}.{nanoseconds % 10**9:09d}"
            out.write(" ".join(words) + "\n")
    return path


def time_span(path):
    stamps = [float(line.split()[0]) for line in open(path) if line[0] != "#"]
    return stamps[0], stamps[-1]


def error_of(folder, truth, trajectory, shift):
    """APE (m, RMSE), and the part of the drive's time that the key frames cover."""
    if not os.path.exists(trajectory):
        return None, 0.0
    begin, end = time_span(truth)
    try:
        first, last = time_span(trajectory)
    except IndexError:
        return None, 0.0
    moved = shifted_truth(truth, folder + "/truth.tum", shift)
    errors = [ape_of(moved, trajectory, arm) for arm in ([], LIDAR_TO_BASE)]
    known = [error for error in errors if error is not None]
    return min(known, default=None), (last - first) / (end - begin)


def ape_of(truth, trajectory, arm):
    """The map may be of base_link or, where nothing leads to that, of the LiDAR: with an arm."""
    figures = truth + ".json"
    lever = ["--lever-arm"] + [str(x) for x in arm] if arm else []
    status, _ = run(["evaluate_trajectory", truth, trajectory, "--align", "--json", figures] +
                    lever)
    if status != 0:
        return None
    with open(figures) as file:
        return json.load(file)["ape"]["translation_m"]["rmse"]


def alarms(lines):
    words = ("FAULT", "WARNING", "warning", "error", "cannot", "no transform", "refused", "dropped",
             "is it another clock", "left out", "Noticed", "doubt")
    return [line.strip() for line in lines if any(word in line for word in words)]


def judge(result, reference):
    if min(result["check_status"], result["map_status"]) < 0:
        return "CRASH"
    said = result["check_status"] != 0 or result["map_status"] != 0 or alarms(result["map_bag"])
    good = (result["ape"] is not None and result["coverage"] >= GOOD_COVERAGE and
            result["ape"] <= GOOD_RATIO * reference + GOOD_ERROR_M)
    return ("alarm" if said else "good") if good else ("named" if said else "SILENT")


def examine(name, options):
    function, sensors, shift, makes_files = VARIANTS[name]
    folder = os.path.join(options.output, name)
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    if makes_files:
        inputs = function(options.clean, folder)
    else:
        wanted = SENSORS[sensors] + [STATIC]
        records = [r.copy() for r in clean_records() if r.topic in wanted]
        inputs = [folder + "/spoilt.bag"]
        write_records(function(records), inputs[0])
    result = {"name": name, "sensors": sensors}
    result["check_status"], result["check_bag"] = run(["check_bag"] + inputs)
    session = folder + "/map"
    result["map_status"], result["map_bag"] = run(["map_bag"] + inputs + [
        "-o", session, "--no-map", "--threads", "1"])
    result["ape"], result["coverage"] = error_of(
        folder, options.truth, session + "/trajectory/optimized.tum", shift)
    shutil.rmtree(session, ignore_errors=True)
    if not options.keep:
        for path in inputs:
            os.remove(path)
    return result


def earlier_results(path):
    if not os.path.exists(path):
        return []
    with open(path) as lines:
        return [json.loads(line) for line in lines]


def show(result, file):
    ape = "-" if result["ape"] is None else f"{1e3 * result['ape']:.1f} mm"
    print(f"\n== {result['name']} ({result['sensors']}): {result['verdict']}, APE {ape}, "
          f"{100 * result['coverage']:.0f} % of the time", file=file)
    print(f"check_bag: {result['check_status']}", *result["check_bag"], sep="\n  ", file=file)
    print(f"map_bag: {result['map_status']}", *result["map_bag"], sep="\n  ", file=file, flush=True)


def table(results):
    """The results as a table in Markdown."""
    lines = ["| variant | sensors | APE, mm | verdict |", "| --- | --- | --- | --- |"]
    for result in results:
        ape = "" if result["ape"] is None else f"{1e3 * result['ape']:.1f}"
        lines.append(f"| `{result['name']}` | {result['sensors']} | {ape} | {result['verdict']} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", required=True, help="folder for bags and results")
    parser.add_argument("--only", nargs="*", help="names of variants, or their beginnings")
    parser.add_argument("--keep", action="store_true", help="keep the spoilt bags")
    parser.add_argument("--table", action="store_true", help="print the results that are there")
    options = parser.parse_args()
    if options.table:
        print(table(earlier_results(options.output + "/results.jsonl")))
        return
    os.makedirs(options.output, exist_ok=True)
    options.clean = options.output + "/clean.bag"
    options.truth = options.output + "/clean.tum"
    if not os.path.exists(options.clean):
        subprocess.run([program("simulate_drive"), options.clean, "--lidar", "vlp16",
                        "--duration", "15", "--truth", options.truth, "--threads", "1"], check=True)
    _CLEAN["records"] = read_records(options.clean)
    names = [name for name in VARIANTS if not options.only or
             any(name.startswith(wanted) for wanted in options.only)]
    done = earlier_results(options.output + "/results.jsonl")
    references = {r["sensors"]: r["ape"] for r in done if r["name"] == r["sensors"] + "_clean"}
    with open(options.output + "/results.jsonl", "a") as out:
        for name in names:
            if any(result["name"] == name for result in done):
                continue
            try:
                result = examine(name, options)
            except Exception as error:
                print("\n== ", name, "could not be made:", repr(error), flush=True)
                continue
            sensors = result["sensors"]
            if name == sensors + "_clean":
                references[sensors] = result["ape"] or 0.0
            result["verdict"] = judge(result, references.get(sensors, 0.02))
            out.write(json.dumps(result) + "\n")
            out.flush()
            show(result, sys.stdout)


if __name__ == "__main__":
    main()
