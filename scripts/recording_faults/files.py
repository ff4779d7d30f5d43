# SPDX-License-Identifier: BSD-3-Clause
"""Faults of the files: compressed, cut, split, empty, or no recording at all."""
import gzip
import pathlib
import shutil

import genpy
import rosbag
from sensor_msgs.msg import Image

from recording_faults.records import STATIC
from recording_faults.variants import variant_of_files


def copy_bag(source, target, compression="none", kept=lambda topic, index: True):
    """Copies a bag but for the messages for which kept(topic, index in the bag) is false."""
    with rosbag.Bag(source) as bag, rosbag.Bag(target, "w", compression=compression) as out:
        for index, (topic, message, time) in enumerate(bag.read_messages(raw=True)):
            if kept(topic, index):
                out.write(topic, message, time, raw=True)
    return target


def file_of(folder, content, name="a.bag"):
    """The paths of an input of one file with these bytes."""
    path = pathlib.Path(folder, name)
    path.write_bytes(content)
    return [str(path)]


@variant_of_files
def compressed_by_bz2(clean, folder):
    return [copy_bag(clean, folder + "/a.bag", "bz2")]


@variant_of_files
def compressed_by_lz4(clean, folder):
    return [copy_bag(clean, folder + "/a.bag", "lz4")]


@variant_of_files
def compressed_by_gzip(clean, folder):
    return file_of(folder, gzip.compress(pathlib.Path(clean).read_bytes(), 1), "a.bag.gz")


@variant_of_files
def unindexed_and_active(clean, folder):
    """As a flat battery leaves it: no index, the last chunk cut."""
    data = bytearray(pathlib.Path(clean).read_bytes())
    index = data.find(b"index_pos=") + len(b"index_pos=")
    data[index:index + 8] = bytes(8)
    return file_of(folder, data[:int(len(data) * 0.97)], "a.bag.active")


@variant_of_files
def truncated(clean, folder):
    data = pathlib.Path(clean).read_bytes()
    return file_of(folder, data[:len(data) // 2])


@variant_of_files
def no_messages(clean, folder):
    rosbag.Bag(folder + "/a.bag", "w").close()
    return [folder + "/a.bag"]


@variant_of_files
def no_bytes(clean, folder):
    return file_of(folder, b"")


@variant_of_files
def no_bag_but_text(clean, folder):
    return file_of(folder, b"<html>404 Not Found</html>\n")


@variant_of_files
def images_alone(clean, folder):
    with rosbag.Bag(folder + "/a.bag", "w") as bag:
        for i in range(10):
            image = Image()
            image.header.stamp = genpy.Time(1000 + i)
            bag.write("/camera/image", image, image.header.stamp)
    return [folder + "/a.bag"]


def split(clean, folder, overlap=0):
    """Three bags, each with the static transforms; `overlap` messages are in two of them."""
    with rosbag.Bag(clean) as bag:
        count = bag.get_message_count()
    third = count // 3
    ranges = [(0, third + overlap), (third, 2 * third + overlap), (2 * third, count)]
    return [copy_bag(clean, f"{folder}/{name}.bag",
                     kept=lambda topic, i, r=r: r[0] <= i < r[1] or topic == STATIC)
            for name, r in zip("abc", ranges)]


@variant_of_files
def split_in_wrong_order(clean, folder):
    return split(clean, folder)[::-1]


@variant_of_files
def split_without_its_middle(clean, folder):
    return split(clean, folder)[::2]


@variant_of_files
def split_with_overlap(clean, folder):
    return split(clean, folder, 200)


@variant_of_files
def the_same_bag_twice(clean, folder):
    return [shutil.copy(clean, f"{folder}/{name}.bag") for name in "ab"]
