#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Computes absolute, relative and KITTI's errors from the definitions with numpy alone, and compares
them with the figures that evaluate_trajectory wrote.

check_trajectory_errors.py TRUTH ESTIMATE FIGURES.json
"""
import json
import sys

import numpy as np


def rotation_of(x, y, z, w):
    x, y, z, w = np.array([x, y, z, w]) / np.linalg.norm([x, y, z, w])
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def read(path):
    """Stamps (None in KITTI's format) and 4x4 poses."""
    stamps, poses = [], []
    for values in np.loadtxt(path, ndmin=2):
        pose = np.eye(4)
        if len(values) == 12:
            pose[:3] = values.reshape(3, 4)
        else:
            stamps.append(values[0])
            pose[:3, 3] = values[1:4]
            pose[:3, :3] = rotation_of(*values[4:])
        poses.append(pose)
    return np.array(stamps) if stamps else None, np.array(poses)


def angle(rotation):
    """By the antisymmetric part as well, as the trace alone is poor near zero."""
    skew = [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0],
            rotation[1, 0] - rotation[0, 1]]
    return np.arctan2(np.linalg.norm(skew), np.trace(rotation) - 1.0)


def turned(rotation, share):
    """The rotation about the same axis by a share of the angle (Rodrigues)."""
    full = angle(rotation)
    if full < 1e-12:
        return np.eye(3)
    k = (rotation - rotation.T) / (2.0 * np.sin(full))
    return np.eye(3) + np.sin(share * full) * k + (1.0 - np.cos(share * full)) * k @ k


def between(a, b, share):
    pose = np.eye(4)
    pose[:3, 3] = (1.0 - share) * a[:3, 3] + share * b[:3, 3]
    pose[:3, :3] = a[:3, :3] @ turned(a[:3, :3].T @ b[:3, :3], share)
    return pose


def associated(truth, estimate):
    (true_stamps, true_poses), (stamps, poses) = truth, estimate
    if true_stamps is None or stamps is None:
        return true_poses, poses
    pairs = []
    for stamp, pose in zip(stamps, poses):
        after = np.searchsorted(true_stamps, stamp)
        if after < len(true_stamps) and true_stamps[after] == stamp:
            pairs.append((true_poses[after], pose))
        elif 0 < after < len(true_stamps):
            begin, end = true_stamps[after - 1], true_stamps[after]
            share = (stamp - begin) / (end - begin)
            pairs.append((between(true_poses[after - 1], true_poses[after], share), pose))
    return np.array([p[0] for p in pairs]), np.array([p[1] for p in pairs])


def on_vehicle(estimate, position, angles_deg):
    """The estimate of another frame on the vehicle, whose place and angles are given."""
    lever = np.eye(4)
    if position:
        lever[:3, 3] = position
    if angles_deg:
        (a, b, c), (d, e, f) = np.cos(np.radians(angles_deg)), np.sin(np.radians(angles_deg))
        roll = np.array([[1, 0, 0], [0, a, -d], [0, d, a]])
        pitch = np.array([[b, 0, e], [0, 1, 0], [-e, 0, b]])
        yaw = np.array([[c, -f, 0], [f, c, 0], [0, 0, 1]])
        lever[:3, :3] = yaw @ pitch @ roll
    return estimate @ lever


def scaled(truth, estimate):
    """By the scale of Umeyama (1991), equation 42."""
    p = estimate[:, :3, 3] - estimate[:, :3, 3].mean(0)
    q = truth[:, :3, 3] - truth[:, :3, 3].mean(0)
    u, d, vt = np.linalg.svd(q.T @ p)
    d[2] *= np.sign(np.linalg.det(u @ vt))
    result = estimate.copy()
    result[:, :3, 3] *= d.sum() / (p**2).sum()
    return result


def aligned(truth, estimate):
    """Kabsch: the rotation from the singular values of the covariance of the positions."""
    p, q = estimate[:, :3, 3], truth[:, :3, 3]
    u, _, vt = np.linalg.svd((p - p.mean(0)).T @ (q - q.mean(0)))
    motion = np.eye(4)
    motion[:3, :3] = vt.T @ np.diag([1, 1, np.sign(np.linalg.det(vt.T @ u.T))]) @ u.T
    motion[:3, 3] = q.mean(0) - motion[:3, :3] @ p.mean(0)
    return motion @ estimate


def statistics(values):
    values = np.array(values)
    return {"rmse": np.sqrt(np.mean(values**2)), "mean": values.mean(),
            "median": np.median(values), "max": values.max()}


def errors_of(differences):
    return {"translation_m": statistics([np.linalg.norm(d[:3, 3]) for d in differences]),
            "rotation_deg": statistics([np.degrees(angle(d[:3, :3])) for d in differences])}


def motion_error(truth, estimate, i, j):
    inverse = np.linalg.inv
    return inverse(inverse(truth[i]) @ truth[j]) @ (inverse(estimate[i]) @ estimate[j])


def kitti(truth, estimate, way, lengths):
    translation, rotation = [], []
    for length in lengths:
        for i in range(len(way)):
            behind = np.nonzero(way >= way[i] + length)[0]
            if len(behind) == 0:
                break
            error = motion_error(truth, estimate, i, behind[0])
            translation.append(100.0 * np.linalg.norm(error[:3, 3]) / length)
            rotation.append(100.0 * np.degrees(angle(error[:3, :3])) / length)
    return {"translation_percent": np.mean(translation),
            "rotation_deg_per_100m": np.mean(rotation), "segments": len(translation)}


def compare(name, ours, theirs):
    if isinstance(ours, dict):
        return all([compare(f"{name}.{key}", value, theirs[key]) for key, value in ours.items()])
    is_equal = abs(ours - theirs) <= 1e-6 + 1e-6 * abs(ours)
    if not is_equal:
        print(f"{name}: {theirs} is told, {ours} comes out here")
    return is_equal


def main():
    truth, estimate = associated(read(sys.argv[1]), read(sys.argv[2]))
    with open(sys.argv[3]) as file:
        told = json.load(file)
    estimate = on_vehicle(estimate, told["lever_arm_m"], told["lever_rotation_deg"])
    if told["alignment"] in ("scale", "similarity"):
        estimate = scaled(truth, estimate)
    if told["alignment"] in ("rigid", "similarity"):
        estimate = aligned(truth, estimate)
    if told["alignment"] == "origin":
        estimate = truth[0] @ np.linalg.inv(estimate[0]) @ estimate
    steps = np.linalg.norm(np.diff(truth[:, :3, 3], axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    relative = []
    for i in range(len(way)):
        behind = np.nonzero(way >= way[i] + told["rpe_delta_m"])[0]
        if len(behind) > 0:
            relative.append(motion_error(truth, estimate, i, behind[0]))
    computed = {"poses": len(truth), "length_m": way[-1],
                "ape": errors_of(np.linalg.inv(truth) @ estimate), "rpe": errors_of(relative),
                "kitti": kitti(truth, estimate, way, told["kitti"]["segment_lengths_m"])}
    sys.exit(0 if compare("figures", computed, told) else 1)


main()
