# SPDX-License-Identifier: BSD-3-Clause
"""Parts of spoilt_recordings.py: faults of recordings, and what the programs make of them."""
