# SPDX-License-Identifier: BSD-3-Clause
"""Recordings without a fault, with which the others of the same sensors are compared."""
from recording_faults.variants import variant


@variant("clouds")
def clouds_clean(records):
    return records


@variant("all")
def all_clean(records):
    return records


@variant("imu")
def imu_clean(records):
    return records


@variant("velocity")
def velocity_clean(records):
    return records


@variant("gnss")
def gnss_clean(records):
    return records
