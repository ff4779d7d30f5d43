# SPDX-License-Identifier: BSD-3-Clause
"""Runs check_bag and map_bag on a variant, and compares the map with the truth."""
import json
import os
import pathlib
import shutil
import subprocess

from recording_faults.records import LIDAR_POSITION, SENSORS, STATIC, write_records
from recording_faults.variants import VARIANTS

TIME_LIMIT = 1800  # s, of one program; chosen: far longer than any of them needs
LEVER_ARM = [-coordinate for coordinate in LIDAR_POSITION]  # m, base_link in the LiDAR's frame


def program(name):
    built = pathlib.Path(__file__).resolve().parents[2] / ".build/devel/lib/lidar_mapping"
    return os.path.join(os.environ.get("LIDAR_MAPPING_PROGRAMS", built), name)


def run(command):
    """The status of a program and the lines that it printed, without those of its progress."""
    done = subprocess.run([program(command[0])] + command[1:], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, timeout=TIME_LIMIT)
    text = done.stdout.decode(errors="replace").replace("\r", "\n")
    return done.returncode, [line for line in text.splitlines()
                             if line.strip() and not line.startswith("mapping:")]


def simulate(bag, truth):
    """The clean recording: 15 s of a VLP-16, and the poses that it really had."""
    subprocess.run([program("simulate_drive"), bag, "--lidar", "vlp16", "--duration", "15",
                    "--truth", truth, "--threads", "1"], check=True)


def shifted_truth(truth, path, shift):
    """Writes the truth with stamps that are later by a shift (s), exact to the nanosecond."""
    with open(truth) as lines, open(path, "w") as out:
        for line in lines:
            words = line.split()
            seconds, _, fraction = words[0].partition(".")
            nanoseconds = int(seconds) * 10**9 + int(fraction.ljust(9, "0")) + round(shift * 1e9)
            words[0] = f"{nanoseconds // 10**9}.{nanoseconds % 10**9:09d}"
            out.write(" ".join(words) + "\n")
    return path


def time_span(path):
    """The first and the last stamp (s) of a trajectory; nothing if it has none."""
    with open(path) as lines:
        stamps = [float(line.split()[0]) for line in lines if line[0] != "#"]
    return (stamps[0], stamps[-1]) if stamps else None


def error_of(folder, truth, trajectory, shift):
    """APE (m, RMSE), and the fraction of the drive's time that the key frames cover."""
    span = time_span(trajectory) if os.path.exists(trajectory) else None
    if span is None:
        return None, 0.0
    begin, end = time_span(truth)
    moved = shifted_truth(truth, folder + "/truth.tum", shift)
    errors = [ape_of(moved, trajectory, arm) for arm in ([], LEVER_ARM)]
    known = [error for error in errors if error is not None]
    return min(known, default=None), (span[1] - span[0]) / (end - begin)


def ape_of(truth, trajectory, arm):
    """The map may be of base_link or, where nothing leads to that, of the LiDAR: with an arm."""
    figures = truth + ".json"
    lever = ["--lever-arm"] + [str(x) for x in arm] if arm else []
    status, _ = run(["evaluate_trajectory", truth, trajectory, "--align", "--json", figures] +
                    lever)
    if status != 0:
        return None
    with open(figures) as file:
        return json.load(file)["ape"]["translation_m"]["rmse"]


def make_inputs(variant, clean_bag, clean, folder):
    """Writes the files of a variant; their paths."""
    if variant.of_files:
        return variant.make(clean_bag, folder)
    wanted = SENSORS[variant.sensors] + [STATIC]
    records = [record.copy() for record in clean if record.topic in wanted]
    write_records(variant.spoilt(records, clean), folder + "/spoilt.bag")
    return [folder + "/spoilt.bag"]


def examine(name, options, clean):
    """What the programs made of a variant and said about it, without a verdict."""
    variant = VARIANTS[name]
    folder = os.path.join(options.output, name)
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    inputs = make_inputs(variant, options.clean, clean, folder)
    result = {"name": name, "sensors": variant.sensors}
    result["check_status"], result["check_bag"] = run(["check_bag"] + inputs)
    session = folder + "/map"
    result["map_status"], result["map_bag"] = run(["map_bag"] + inputs + [
        "-o", session, "--no-map", "--threads", "1"])
    result["ape"], result["coverage"] = error_of(
        folder, options.truth, session + "/trajectory/optimized.tum", variant.truth_shift)
    shutil.rmtree(session, ignore_errors=True)
    if not options.keep:
        for path in inputs:
            os.remove(path)
    return result
