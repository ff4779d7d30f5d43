// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scan/scan_sampler.hpp"

namespace lidar_mapping::front_end {

/// Marks whole planes of which some points are marked: the points that lie on such a plane and are
/// connected with marked ones without a gap, if a tenth of them is marked already.
void mark_planes(const SampledPoints& points, PointMarks& marks);

}  // namespace lidar_mapping::front_end
