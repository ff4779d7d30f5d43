# SPDX-License-Identifier: BSD-3-Clause
"""Faults of the times of points: units, origins, types, directions."""
import numpy as np

from recording_faults.points import XYZI, each_cloud_with_types, points_of, set_points, with_types
from recording_faults.records import CLOUDS, SWEEP, messages_of, with_shifted_stamps
from recording_faults.variants import variant


def with_time(records, kind, value, name="time"):
    """The times as this type: value(times since the stamp (s), stamp)."""
    for cloud in messages_of(records, CLOUDS):
        points = points_of(cloud)
        result = with_types(points, XYZI + [(name, kind)])
        result[name] = value(points["time"].astype(np.float64), cloud.header.stamp)
        set_points(cloud, result)
    return records


@variant("clouds")
def times_missing(records):
    return each_cloud_with_types(records, XYZI)


@variant("clouds")
def times_in_ns_as_float(records):
    return with_time(records, "f4", lambda times, stamp: times * 1e9)


@variant("clouds")
def times_in_us_as_float(records):
    return with_time(records, "f4", lambda times, stamp: times * 1e6)


@variant("clouds")
def times_in_ns_of_another_start(records):
    return with_time(records, "u4", lambda times, stamp: np.round(times * 1e9) + 2.5e9, "t")


@variant("clouds")
def times_in_ns_that_wrap(records):
    """A count of 32 bits since the sensor's start, which restarts every 4.3 s."""
    return with_time(records, "u4", lambda times, stamp: np.mod(
        np.round(times * 1e9) + stamp.to_nsec() % 2**32, 2**32), "t")


@variant("clouds")
def times_in_ns_of_the_second(records):
    return with_time(records, "u4", lambda times, stamp: np.mod(
        np.round(times * 1e9) + stamp.nsecs, 10**9), "t")


@variant("clouds")
def times_in_us_of_the_hour(records):
    return with_time(records, "u4", lambda times, stamp: np.mod(
        np.round(times * 1e6) + stamp.to_nsec() // 1000, 3600 * 10**6), "t")


@variant("clouds")
def times_negative(records):
    """From the stamp at the end of the sweep backwards, as velodyne_pointcloud had it."""
    with_shifted_stamps(records, SWEEP, CLOUDS)
    return with_time(records, "f4", lambda times, stamp: times - SWEEP)


@variant("clouds", truth_shift=-SWEEP)
def times_backwards(records):
    return with_time(records, "f4", lambda times, stamp: SWEEP - times)


@variant("clouds")
def times_constant(records):
    return with_time(records, "f4", lambda times, stamp: np.full_like(times, 0.05))


@variant("clouds")
def times_absolute_as_float(records):
    """Absolute seconds in 32 bits, which leave steps of 128 s."""
    return with_time(records, "f4", lambda times, stamp: times + stamp.to_sec(), "timestamp")


@variant("clouds")
def times_absolute_of_gps(records):
    """GPS is ahead of UTC by 18 leap seconds."""
    return with_time(records, "f8", lambda times, stamp: times + stamp.to_sec() + 18.0, "timestamp")


@variant("clouds")
def times_not_finite(records):
    def value(times, _):
        times[::100] = np.nan
        return times
    return with_time(records, "f4", value)
