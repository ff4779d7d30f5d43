# SPDX-License-Identifier: BSD-3-Clause
"""Faults of GNSS: status, covariances, units, jumps, positions that do not change, stamps."""
import math

from recording_faults.records import GNSS, messages_of, with_shifted_stamps
from recording_faults.variants import variant

ABOUT_1_KM = 0.009  # degrees of latitude


def position_of(fix):
    return fix.latitude, fix.longitude, fix.altitude


def place(fixes, position):
    for fix in fixes:
        fix.latitude, fix.longitude, fix.altitude = position


def with_angles(records, change):
    """The fixes with change(angle) of latitudes and longitudes (degrees)."""
    for fix in messages_of(records, GNSS):
        fix.latitude, fix.longitude = change(fix.latitude), change(fix.longitude)
    return records


def with_covariances(records, covariances):
    for fix in messages_of(records, GNSS):
        fix.position_covariance = list(covariances)
    return records


@variant("all")
def gnss_status_without_fix(records):
    for fix in messages_of(records, GNSS):
        fix.status.status = -1
    return records


@variant("all")
def gnss_covariances_zero(records):
    return with_covariances(records, [0.0] * 9)


@variant("all")
def gnss_covariances_as_deviations_of_a_km(records):
    return with_covariances(records, [1e6, 0, 0, 0, 1e6, 0, 0, 0, 1e6])


@variant("all")
def gnss_latitude_and_longitude_swapped(records):
    for fix in messages_of(records, GNSS):
        fix.latitude, fix.longitude = fix.longitude, fix.latitude
    return records


@variant("all")
def gnss_jumps_by_1_km(records):
    for index, fix in enumerate(messages_of(records, GNSS)):
        if index % 20 > 15:
            fix.latitude += ABOUT_1_KM
    return records


@variant("all")
def gnss_1_km_aside_from_mid_drive_on(records):
    for fix in messages_of(records, GNSS)[91:]:
        fix.latitude += ABOUT_1_KM
    return records


@variant("all")
def gnss_at_0_0(records):
    place(messages_of(records, GNSS), (0.0, 0.0, 0.0))
    return records


@variant("all")
def gnss_at_0_0_at_the_start(records):
    place(messages_of(records, GNSS)[:50], (0.0, 0.0, 0.0))
    return records


@variant("all")
def gnss_frozen(records):
    fixes = messages_of(records, GNSS)
    place(fixes, position_of(fixes[0]))
    return records


@variant("all")
def gnss_freezes_in_mid_drive(records):
    fixes = messages_of(records, GNSS)
    place(fixes[91:], position_of(fixes[90]))
    return records


@variant("all")
def gnss_in_radians(records):
    return with_angles(records, math.radians)


@variant("all")
def gnss_in_degrees_and_minutes(records):
    """4902.1 instead of 49.035, as NMEA writes it."""
    return with_angles(records, lambda angle: math.floor(angle) * 100.0 +
                       (angle - math.floor(angle)) * 60.0)


@variant("all")
def gnss_with_4_decimals(records):
    return with_angles(records, lambda angle: round(angle, 4))


@variant("all")
def gnss_without_altitude(records):
    for fix in messages_of(records, GNSS):
        fix.altitude = math.nan
    return records


@variant("all")
def gnss_late_by_2_s(records):
    return with_shifted_stamps(records, 2.0, GNSS)
