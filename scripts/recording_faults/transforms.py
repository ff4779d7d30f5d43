# SPDX-License-Identifier: BSD-3-Clause
"""Faults of the static transforms between the sensors and the vehicle."""
import copy
import math

from geometry_msgs.msg import Quaternion

from recording_faults.records import STATIC, messages_of
from recording_faults.variants import variant


def transforms_of(records):
    return [transform for message in messages_of(records, STATIC)
            for transform in message.transforms]


def scale_values(values, axes, factor):
    for axis in axes:
        setattr(values, axis, factor * getattr(values, axis))


@variant("all")
def tf_static_missing(records):
    return [record for record in records if record.topic != STATIC]


@variant("all")
def tf_with_a_cycle(records):
    for message in messages_of(records, STATIC):
        extra = copy.deepcopy(message.transforms[0])
        extra.header.frame_id, extra.child_frame_id = "velo_link", "base_link"
        message.transforms.append(extra)
    return records


@variant("all")
def tf_not_normalised(records):
    for transform in transforms_of(records):
        scale_values(transform.transform.rotation, "xyzw", 2.0)
    return records


@variant("all")
def tf_quaternion_zero(records):
    for transform in transforms_of(records):
        transform.transform.rotation = Quaternion(0.0, 0.0, 0.0, 0.0)
    return records


@variant("all")
def tf_not_a_number(records):
    for message in messages_of(records, STATIC):
        message.transforms[0].transform.translation.x = math.nan
    return records


@variant("all")
def tf_in_millimetres(records):
    for transform in transforms_of(records):
        scale_values(transform.transform.translation, "xyz", 1000.0)
    return records


@variant("all")
def tf_named_base_footprint(records):
    for transform in transforms_of(records):
        transform.header.frame_id = "base_footprint"
    return records


@variant("all")
def tf_static_at_the_end_of_the_bag(records):
    for record in records:
        if record.topic == STATIC:
            record.time += 14.9
    return records
