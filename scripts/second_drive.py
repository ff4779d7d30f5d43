# SPDX-License-Identifier: BSD-3-Clause
"""A drive of another day that finds itself in the map of the demo (for run_demo.py)."""
import csv
import json
import math
import shutil

from localization_truth import Trajectory, alignment, error_of

# Drives of simulate_drive that can be driven back, past other parked cars; carriers and tunnels cannot.
WITH_WAY_BACK = {'town', 'figure_eight', 'car_park', 'twins', 'city'}
START, END = 40, 80  # s of the way back


def words_for(options):
    """Options of simulate_drive: another day, a part of the way back if all of the way was mapped."""
    words = ['--drive', options.drive, '--lidar', options.lidar, '--seed', options.seed, '--pass', 1]
    if options.duration:
        return words + ['--duration', options.duration]
    if options.drive in WITH_WAY_BACK:
        return words + ['--parked', 1, '--reverse', '--start', START, '--duration', END]
    return words


def error_rms(scans, truth, align):
    """m, of the scans with a pose; none without such a scan."""
    errors = [error_of(scan, truth, *align) for scan in scans]
    squares = [error.metres ** 2 for error in errors if error]
    return math.sqrt(sum(squares) / len(squares)) if squares else None


def localize(options, session, mapping_truth, folder, rosrun):
    """Make the drive, localise it in the session's map without an initial pose, and return its figures."""
    bag, truth, found = folder / 'another_day.bag', folder / 'another_day.tum', folder / 'another_day'
    rosrun('simulate_drive', bag, '--force', '--truth', truth, *words_for(options))
    shutil.rmtree(found, ignore_errors=True)
    file = folder / 'another_day.json'
    # Status 5: it was never found, which the last line says.
    rosrun('localize_bag', bag, session, '-o', found, '--figures', file, statuses=(0, 5))
    figures = json.loads(file.read_text())
    with open(found / 'localization.csv') as table:
        scans = list(csv.DictReader(table))
    align = alignment(Trajectory.read(mapping_truth), Trajectory.read(session / 'trajectory' / 'optimized.tum'))
    after = figures['found_after']
    return {'localization_scans': figures['scans'],
            'localization_scans_followed': figures['states']['following'],
            'localization_found_after_seconds': after and after['seconds'],
            'localization_rmse': error_rms(scans, Trajectory.read(truth), align)}
