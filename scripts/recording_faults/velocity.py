# SPDX-License-Identifier: BSD-3-Clause
"""Faults of velocities: units, signs, axes, stamps; and odometry of wheels in their place."""
from nav_msgs.msg import Odometry

from recording_faults.imu import scale
from recording_faults.records import VELOCITY, Record, messages_of, with_shifted_stamps
from recording_faults.variants import variant


def with_scaled_velocity(records, factor):
    for message in messages_of(records, VELOCITY):
        scale(message.twist.linear, factor)
    return records


@variant("velocity")
def velocity_in_kmh_without_gnss(records):
    return with_scaled_velocity(records, 3.6)


@variant("all")
def velocity_in_kmh(records):
    return with_scaled_velocity(records, 3.6)


@variant("velocity")
def velocity_of_the_wrong_sign_without_gnss(records):
    return with_scaled_velocity(records, -1.0)


@variant("all")
def velocity_of_the_wrong_sign(records):
    return with_scaled_velocity(records, -1.0)


@variant("velocity")
def velocity_always_zero(records):
    return with_scaled_velocity(records, 0.0)


@variant("velocity")
def velocity_sideways(records):
    for message in messages_of(records, VELOCITY):
        v = message.twist.linear
        v.x, v.y = -v.y, v.x
    return records


@variant("velocity")
def velocity_late_by_500_ms(records):
    return with_shifted_stamps(records, 0.5, VELOCITY)


@variant("clouds", beside_clean=True)
def wheel_odometry_without_covariance(records, clean):
    return records + odometry_of_wheels(clean, 1.0)


@variant("clouds", beside_clean=True)
def wheel_odometry_backwards(records, clean):
    return records + odometry_of_wheels(clean, -1.0)


def odometry_of_wheels(clean, sign):
    """The velocities of the clean recording as Odometry, summed up along x."""
    result, last, x = [], None, 0.0
    for record in clean:
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
