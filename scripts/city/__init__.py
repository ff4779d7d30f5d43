# SPDX-License-Identifier: BSD-3-Clause
"""Parts of map_city: many drives to one map, as jobs from files to files (doc/city.md)."""
