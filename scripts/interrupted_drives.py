# SPDX-License-Identifier: BSD-3-Clause
"""Interrupted drives for measure_localization.py: recordings that jump, that lose their sight, that leave the map,
and that stand for long; and what localisation makes of them."""
import contextlib
import math
import random
import shutil
import sqlite3
from typing import NamedTuple

import numpy as np
import rosbag
from genpy import Time

from localization_truth import Trajectory, error_of

CLOUDS = '/kitti/velo/pointcloud'
FIRST_SCAN = 0.2  # s from the begin of a simulated drive to its first scan
LEAD, TAIL = 10.0, 25.0  # s that are driven before and after an interruption
BLIND = 5.0  # s of a black-out
OUTSIDE = 500.0  # m of the way that the map lacks
REACH = 10.0  # m: places of the map that are nearer to the way are passed on it
STANDING = 3.0  # s of a halt (4 s) that are repeated, each time with other parked cars
DAYS, ROUNDS = 10, 10  # of parked cars while standing, and how often they come: 300 s
SOON = 2.0  # s, within which an interruption should be said
SCAN_RATE = 10.0  # scans per second
MARGIN = 3.0  # s at the ends of a drive that are left alone


class Piece(NamedTuple):
    """A part of a simulated drive."""
    begin: float  # s after its beginning
    end: float
    words: tuple = ()  # options of simulate_drive with their values, instead of those of the drive
    has_clouds: bool = True


class Interruption(NamedTuple):
    """A drive of several pieces, as if it were one."""
    pieces: tuple
    begins: float  # s after the first scan: from here on the place is another one, or cannot be seen
    ends: float  # and from here on it can be found
    is_sudden: bool = True  # what is seen changes at once, so it can be said at once


def header_stamp(data):
    """ns of a serialized message that begins with a header."""
    return int.from_bytes(data[4:8], 'little') * 10**9 + int.from_bytes(data[8:12], 'little')


def with_stamp(data, stamp):
    seconds, rest = divmod(stamp, 10**9)
    return data[:4] + seconds.to_bytes(4, 'little') + rest.to_bytes(4, 'little') + data[12:]


def nanoseconds(seconds):
    return round(seconds * 10) * 10**8  # pieces begin and end with scans, at 10 Hz


def join(world, name, words, pieces, target):
    """Simulates the pieces of a drive of `world` and writes them as one bag, the stamps going on without a gap;
    returns the truth of the whole."""
    simulated, truths, clock = {}, [], None
    unfinished = target.with_suffix('.unfinished')
    with rosbag.Bag(str(unfinished), 'w', compression='lz4') as out:
        for piece in pieces:
            if piece not in simulated:
                simulated[piece] = simulate(world, f'{name}_piece_{len(simulated)}', words, piece)
            bag, truth = simulated[piece]
            first = round(truth.stamps[0] * 10**9)  # of the first scan, which is at the piece's begin
            shift = 0 if clock is None else clock - first
            copy(bag, out, piece, first, shift, is_first=clock is None)
            clock = first + shift + nanoseconds(piece.end - piece.begin)
            truths.append(Trajectory(truth.stamps + shift * 1e-9, truth.positions, truth.quaternions))
    for bag, _ in simulated.values():
        bag.unlink()
    unfinished.rename(target)
    return Trajectory(*(np.concatenate(arrays) for arrays in zip(*truths)))


def simulate(world, name, words, piece):
    """The bag of a piece, which begins somewhat earlier, and its truth, which begins with it."""
    span = ('--start', piece.begin - FIRST_SCAN, '--duration', piece.end + FIRST_SCAN)
    kept = [word for i, word in enumerate(words) if not set(words[max(0, i - 1):i + 1]) & set(piece.words[::2])]
    bag = world.simulated(name, (*kept, *piece.words, *span))
    truth = Trajectory.read(bag.with_suffix('.tum'))
    within = truth.times() < piece.end - piece.begin - 0.05
    return bag, Trajectory(truth.stamps[within], truth.positions[within], truth.quaternions[within])


def copy(source, out, piece, first, shift, is_first):
    last = first + nanoseconds(piece.end - piece.begin)
    tolerance = 10**6  # ns: the stamps of a TUM file are rounded
    with rosbag.Bag(str(source)) as bag:
        for topic, message, stamp in bag.read_messages(raw=True):
            if topic == '/tf_static':
                if is_first:
                    out.write(topic, message, stamp, raw=True)
                continue
            header = header_stamp(message[1])
            if header >= last - tolerance or (header < first - tolerance and not is_first):
                continue
            if topic == CLOUDS and not piece.has_clouds:
                continue
            moved = (message[0], with_stamp(message[1], header + shift)) + tuple(message[2:])
            out.write(topic, moved, Time(*divmod(stamp.to_nsec() + shift, 10**9)), raw=True)


def when(truth, way):
    """s of the drive at which so many metres are driven."""
    return round(FIRST_SCAN + float(np.interp(way, truth.ways(), truth.times())), 1)


def way_at(truth, time):
    return float(np.interp(time - FIRST_SCAN, truth.times(), truth.ways()))


def any_time(truth, before, after, rng):
    """A time of the drive that has so many seconds before and after it, also of the mapping drive's end."""
    last = float(truth.times()[-1]) - MARGIN - after
    return round(rng.uniform(MARGIN + before, max(MARGIN + before, last)), 1)


def kidnapped(metres):
    """Carried `metres` along the way, forwards or, where the drive is too short for it, backwards."""
    def case(truth, rng):
        ways = []
        last = float(truth.times()[-1]) - MARGIN
        for tenth in range(round(10 * (MARGIN + LEAD)), round(10 * last), 5):
            for sign in (1, -1):
                target = way_at(truth, tenth / 10) + sign * metres
                if not 0 < target < truth.ways()[-1]:
                    continue
                to = when(truth, target)
                if MARGIN < to < last - TAIL:
                    ways.append((tenth / 10, to))
        if not ways:
            return None
        at, to = rng.choice(ways)
        return Interruption((Piece(at - LEAD, at), Piece(to, to + TAIL)), LEAD, LEAD)
    return case


def blacked_out(truth, rng):
    """No scans, while the other sensors go on."""
    at = any_time(truth, LEAD, BLIND + TAIL, rng)
    return Interruption((Piece(at - LEAD, at), Piece(at, at + BLIND, has_clouds=False),
                         Piece(at + BLIND, at + BLIND + TAIL)), LEAD + BLIND, LEAD + BLIND)


def covered(*fault):
    """Scans go on, but the sensor sees next to nothing."""
    def case(truth, rng):
        at = any_time(truth, LEAD, BLIND + TAIL, rng)
        return Interruption((Piece(at - LEAD, at), Piece(at, at + BLIND, ('--fault', *fault)),
                             Piece(at + BLIND, at + BLIND + TAIL)), LEAD, LEAD + BLIND)
    return case


def parked(truth, rng):
    """Stands for minutes, while the cars around it change all the time."""
    speeds = np.diff(truth.ways()) / np.diff(truth.times())
    still = [float(t) for t, v in zip(truth.times(), speeds) if v < 0.01 and LEAD < t < truth.times()[-1] - TAIL]
    if not still:
        return None
    begin = round(still[0] + FIRST_SCAN + 0.3, 1)
    days = [Piece(begin, begin + STANDING, ('--parked', str(10 + day))) for day in range(DAYS)]
    pieces = (Piece(begin - LEAD, begin), *(days * ROUNDS), Piece(begin + STANDING, begin + STANDING + TAIL))
    return Interruption(pieces, LEAD, LEAD + STANDING * DAYS * ROUNDS, is_sudden=False)


OUT_OF_MAP = 'out_of_map'
CASES = {'kidnapped_100_m': kidnapped(100.0), 'kidnapped_1_km': kidnapped(1000.0), 'blacked_out': blacked_out,
         'covered': covered('sparse=30'), 'sprayed': covered('rain=0.9'),
         OUT_OF_MAP: None, 'parked': parked}


def out_of_the_map(truth, places, rng):
    """A way that leads for OUTSIDE metres through places of the map (positions, m) that are taken out of it, and the
    numbers of these; nothing if there is no such way, because the places before and behind it are passed again there."""
    for _ in range(100):
        begin = rng.uniform(way_at(truth, MARGIN + LEAD), float(truth.ways()[-1]) - OUTSIDE - MARGIN)
        entry, back = when(truth, begin), when(truth, begin + OUTSIDE)
        if back + TAIL > truth.times()[-1]:
            continue
        stretch = truth.positions[(truth.ways() > begin) & (truth.ways() < begin + OUTSIDE)]
        is_out = distances(places, stretch) < REACH
        left = places[~is_out]
        near = [distances(position_at(truth, time)[None], left)[0] < 2 * REACH
                for time in (entry - LEAD, entry - 0.3 * LEAD, back + 0.2 * TAIL, back + 0.5 * TAIL)]
        if all(near):
            return Interruption((Piece(entry - LEAD, back + TAIL),), LEAD, LEAD + back - entry, False), is_out
    return None, None


def position_at(truth, time):
    return np.array([np.interp(time - FIRST_SCAN, truth.times(), truth.positions[:, i]) for i in range(3)])


def distances(points, others):
    """m from each of the points to the nearest of the others."""
    return np.array([np.min(np.linalg.norm(others - point, axis=1), initial=np.inf) for point in points])


def without(session, target, key_frames):
    """A copy of a session in which these key frames have no poses, so that it is a map without them."""
    if target.exists():
        shutil.rmtree(target)
    shutil.copytree(session, target)
    with contextlib.closing(sqlite3.connect(target / 'session.db')) as database:
        database.executemany('DELETE FROM poses WHERE key_frame = ?', [(int(k),) for k in key_frames])
        database.commit()


class Outcome(NamedTuple):
    """What localisation made of an interrupted drive."""
    known_before: bool  # it was followed when the interruption began
    said: float  # s until it was followed no longer; inf if it never was said
    is_lost: bool  # the place was given up
    wrong: int  # scans that were followed at a wrong pose
    wrong_beside: float  # s during which the pose by odometry was wrong
    found: float  # s from the end of the interruption until it is followed rightly again
    error: float  # greatest of the right poses that were followed, m


def judge(rows, truth, align, interruption):
    """Outcome of the rows of localization.csv."""
    begins, ends = truth.stamps[0] + interruption.begins, truth.stamps[0] + interruption.ends
    scans = [(float(row['stamp']), row['state'], error_of(row, truth, *align)) for row in rows]
    before = [state for stamp, state, _ in scans if stamp < begins - 0.05]
    after = [(stamp, state, error) for stamp, state, error in scans if stamp >= begins - 0.05]
    followed = [(stamp, error) for stamp, state, error in scans if state == 'following' and error]
    said = [stamp - begins for stamp, state, _ in after if state != 'following']
    if after and after[0][0] > begins + 1.5 / SCAN_RATE:  # scans that tell nothing are left out: no claim
        said = [0.0]
    right = [stamp - ends for stamp, error in followed if stamp >= ends - 0.05 and not error.is_wrong()]
    beside = [error for _, state, error in after if state == 'beside_map' and error and error.is_wrong()]
    return Outcome(before[-1:] == ['following'], said[0] if said else math.inf,
                   any(state == 'lost' for _, state, _ in after), sum(error.is_wrong() for _, error in followed),
                   len(beside) / SCAN_RATE, right[0] if right else math.inf,
                   max((error.metres for _, error in followed if not error.is_wrong()), default=math.nan))


HEAD = ['case', 'map', 'sensor', 'runs', 'known before', 'said within 2 s', 'latest, s', 'given up',
        'scans followed at a wrong pose', 'wrong by odometry, s', 'found again', 'after at most, s',
        'greatest error, cm']


def cells(case, world, lidar, outcomes, is_sudden):
    """A row of the table; what was not known before does not count."""
    known = [o for o in outcomes if o.known_before]
    found = [o.found for o in known if math.isfinite(o.found)]
    errors = [o.error for o in known if not math.isnan(o.error)]
    return [case, world, lidar, f'{len(outcomes)}', f'{len(known)}',
            f'{sum(o.said <= SOON for o in known)}' if is_sudden else '-',
            f'{max(o.said for o in known):.1f}' if is_sudden and known else '-', f'{sum(o.is_lost for o in known)}',
            f'{sum(o.wrong for o in outcomes)}', f'{max((o.wrong_beside for o in known), default=0.0):.1f}',
            f'{len(found)}', f'{max(found):.1f}' if found else '-', f'{100 * max(errors):.0f}' if errors else '-']


def random_of(seed, case, world):
    return random.Random(f'{seed} {case} {world}')
