# SPDX-License-Identifier: BSD-3-Clause
"""The messages of a recording as a list in memory, and changes that several faults make."""
import copy

import genpy
import rosbag

CLOUDS = "/kitti/velo/pointcloud"
IMU = "/kitti/oxts/imu"
VELOCITY = "/kitti/oxts/gps/vel"
GNSS = "/kitti/oxts/gps/fix"
STATIC = "/tf_static"
TRUTH = "/ground_truth"
# The topics of each choice of sensors; the static transforms belong to all of them.
SENSORS = {
    "clouds": [CLOUDS],
    "imu": [CLOUDS, IMU],
    "velocity": [CLOUDS, VELOCITY],
    "gnss": [CLOUDS, GNSS],
    "all": [CLOUDS, IMU, VELOCITY, GNSS],
}
SWEEP = 0.1  # s, duration of a sweep of the simulated LiDAR
LIDAR_POSITION = (0.76, 0.02, 1.73)  # m, of the simulated LiDAR in base_link


class Record:
    """A message of the recording, with its topic and the time when it was recorded (s)."""

    def __init__(self, topic, message, time):
        self.topic, self.message, self.time = topic, message, time

    def copy(self):
        return Record(self.topic, copy.deepcopy(self.message), self.time)


def messages_of(records, *topics):
    """The messages of these topics, in the order of the recording."""
    return [record.message for record in records if record.topic in topics]


def with_frame(records, frame, *topics):
    for message in messages_of(records, *topics):
        message.header.frame_id = frame
    return records


def shift_stamp(message, seconds):
    message.header.stamp = time_of(message.header.stamp.to_nsec() + round(seconds * 1e9))


def with_shifted_stamps(records, seconds, *topics):
    for message in messages_of(records, *topics):
        shift_stamp(message, seconds)
    return records


def with_stamps_of_zero(records, topic):
    for message in messages_of(records, topic):
        message.header.stamp = genpy.Time(0)
    return records


def without(records, topic, is_lost):
    """The records but for those of the topic for which is_lost(record, index) is true."""
    result, index = [], 0
    for record in records:
        if record.topic != topic:
            result.append(record)
            continue
        if not is_lost(record, index):
            result.append(record)
        index += 1
    return result


def first_stamp(records):
    return min(r.message.header.stamp.to_sec() for r in records if hasattr(r.message, "header"))


def time_of(nanoseconds):
    return genpy.Time(nanoseconds // 10**9, nanoseconds % 10**9)


def read_records(path):
    with rosbag.Bag(path) as bag:
        return [Record(topic, message, time.to_sec()) for topic, message, time in
                bag.read_messages()]


def write_records(records, path):
    """Writes a bag in the order of the times of recording; a bag cannot hold the time 0."""
    with rosbag.Bag(path, "w") as bag:
        for record in sorted(records, key=lambda r: r.time):
            bag.write(record.topic, record.message, genpy.Time.from_sec(max(record.time, 0.01)))
