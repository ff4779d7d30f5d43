# SPDX-License-Identifier: BSD-3-Clause
"""All kinds of faults: their import fills variants.VARIANTS, in the order of the examination."""
# The clean recordings come first, because the others are compared with them.
from recording_faults import (clean, headers, layouts, clouds, times, transforms, imu,  # noqa: F401
                              velocity, gnss, files)
