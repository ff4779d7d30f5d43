// SPDX-License-Identifier: BSD-3-Clause
// The types of the NDT, which this stage calls by their short names.
#pragma once

#include "lidar_mapping/registration/gaussian_voxel_map.hpp"
#include "lidar_mapping/registration/ndt_matcher.hpp"

namespace lidar_mapping::front_end {

using registration::GaussianVoxelMap;
using registration::Matrix12d;
using registration::MotionBelief;
using registration::MotionState;
using registration::NdtMatch;
using registration::NdtMatcher;
using registration::NdtOptions;
using registration::NdtPart;
using registration::NdtPoints;
using registration::NeighborSearch;
using registration::Vector12d;

}  // namespace lidar_mapping::front_end
