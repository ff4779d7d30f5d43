#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds scripts/recording_faults: its variants of a recording, which is made in memory.

check_recording_faults.py: without the package's programs, with ROS's modules; the working folder is test/
"""
import collections
import gzip
import io
import math
import pathlib
import pickle
import re
import sys
import tempfile
import unittest

import numpy as np
from geometry_msgs.msg import TransformStamped, TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, NavSatFix, PointCloud2
from tf2_msgs.msg import TFMessage

sys.dont_write_bytecode = True
SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / 'scripts'
sys.path.insert(0, str(SCRIPTS))
from recording_faults import all_kinds, points, records, variants  # noqa: E402, F401
from recording_faults.records import CLOUDS, GNSS, IMU, STATIC, TRUTH, VELOCITY, Record  # noqa: E402
from recording_faults.variants import VARIANTS  # noqa: E402

START = 1317384506 * 10**9  # ns, as of simulate_drive
COUNT = 106  # messages of each topic, 10 per second: some variants begin after 10 s
POINTS = 80  # of each cloud


def cloud():
    turn = np.arange(POINTS) / POINTS
    values = np.zeros(POINTS, [(name, '<f4') for name in ('x', 'y', 'z', 'intensity', 'time')])
    values['x'], values['y'] = 5.0 * np.cos(2 * math.pi * turn), 5.0 * np.sin(2 * math.pi * turn)
    values['z'], values['intensity'], values['time'] = 1.0, 7.0, 0.1 * turn
    message = PointCloud2()
    points.set_points(message, values)
    return message


def fix(index):
    message = NavSatFix(latitude=49.0 + 1e-5 * index, longitude=8.4, altitude=110.0)
    message.position_covariance = [1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0]
    return message


def drive():
    """The clean recording: straight on at 2 m/s."""
    transform = TransformStamped()
    transform.header.frame_id, transform.child_frame_id = 'base_link', 'velo_link'
    transform.transform.translation.x = transform.transform.rotation.w = 1.0
    result = [Record(STATIC, TFMessage([transform]), START * 1e-9)]
    for i in range(COUNT):
        imu, velocity, truth = Imu(), TwistStamped(), Odometry()
        imu.orientation.w, imu.linear_acceleration.z, imu.angular_velocity.z = 1.0, 9.8, 0.1
        velocity.twist.linear.x, truth.pose.pose.position.x, truth.pose.pose.orientation.w = 2.0, 0.2 * i, 1.0
        messages = {CLOUDS: cloud(), IMU: imu, VELOCITY: velocity, GNSS: fix(i), TRUTH: truth}
        for topic, message in messages.items():
            message.header.stamp = records.time_of(START + i * 10**8)
            message.header.frame_id = 'velo_link'
            result.append(Record(topic, message, message.header.stamp.to_sec() + 0.1))
    return result


CLEAN = drive()
# Of the records of each choice of sensors. They are many to copy; pickle is the fastest way.
PICKLED = {sensors: pickle.dumps([record for record in CLEAN if record.topic in topics + [STATIC]])
           for sensors, topics in records.SENSORS.items()}


def of_sensors(sensors):
    return pickle.loads(PICKLED[sensors])


def spoilt(name):
    return VARIANTS[name].spoilt(of_sensors(VARIANTS[name].sensors), CLEAN)


def bytes_of(listed):
    """All that a bag would hold of the records."""
    content = io.BytesIO()
    for record in listed:
        content.write(f'{record.topic} {record.time!r} '.encode())
        record.message.serialize(content)
    return content.getvalue()


def clouds_of(name):
    return records.messages_of(spoilt(name), CLOUDS)


def seconds(message):
    """The stamp since the start, exact to the nanosecond."""
    return (message.header.stamp.to_nsec() - START) * 1e-9


class Registration(unittest.TestCase):
    def test_each_decorated_function_is_a_variant_of_a_name_of_its_own(self):
        decorated = [name for path in (SCRIPTS / 'recording_faults').glob('*.py') for name in
                     re.findall(r'^@variant.*\ndef (\w+)', path.read_text(), re.MULTILINE)]
        self.assertGreater(len(decorated), 100)
        self.assertEqual(sorted(decorated), sorted(VARIANTS))

    def test_a_name_that_is_there_twice_is_refused(self):
        with self.assertRaisesRegex(ValueError, 'gnss_frozen: there are two variants'):
            @variants.variant('all')
            def gnss_frozen(_):
                return []
        self.assertEqual(VARIANTS['gnss_frozen'].kind, 'gnss')

    def test_every_choice_of_sensors_has_a_clean_recording_that_comes_first(self):
        first = list(VARIANTS)[:len(records.SENSORS)]
        self.assertEqual(sorted(first), sorted(f'{sensors}_clean' for sensors in records.SENSORS))
        for name in first:
            self.assertEqual(VARIANTS[name].sensors, name[:-len('_clean')])


class OfMessages(unittest.TestCase):
    def test_each_variant_but_the_clean_ones_changes_the_recording(self):
        before = bytes_of(CLEAN)
        untouched = {sensors: bytes_of(of_sensors(sensors)) for sensors in records.SENSORS}
        for name, variant in VARIANTS.items():
            if not variant.of_files:
                with self.subTest(name):
                    is_untouched = bytes_of(spoilt(name)) == untouched[variant.sensors]
                    self.assertEqual(is_untouched, variant.kind == 'clean')
        self.assertEqual(bytes_of(CLEAN), before)

    def test_what_keeps_a_state_begins_with_a_new_one(self):
        for name in ('two_turns_in_each_message', 'half_of_the_scans_missing_at_random', 'stamps_that_repeat',
                     'stamps_go_back_by_1_s', 'received_out_of_order', 'points_not_finite'):
            with self.subTest(name):
                self.assertEqual(bytes_of(spoilt(name)), bytes_of(spoilt(name)))

    def test_stamps_that_repeat_are_equal_in_pairs(self):
        stamps = [seconds(cloud) for cloud in clouds_of('stamps_that_repeat')]
        self.assertEqual(stamps[::2], stamps[1::2])
        self.assertEqual(len(set(stamps)), COUNT // 2)

    def test_negative_times_end_at_the_stamp(self):
        first = clouds_of('times_negative')[0]
        times = points.points_of(first)['time']
        self.assertAlmostEqual(seconds(first), 0.1)
        self.assertAlmostEqual(times[0], -0.1, places=6)
        self.assertTrue((times < 0.0).all())

    def test_odd_layouts_hold_the_same_points(self):
        clean = points.points_of(cloud())
        for name in ('fields_in_odd_order_with_padding', 'coordinates_of_float64', 'intensity_of_uint8'):
            read = points.points_of(clouds_of(name)[0])
            for field in clean.dtype.names:
                self.assertTrue((read[field] == clean[field]).all(), f'{name}: {field}')

    def test_sectors_are_the_cloud(self):
        sectors = clouds_of('sectors_of_36_degrees_as_messages')
        self.assertEqual(len(sectors), 10 * COUNT)
        times = [seconds(sector) + time for sector in sectors[:10] for time in points.points_of(sector)['time']]
        np.testing.assert_allclose(times, points.points_of(cloud())['time'], atol=1e-6)

    def test_two_turns_have_the_points_of_both(self):
        self.assertEqual([turns.width for turns in clouds_of('two_turns_in_each_message')],
                         [2 * POINTS] * (COUNT // 2))

    def test_messages_are_lost_of_one_topic_alone(self):
        for name, topic, left in (('every_second_scan_missing', CLOUDS, 53), ('imu_at_5_hz', IMU, 5)):
            expected = {t: COUNT for t in records.SENSORS[VARIANTS[name].sensors]}
            expected.update({STATIC: 1, topic: left})
            self.assertEqual(collections.Counter(record.topic for record in spoilt(name)), expected)

    def test_clouds_in_the_world_have_moved_with_the_vehicle(self):
        last = points.points_of(clouds_of('clouds_in_a_world_without_tf')[-1])
        np.testing.assert_allclose(last['x'], points.points_of(cloud())['x'] + 0.76 + 0.2 * (COUNT - 1), atol=1e-4)

    def test_wheels_add_up_the_way(self):
        last = records.messages_of(spoilt('wheel_odometry_backwards'), '/odom')[-1]
        self.assertAlmostEqual(last.pose.pose.position.x, -0.2 * (COUNT - 1), places=5)

    def test_gnss_freezes_after_nine_seconds(self):
        fixes = records.messages_of(spoilt('gnss_freezes_in_mid_drive'), GNSS)
        self.assertEqual([f.latitude for f in fixes[:91]], [fix(i).latitude for i in range(91)])
        self.assertEqual({f.latitude for f in fixes[90:]}, {fix(90).latitude})


class OfFiles(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = scratch.name
        self.clean = scratch.name + '/clean.bag'

    def made(self, name):
        return [pathlib.Path(path) for path in VARIANTS[name].make(self.clean, self.folder)]

    def test_of_bytes(self):
        content = b'#ROSBAG V2.0\nindex_pos=12345678' + bytes(100)
        pathlib.Path(self.clean).write_bytes(content)
        self.assertEqual(self.made('truncated')[0].read_bytes(), content[:len(content) // 2])
        self.assertEqual(gzip.decompress(self.made('compressed_by_gzip')[0].read_bytes()), content)
        self.assertEqual([path.read_bytes() for path in self.made('the_same_bag_twice')], [content] * 2)
        active = self.made('unindexed_and_active')[0].read_bytes()
        self.assertEqual(active, content.replace(b'12345678', bytes(8))[:int(0.97 * len(content))])

    def test_every_variant_gives_files_that_are_there(self):
        records.write_records(of_sensors('gnss')[:30], self.clean)
        for name, variant in VARIANTS.items():
            if variant.of_files:
                with self.subTest(name):
                    self.assertTrue(all(path.is_file() for path in self.made(name)))

    def test_parts_have_all_messages_and_the_transforms_each(self):
        records.write_records(of_sensors('gnss')[:31], self.clean)  # with the one of the transforms
        parts = [records.read_records(path) for path in map(str, self.made('split_in_wrong_order'))]
        times = [[r.time for r in part if r.topic != STATIC] for part in parts]
        self.assertEqual(sum(map(len, times)), 30)
        self.assertEqual([len(records.messages_of(part, STATIC)) for part in parts], [1, 1, 1])
        self.assertLess(times[2][0], times[1][0])
        self.assertLess(times[1][0], times[0][0])


if __name__ == '__main__':
    unittest.main()
