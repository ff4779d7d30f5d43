// SPDX-License-Identifier: BSD-3-Clause
#include "packets/velodyne_models.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/number_bytes.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// Firing times by the user's manual: VLP-16, chapter 9.4; VLP-32C, 9.4; HDL-32E, appendix A. The
// columns: name, lasers, sequences, sequence (s), firing (s), together, distance_resolution (m).
const VelodyneModel kVlp16 = {"VLP-16", 16, 2, 55.296e-6, 2.304e-6, 1, 0.002};
const VelodyneModel kHiRes = {"Puck Hi-Res", 16, 2, 55.296e-6, 2.304e-6, 1, 0.002};
const VelodyneModel kVlp32c = {"VLP-32C", 32, 1, 55.296e-6, 2.304e-6, 2, 0.004};
const VelodyneModel kHdl32 = {"HDL-32E", 32, 1, 46.08e-6, 1.152e-6, 1, 0.002};
const VelodyneModel kHdl64 = {"HDL-64E", 64, 1, 0.0, 0.0, 64, 0.002};

/// Product numbers, by the user's manual.
const std::map<unsigned, const VelodyneModel*> kProducts = {
    {0x21, &kHdl32}, {0x22, &kVlp16}, {0x24, &kHiRes}, {0x28, &kVlp32c}};
constexpr std::size_t kProduct = 1205;    // byte of it in a packet, by the user's manual
constexpr unsigned kThirdBlock = 0xCCFF;  // flag that only a VLS-128 has, by its manual

/// Elevation and azimuth offset of each laser of a VLP-32C, degrees, by its manual.
constexpr std::array<std::array<double, 2>, 32> kVlp32cLasers = {
    {{-25.0, 1.4},  {-1.0, -4.2},   {-1.667, 1.4}, {-15.639, -1.4}, {-11.31, 1.4}, {0.0, -1.4},
     {-0.667, 4.2}, {-8.843, -1.4}, {-7.254, 1.4}, {0.333, -4.2},   {-0.333, 1.4}, {-6.148, -1.4},
     {-5.333, 4.2}, {1.333, -1.4},  {0.667, 4.2},  {-4.0, -1.4},    {-4.667, 1.4}, {1.667, -4.2},
     {1.0, 1.4},    {-3.667, -4.2}, {-3.333, 4.2}, {3.333, -1.4},   {2.333, 1.4},  {-2.667, -1.4},
     {-3.0, 1.4},   {7.0, -1.4},    {4.667, 1.4},  {-2.333, -4.2},  {-2.0, 4.2},   {15.0, -1.4},
     {10.333, 1.4}, {-1.333, -1.4}}};

/// The elevations of a fan of beams at equal steps (degrees) whose lower and upper half take turns.
double fan_elevation(std::size_t laser, std::size_t lasers, double lowest, double step) {
  const std::size_t rank = laser / 2 + (laser % 2) * (lasers / 2);
  return lowest + step * static_cast<double>(rank);
}

LaserCorrection nominal_laser(const VelodyneModel& model, std::size_t laser) {
  double elevation = 0.0, azimuth = 0.0;
  if (&model == &kVlp32c) {
    elevation = kVlp32cLasers[laser][0];
    azimuth = kVlp32cLasers[laser][1];
  } else if (&model == &kHdl32) {
    elevation = fan_elevation(laser, 32, -92.0 / 3.0, 4.0 / 3.0);  // the manual rounds
  } else {
    const double step = &model == &kHiRes ? 4.0 / 3.0 : 2.0;
    elevation = fan_elevation(laser, 16, -7.5 * step, step);
  }
  LaserCorrection correction;
  correction.vert_correction = elevation * kRadPerDeg;
  correction.rot_correction = -azimuth * kRadPerDeg;
  return correction;
}

bool has_flag(const VelodynePacket& packet, unsigned flag) {
  for (std::size_t block = 0; block < kBlocksOfPacket; ++block) {
    if (number_at<std::uint16_t>(packet.data + block * kBlockBytes) == flag) return true;
  }
  return false;
}

/// Whether most packets have a block with this flag, as one may be damaged.
bool most_have_flag(const std::vector<VelodynePacket>& packets, unsigned flag) {
  const auto count =
      std::count_if(packets.begin(), packets.end(),
                    [&](const VelodynePacket& packet) { return has_flag(packet, flag); });
  return 2 * static_cast<std::size_t>(count) > packets.size();
}

/// The product number of most packets, as one may be damaged.
unsigned product_of(const std::vector<VelodynePacket>& packets) {
  std::array<std::size_t, 256> counts{};
  for (const VelodynePacket& packet : packets) ++counts[packet.data[kProduct]];
  return static_cast<unsigned>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

const VelodyneModel* model_of(const VelodyneCalibration& calibration) {
  if (calibration.lasers.size() == 16) return &kVlp16;
  if (calibration.lasers.size() == 64) return &kHdl64;
  return calibration.distance_resolution > kHdl32.distance_resolution ? &kVlp32c : &kHdl32;
}

}  // namespace

const VelodyneModel& velodyne_model(const std::vector<VelodynePacket>& packets,
                                    const std::optional<VelodyneCalibration>& calibration) {
  const unsigned product = product_of(packets);
  if (most_have_flag(packets, kThirdBlock)) {
    throw InputError(
        "packets of a Velodyne VLS-128 are not read; convert them with "
        "velodyne_pointcloud's transform node");
  }
  if (most_have_flag(packets, kLowerBlock)) return kHdl64;
  if (std::none_of(packets.begin(), packets.end(),
                   [](const VelodynePacket& packet) { return has_flag(packet, kUpperBlock); })) {
    throw InputError("none of " + std::to_string(packets.size()) +
                     " packets holds blocks of a Velodyne; is it another sensor's topic?");
  }
  const auto known = kProducts.find(product);
  if (known != kProducts.end()) return *known->second;
  if (calibration) return *model_of(*calibration);
  throw InputError(
      formatted("packets of the unknown Velodyne product 0x%02X; name its calibration file in "
                "velodyne_calibration",
                product));
}

VelodyneCalibration nominal_calibration(const VelodyneModel& model) {
  if (&model == &kHdl64) {
    throw InputError(
        "each HDL-64E has a calibration of its own, without which its packets cannot "
        "be decoded: name the file in velodyne_calibration");
  }
  VelodyneCalibration calibration;
  calibration.distance_resolution = model.distance_resolution;
  for (std::size_t laser = 0; laser < model.lasers; ++laser) {
    calibration.lasers.push_back(nominal_laser(model, laser));
  }
  return calibration;
}

}  // namespace lidar_mapping::preprocessing
