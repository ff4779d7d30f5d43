# SPDX-License-Identifier: BSD-3-Clause
"""Faults of the IMU: units, axes, signs, stamps, gaps, values."""
import math

from recording_faults.records import (IMU, first_stamp, messages_of, with_shifted_stamps,
                                      with_stamps_of_zero, without)
from recording_faults.variants import variant


def scale(vector, factor):
    vector.x, vector.y, vector.z = vector.x * factor, vector.y * factor, vector.z * factor


def with_scaled_gyro(records, factor):
    for message in messages_of(records, IMU):
        scale(message.angular_velocity, factor)
    return records


def vectors_of(records):
    """The angular velocity and the acceleration of each message."""
    return [vector for message in messages_of(records, IMU)
            for vector in (message.angular_velocity, message.linear_acceleration)]


@variant("imu")
def imu_in_g(records):
    for message in messages_of(records, IMU):
        scale(message.linear_acceleration, 1 / 9.80665)
    return records


@variant("imu")
def imu_in_degrees(records):
    return with_scaled_gyro(records, 180 / math.pi)


@variant("imu")
def imu_axes_swapped(records):
    for v in vectors_of(records):
        v.x, v.y, v.z = v.y, v.z, v.x
    return records


@variant("imu")
def imu_in_north_east_down(records):
    """x ahead, y to the right, z down; at rest it then reports -g on z."""
    for v in vectors_of(records):
        v.y, v.z = -v.y, -v.z
    return records


@variant("imu")
def imu_gyro_of_the_wrong_sign(records):
    return with_scaled_gyro(records, -1.0)


@variant("imu")
def imu_gyro_dead(records):
    return with_scaled_gyro(records, 0.0)


@variant("imu")
def imu_late_by_300_ms(records):
    return with_shifted_stamps(records, 0.3, IMU)


@variant("all")
def imu_late_by_300_ms_with_velocity(records):
    return with_shifted_stamps(records, 0.3, IMU)


@variant("imu")
def imu_of_another_clock(records):
    return with_shifted_stamps(records, 50.0 - first_stamp(records), IMU)


@variant("imu")
def imu_stamps_zero_in_bursts(records):
    with_stamps_of_zero(records, IMU)
    for record in records:
        if record.topic == IMU:
            record.time = math.ceil(record.time * 5) / 5
    return records


@variant("imu")
def imu_with_gaps(records):
    start = first_stamp(records)
    return without(records, IMU, lambda record, index: (record.time - start) % 2.0 <= 0.7)


@variant("imu")
def imu_at_5_hz(records):
    """The simulated IMU has 100 Hz."""
    return without(records, IMU, lambda record, index: index % 20 != 19)


@variant("imu")
def imu_orientation_zero(records):
    for message in messages_of(records, IMU):
        q = message.orientation
        q.x = q.y = q.z = q.w = 0.0
    return records


@variant("imu")
def imu_not_finite(records):
    for message in messages_of(records, IMU)[::10]:
        message.angular_velocity.z = math.nan
    return records
