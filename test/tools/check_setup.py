#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds the addresses that scripts/setup.bash gives to the nodes of its shell.

check_setup.py: without the package's programs; the working folder is test/
"""
import os
import pathlib
import subprocess
import tempfile
import unittest

SETUP = pathlib.Path(__file__).resolve().parents[2] / 'scripts' / 'setup.bash'


def address(**variables):
    """ROS_IP after sourcing it with these variables; empty if that is not set."""
    with tempfile.TemporaryDirectory() as build:
        (pathlib.Path(build) / 'devel').mkdir()
        (pathlib.Path(build) / 'devel' / 'setup.bash').write_text('')
        others = {name: value for name, value in os.environ.items() if not name.startswith('ROS_')}
        return subprocess.run(['bash', '-c', f'. "{SETUP}" && printf %s "${{ROS_IP:-}}"'], check=True, text=True,
                              env={**others, 'LIDAR_MAPPING_BUILD': build, **variables},
                              stdout=subprocess.PIPE).stdout


class Setup(unittest.TestCase):
    def test_nodes_of_one_computer_need_no_name_that_resolves(self):
        self.assertEqual(address(), '127.0.0.1')
        for host in ('localhost', '127.0.0.1', '127.0.1.1', ''):
            self.assertEqual(address(ROS_MASTER_URI=f'http://{host}:11311'), '127.0.0.1')

    def test_a_master_on_another_computer_reaches_the_nodes(self):
        for host in ('other', '192.168.1.7', 'localhost.of.others'):
            self.assertEqual(address(ROS_MASTER_URI=f'http://{host}:11311'), '')

    def test_what_the_user_has_set_stays(self):
        self.assertEqual(address(ROS_IP='10.0.0.2'), '10.0.0.2')
        self.assertEqual(address(ROS_HOSTNAME='robot'), '')


if __name__ == '__main__':
    unittest.main()
