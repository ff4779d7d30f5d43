# SPDX-License-Identifier: BSD-3-Clause
"""Faults of headers: frames and stamps; and of the times at which messages were recorded."""
import numpy as np

from recording_faults.records import (CLOUDS, SENSORS, SWEEP, first_stamp, messages_of, shift_stamp,
                                      with_frame, with_shifted_stamps, with_stamps_of_zero)
from recording_faults.variants import variant

UPTIME_SHIFT = 100.0 - 1317384506.0  # s: a sensor that was switched on 100 s before the drive
MIDDLE = 10.0  # s after the start of the drive, which takes 15 s


@variant("clouds")
def frame_empty(records):
    return with_frame(records, "", CLOUDS)


@variant("all")
def frames_empty_of_all(records):
    return with_frame(records, "", *SENSORS["all"])


@variant("clouds")
def frame_with_slash(records):
    return with_frame(records, "/velo_link", CLOUDS)


@variant("clouds")
def frame_changes_in_mid_drive(records):
    for index, cloud in enumerate(messages_of(records, CLOUDS)):
        cloud.header.frame_id = "velodyne" if index > 70 else "velo_link"
    return records


@variant("all", truth_shift=SWEEP)
def stamps_zero(records):
    return with_stamps_of_zero(records, CLOUDS)


@variant("all", truth_shift=UPTIME_SHIFT)
def stamps_of_clouds_of_uptime(records):
    return with_shifted_stamps(records, UPTIME_SHIFT, CLOUDS)


@variant("all", truth_shift=37.0)
def stamps_of_clouds_37_s_ahead(records):
    """In the time of atomic clocks (TAI), which is 37 s ahead of UTC."""
    return with_shifted_stamps(records, 37.0, CLOUDS)


@variant("all", truth_shift=2.0)
def stamps_of_clouds_2_s_ahead(records):
    return with_shifted_stamps(records, 2.0, CLOUDS)


@variant("clouds")
def stamps_that_repeat(records):
    clouds = messages_of(records, CLOUDS)
    for before, after in zip(clouds[::2], clouds[1::2]):
        after.header.stamp = before.header.stamp
    return records


@variant("all")
def stamps_go_back_by_1_s(records):
    middle = first_stamp(records) + MIDDLE
    for message in messages_of(records, *SENSORS["all"]):
        if message.header.stamp.to_sec() > middle:
            shift_stamp(message, -1.0)
    return records


@variant("clouds")
def stamps_of_clouds_go_back_by_1_s(records):
    for cloud in messages_of(records, CLOUDS)[91:]:
        shift_stamp(cloud, -1.0)
    return records


def stamped_late(records, delay, recording):
    """Clouds with stamps that are late by delay(), and recorded so many seconds after these."""
    for record in records:
        if record.topic == CLOUDS:
            shift_stamp(record.message, delay())
            record.time = record.message.header.stamp.to_sec() + recording
    return records


@variant("all", truth_shift=SWEEP)
def stamps_at_the_end_of_the_sweep(records):
    return stamped_late(records, lambda: SWEEP, 0.01)


@variant("all", truth_shift=SWEEP + 0.015)
def stamps_of_clouds_by_arrival(records):
    """Stamped by the driver's computer when the sweep is complete, with jitter."""
    noise = np.random.default_rng(1)
    return stamped_late(records, lambda: SWEEP + noise.uniform(0.0, 0.03), 0.002)


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
