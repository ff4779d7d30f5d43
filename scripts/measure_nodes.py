#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measure what the nodes of mapping.launch send and compute while a session grows (doc/results/pipeline.md).

The session is resumed, as live operation goes on with a drive of any length; then the bag is played, and the
bytes of each topic and the processor time of each node are counted while it is played. All topics are
subscribed to, as rviz does. The stamps of the bag have to lie behind those of the session, which is not
changed: a copy is resumed. The package must be built and its setup sourced.

usage: measure_nodes.py SESSION BAG [--rate 1] [-o FIGURES.json]
"""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import xmlrpc.client

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from run_demo import free_port  # noqa: E402

QUIET = (5.0, 100e3)  # s with fewer bytes: late subscribers have what they are given; diagnostics go on
PATIENCE = 300.0  # s for the nodes to be there
TICKS = os.sysconf('SC_CLK_TCK')


class Traffic:
    """Bytes of all topics, counted by subscribing to each of them."""

    def __init__(self, rospy):
        self._rospy, self._lock, self._bytes, self._known = rospy, threading.Lock(), {}, {}

    def subscribe_to_new(self):
        for topic, _ in self._rospy.get_published_topics():
            if topic not in self._known and topic not in ('/clock', '/rosout', '/rosout_agg'):
                self._known[topic] = self._rospy.Subscriber(topic, self._rospy.AnyMsg, self._count, topic)

    def _count(self, message, topic):
        with self._lock:
            self._bytes[topic] = self._bytes.get(topic, 0) + len(message._buff)

    def bytes(self):
        with self._lock:
            return dict(self._bytes)

    def wait_until_quiet(self):
        before, now = -QUIET[1], 0
        while now - before >= QUIET[1]:
            self.subscribe_to_new()
            before = sum(self.bytes().values())
            time.sleep(QUIET[0])
            now = sum(self.bytes().values())


def node_pids(master):
    """Processes of the package's nodes, by their names without the slash."""
    publishers = master.getSystemState()[0]
    names = {node for _, nodes in publishers for node in nodes if node.endswith('_node')}
    return {name[1:]: xmlrpc.client.ServerProxy(master.lookupNode(name)).getPid('/measure')[2]
            for name in sorted(names)}


def processor_seconds(pids):
    result = {}
    for name, pid in pids.items():
        words = pathlib.Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
        result[name] = (int(words[11]) + int(words[12])) / TICKS  # user and system
    return result


def resident_megabytes(pids):
    page = os.sysconf('SC_PAGE_SIZE')
    return {name: int(pathlib.Path(f'/proc/{pid}/statm').read_text().split()[1]) * page / 1e6
            for name, pid in pids.items()}


def difference(after, before):
    return {name: value - before.get(name, 0) for name, value in after.items()}


def play(bag, rate, traffic):
    """Seconds of the bag's own time that were played."""
    begin = time.monotonic()
    subprocess.run(['rosbag', 'play', '--clock', '--quiet', '-d', '3', '--skip-empty=5', '-r', str(rate), bag],
                   check=True, stdout=subprocess.DEVNULL)
    seconds = (time.monotonic() - begin) * rate
    traffic.wait_until_quiet()
    return seconds


def measure(options, folder):
    import rosgraph
    import rospy
    shutil.copytree(options.session, folder / 'session')
    launch = subprocess.Popen(['roslaunch', 'lidar_mapping', 'mapping.launch', 'rviz:=false',
                               f'resume:={folder / "session"}', f'session_directory:={folder / "sessions"}'],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        master = rosgraph.Master('/measure')
        deadline = time.monotonic() + PATIENCE
        while not master.is_online() or len(node_pids(master)) < 6:
            if time.monotonic() > deadline or launch.poll() is not None:
                sys.exit('measure_nodes: the nodes of mapping.launch do not come up')
            time.sleep(0.5)
        rospy.init_node('measure', disable_signals=True)
        traffic = Traffic(rospy)
        traffic.wait_until_quiet()
        pids = node_pids(master)
        bytes_before, seconds_before = traffic.bytes(), processor_seconds(pids)
        seconds = play(options.bag, options.rate, traffic)
        return {'seconds': seconds,
                'bytes_given_to_late_subscribers': bytes_before,
                'bytes_per_second': {topic: count / seconds for topic, count in
                                     difference(traffic.bytes(), bytes_before).items() if count},
                'processor_seconds_per_second': {node: used / seconds for node, used in
                                                 difference(processor_seconds(pids), seconds_before).items()},
                'resident_megabytes': resident_megabytes(pids)}
    finally:
        launch.terminate()
        launch.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('session', type=pathlib.Path)
    parser.add_argument('bag', type=pathlib.Path)
    parser.add_argument('--rate', type=float, default=1.0, help='speed of playing')
    parser.add_argument('-o', '--output', type=pathlib.Path, help='write the figures to this file, too')
    options = parser.parse_args()
    os.environ['ROS_MASTER_URI'] = f'http://127.0.0.1:{free_port()}'
    os.environ['ROS_IP'] = '127.0.0.1'
    with tempfile.TemporaryDirectory() as folder:
        os.environ['ROS_LOG_DIR'] = str(pathlib.Path(folder) / 'log')
        figures = measure(options, pathlib.Path(folder))
    for part, values in figures.items():
        if not isinstance(values, dict):
            continue
        print(part)
        for name, value in sorted(values.items()):
            print(f'  {name:40} {value:14.4g}')
    if options.output:
        options.output.write_text(json.dumps(figures, indent=1) + '\n')


if __name__ == '__main__':
    main()
