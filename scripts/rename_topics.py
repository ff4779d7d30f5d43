#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Copy a bag with other names for some topics.

usage: rename_topics.py IN.bag OUT.bag OLD:=NEW ...
"""
import sys

import rosbag


def main(source, target, *renamed):
    names = dict(pair.split(':=') for pair in renamed)
    with rosbag.Bag(source) as bag, rosbag.Bag(target, 'w') as copy:
        for topic, message, stamp, header in bag.read_messages(raw=True, return_connection_header=True):
            copy.write(names.get(topic, topic), message, stamp, raw=True, connection_header=header)


if __name__ == '__main__':
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
