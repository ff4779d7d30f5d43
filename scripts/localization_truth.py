# SPDX-License-Identifier: BSD-3-Clause
"""The truth of simulated drives, and the errors of localised scans against it (for measure_localization.py)."""
import math
from typing import NamedTuple

import numpy as np

WRONG_M, WRONG_DEG = 0.5, 2.0  # a pose that is farther off is wrong
GAP = 0.2  # s, between poses of the truth that are interpolated at most
JUMP = 3.0  # m, the same: a vehicle that is not carried away moves less in 0.1 s


class Trajectory(NamedTuple):
    stamps: np.ndarray  # s
    positions: np.ndarray  # m, a row for each
    quaternions: np.ndarray  # x y z w

    @staticmethod
    def read(path):
        rows = np.loadtxt(path, ndmin=2).reshape(-1, 8)
        return Trajectory(rows[:, 0], rows[:, 1:4], rows[:, 4:8])

    def times(self):
        """s since the first pose."""
        return self.stamps - self.stamps[0]

    def ways(self):
        """m driven since the first pose."""
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.positions, axis=0), axis=1))])


def rotation_of(q):
    x, y, z, w = q / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def at(trajectory, stamp):
    """Position and rotation at a stamp, or nothing outside of the trajectory and where it jumps."""
    i = int(np.searchsorted(trajectory.stamps, stamp))
    for k in (i, i - 1):
        if 0 <= k < len(trajectory.stamps) and abs(trajectory.stamps[k] - stamp) < 1e-4:
            return trajectory.positions[k], rotation_of(trajectory.quaternions[k])
    if i == 0 or i == len(trajectory.stamps) or trajectory.stamps[i] - trajectory.stamps[i - 1] > GAP:
        return None
    if np.linalg.norm(trajectory.positions[i] - trajectory.positions[i - 1]) > JUMP:
        return None
    u = (stamp - trajectory.stamps[i - 1]) / (trajectory.stamps[i] - trajectory.stamps[i - 1])
    a, b = trajectory.quaternions[i - 1], trajectory.quaternions[i]
    q = (1 - u) * a + u * (b if a @ b > 0 else -b)
    return (1 - u) * trajectory.positions[i - 1] + u * trajectory.positions[i], rotation_of(q)


def alignment(truth, estimate):
    """R, t with truth = R estimate + t (Umeyama 1991, without scale)."""
    pairs = [(at(truth, stamp), p) for stamp, p in zip(estimate.stamps, estimate.positions)]
    pairs = [(pose[0], p) for pose, p in pairs if pose is not None]
    a, b = np.array([p for p, _ in pairs]), np.array([p for _, p in pairs])
    u, _, vt = np.linalg.svd((a - a.mean(0)).T @ (b - b.mean(0)))
    r = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return r, a.mean(0) - r @ b.mean(0)


def angle_deg(r):
    return math.degrees(math.acos(max(-1.0, min(1.0, (np.trace(r) - 1) / 2))))


class PoseError(NamedTuple):
    metres: float
    degrees: float
    square: float  # of the translation, mean over the axes, in units of the claimed variance

    def is_wrong(self):
        return self.metres > WRONG_M or self.degrees > WRONG_DEG


def error_of(row, truth, r_align, t_align):
    """PoseError of a row of localization.csv; nothing without a pose, or where the truth has none."""
    true = at(truth, float(row['stamp'])) if row['x'] else None
    if true is None:
        return None
    p = r_align @ np.array([float(row[c]) for c in 'xyz']) + t_align
    r = r_align @ rotation_of(np.array([float(row[c]) for c in ('qx', 'qy', 'qz', 'qw')]))
    error = r.T @ (true[0] - p)
    sigma = np.array([float(row['stddev_' + c]) for c in 'xyz'])
    return PoseError(np.linalg.norm(error), angle_deg(r.T @ true[1]), float(np.mean((error / sigma) ** 2)))
