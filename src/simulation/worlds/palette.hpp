// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/mesh.hpp"

namespace lidar_mapping::simulation {

constexpr Reflectivity kAsphalt = 38;
constexpr Reflectivity kPavement = 70;
constexpr Reflectivity kKerbStone = 95;
constexpr Reflectivity kGrass = 110;
constexpr Reflectivity kSoil = 80;
constexpr Reflectivity kConcrete = 90;
constexpr Reflectivity kGlass = 18;
constexpr Reflectivity kRoofTile = 60;
constexpr Reflectivity kTyre = 8;
constexpr Reflectivity kBark = 75;
constexpr Reflectivity kLeaf = 130;
constexpr Reflectivity kSteel = 140;
constexpr Reflectivity kSign = 250;
constexpr Reflectivity kCloth = 85;

}  // namespace lidar_mapping::simulation
