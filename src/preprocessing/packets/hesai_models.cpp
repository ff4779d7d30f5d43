// SPDX-License-Identifier: BSD-3-Clause
#include "packets/hesai_models.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/number_bytes.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/units.hpp"

#include "packets/packet_decoding.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr unsigned kPacketFlag = 0xFFEE;    // little-endian, by the user's manual
constexpr unsigned kBlockFlag = 0xEEFF;     // the same of a Pandar40P's block, by its manual
constexpr std::size_t kSequenceNumber = 4;  // bytes that may follow, by the user's manual
constexpr std::size_t kUnit = 3;            // behind the number of lasers, by the user's manual
constexpr double kPandar40pUnit = 4.0;      // mm of a count, by the user's manual
constexpr double kMetre = 1000.0;           // mm, by definition

/// A fan of beams at equal steps (degrees) downwards, that fire one after the other. By the user's
/// manuals of PandarXT-32 and PandarXT-16 and by Hesai's driver, the first laser fires 0.368 us
/// after the beginning of its block.
std::vector<HesaiLaser> fan(int count, double top_deg, double step_deg, double firing_us) {
  std::vector<HesaiLaser> lasers;
  for (int i = 0; i < count; ++i) {
    lasers.push_back({top_deg - step_deg * i, 0.0, 0.368 + firing_us * i});
  }
  return lasers;
}

/// Angles by Hesai's driver, for sensors without a calibration; firing times by the table of the
/// user's manual of the Pandar40P, before the end of a block.
const std::vector<HesaiLaser> kPandar40pLasers = {
    {15.0, -1.042, -42.22},  {11.0, -1.042, -28.47},  {8.0, -1.042, -16.04},
    {5.0, -1.042, -3.62},    {3.0, -1.042, -45.49},   {2.0, -1.042, -31.74},
    {1.67, 3.125, -47.46},   {1.33, -5.208, -54.67},  {1.0, -1.042, -20.62},
    {0.67, 3.125, -33.71},   {0.33, -5.208, -40.91},  {0.0, -1.042, -8.19},
    {-0.33, 3.125, -20.62},  {-0.67, -5.208, -27.16}, {-1.0, -1.042, -50.73},
    {-1.33, 3.125, -8.19},   {-1.66, -5.208, -14.74}, {-2.0, -1.042, -36.98},
    {-2.33, 3.125, -45.49},  {-2.67, -5.208, -52.7},  {-3.0, -1.042, -23.89},
    {-3.33, 3.125, -31.74},  {-3.67, -5.208, -38.95}, {-4.0, -1.042, -11.47},
    {-4.33, 3.125, -18.65},  {-4.67, -5.208, -25.19}, {-5.0, -1.042, -48.76},
    {-5.33, 3.125, -6.23},   {-5.67, -5.208, -12.77}, {-6.0, -1.042, -35.01},
    {-7.0, -1.042, -21.92},  {-8.0, -1.042, -9.5},    {-9.0, -1.042, -43.52},
    {-10.0, -1.042, -29.77}, {-11.0, -1.042, -17.35}, {-12.0, -1.042, -4.92},
    {-13.0, -1.042, -42.22}, {-14.0, -1.042, -28.47}, {-19.0, -1.042, -16.04},
    {-25.0, -1.042, -3.62}};

/// Angles by Hesai's driver, for sensors without a calibration; firing times by the formulas of the
/// user's manual of the Pandar64, before the end of a block.
const std::vector<HesaiLaser> kPandar64Lasers = {
    {14.882, -1.042, -23.18},  {11.032, -1.042, -21.876}, {8.059, -1.042, -20.572},
    {5.057, -1.042, -19.268},  {3.04, -1.042, -17.964},   {2.028, -1.042, -16.66},
    {1.86, 1.042, -11.444},    {1.688, 3.125, -46.796},   {1.522, 5.208, -7.532},
    {1.351, -5.208, -36.956},  {1.184, -3.125, -50.732},  {1.013, -1.042, -54.668},
    {0.846, 1.042, -40.892},   {0.675, 3.125, -44.828},   {0.508, 5.208, -31.052},
    {0.337, -5.208, -34.988},  {0.169, -3.125, -48.764},  {0.0, -1.042, -52.7},
    {-0.169, 1.042, -38.924},  {-0.337, 3.125, -42.86},   {-0.508, 5.208, -29.084},
    {-0.675, -5.208, -33.02},  {-0.845, -3.125, -46.796}, {-1.013, -1.042, -25.148},
    {-1.184, 1.042, -36.956},  {-1.351, 3.125, -50.732},  {-1.522, 5.208, -27.116},
    {-1.688, -5.208, -40.892}, {-1.86, -3.125, -44.828},  {-2.028, -1.042, -31.052},
    {-2.198, 1.042, -34.988},  {-2.365, 3.125, -48.764},  {-2.536, 5.208, -25.148},
    {-2.7, -5.208, -38.924},   {-2.873, -3.125, -42.86},  {-3.04, -1.042, -29.084},
    {-3.21, 1.042, -33.02},    {-3.375, 3.125, -52.7},    {-3.548, 5.208, -6.228},
    {-3.712, -5.208, -54.668}, {-3.884, -3.125, -15.356}, {-4.05, -1.042, -27.116},
    {-4.221, 1.042, -10.14},   {-4.385, 3.125, -23.18},   {-4.558, 5.208, -4.924},
    {-4.72, -5.208, -21.876},  {-4.892, -3.125, -14.052}, {-5.057, -1.042, -17.964},
    {-5.229, 1.042, -8.836},   {-5.391, 3.125, -19.268},  {-5.565, 5.208, -3.62},
    {-5.726, -5.208, -20.572}, {-5.898, -3.125, -12.748}, {-6.061, -1.042, -16.66},
    {-7.063, -1.042, -7.532},  {-8.059, -1.042, -11.444}, {-9.06, -1.042, -6.228},
    {-9.885, -1.042, -15.356}, {-11.032, -1.042, -10.14}, {-12.006, -1.042, -4.924},
    {-12.974, -1.042, -3.62},  {-13.93, -1.042, -14.052}, {-18.889, -1.042, -8.836},
    {-24.897, -1.042, -12.748}};

/// Angles and firing times, after the beginning of a block, by Hesai's driver.
const std::vector<HesaiLaser> kPandarQtLasers = {
    {-52.121, 8.736, 12.31},  {-49.785, 8.314, 14.37},  {-47.577, 7.964, 16.43},
    {-45.477, 7.669, 18.49},  {-43.465, 7.417, 20.54},  {-41.528, 7.198, 22.6},
    {-39.653, 7.007, 24.66},  {-37.831, 6.838, 26.71},  {-36.055, 6.688, 29.16},
    {-34.32, 6.554, 31.22},   {-32.619, 6.434, 33.28},  {-30.95, 6.326, 35.34},
    {-29.308, 6.228, 37.39},  {-27.69, 6.14, 39.45},    {-26.094, 6.059, 41.5},
    {-24.517, 5.987, 43.56},  {-22.964, -5.27, 46.61},  {-21.42, -5.216, 48.67},
    {-19.889, -5.167, 50.73}, {-18.372, -5.123, 52.78}, {-16.865, -5.083, 54.84},
    {-15.368, -5.047, 56.9},  {-13.88, -5.016, 58.95},  {-12.399, -4.988, 61.01},
    {-10.925, -4.963, 63.45}, {-9.457, -4.942, 65.52},  {-7.994, -4.924, 67.58},
    {-6.535, -4.91, 69.63},   {-5.079, -4.898, 71.69},  {-3.626, -4.889, 73.74},
    {-2.175, -4.884, 75.8},   {-0.725, -4.881, 77.86},  {0.725, 5.493, 80.9},
    {2.175, 5.496, 82.97},    {3.626, 5.502, 85.02},    {5.079, 5.512, 87.08},
    {6.534, 5.525, 89.14},    {7.993, 5.541, 91.19},    {9.456, 5.561, 93.25},
    {10.923, 5.584, 95.3},    {12.397, 5.611, 97.75},   {13.877, 5.642, 99.82},
    {15.365, 5.676, 101.87},  {16.861, 5.716, 103.93},  {18.368, 5.759, 105.98},
    {19.885, 5.808, 108.04},  {21.415, 5.862, 110.1},   {22.959, 5.921, 112.15},
    {24.524, -5.33, 115.2},   {26.101, -5.396, 117.26}, {27.697, -5.469, 119.32},
    {29.315, -5.55, 121.38},  {30.957, -5.64, 123.43},  {32.627, -5.74, 125.49},
    {34.328, -5.85, 127.54},  {36.064, -5.974, 129.6},  {37.84, -6.113, 132.05},
    {39.662, -6.269, 134.11}, {41.537, -6.447, 136.17}, {43.475, -6.651, 138.22},
    {45.487, -6.887, 140.28}, {47.587, -7.163, 142.34}, {49.795, -7.493, 144.39},
    {52.133, -7.892, 146.45}};

/// Layouts and times of blocks by the user's manuals and by Hesai's driver. The time of a Pandar40P
/// or Pandar64 is that of its blocks' ends, of the others that of their beginnings. The columns:
/// name, bytes, header, lasers_at, blocks, block, azimuth, channel, time, block_us, offset_us,
/// counts_from_first, lasers.
const std::vector<HesaiModel> kModels = {
    {"Pandar40P", 1262, 0, 0, 10, 124, 2, 3, 1250, 55.56, -28.58, false, kPandar40pLasers},
    {"Pandar64", 1194, 8, 2, 6, 194, 0, 3, 1182, 55.56, -42.58, false, kPandar64Lasers},
    {"PandarQT", 1068, 12, 6, 4, 258, 0, 4, 1056, 500.0 / 3.0, 25.71, true, kPandarQtLasers},
    {"PandarXT-16", 564, 12, 6, 8, 66, 0, 4, 559, 50.0, 5.632, false, fan(16, 15.0, 2.0, 3.024)},
    {"PandarXT-32", 1076, 12, 6, 8, 130, 0, 4, 1071, 50.0, 5.632, false,
     fan(32, 15.0, 1.0, 1.512)}};

std::string names() {
  std::vector<std::string> all;
  for (const HesaiModel& model : kModels) all.push_back(model.name);
  return joined(all);
}

/// What the header of a packet says of its model, which is not known by its size.
std::string header_of(const HesaiPacket& packet) {
  constexpr std::size_t kHeader = 12;  // bytes of the longer kind, by the user's manual
  const bool has_header =
      packet.size > kHeader && number_at<std::uint16_t>(packet.data) == kPacketFlag;
  if (!has_header) return "";
  return formatted(" (protocol %d.%d, %d lasers)", packet.data[2], packet.data[3], packet.data[6]);
}

}  // namespace

unsigned HesaiModel::azimuth_of(const unsigned char* at) const {
  return number_at<std::uint16_t>(at + azimuth);
}

double HesaiModel::distance_resolution(const HesaiPacket& packet) const {
  return (header == 0 ? kPandar40pUnit : packet.data[lasers_at + kUnit]) / kMetre;
}

std::int64_t HesaiModel::microseconds_of(const HesaiPacket& packet) const {
  return number_at<std::uint32_t>(packet.data + time) % kHesaiSecond;
}

bool HesaiModel::is_whole(const HesaiPacket& packet) const {
  if (packet.size != bytes && packet.size != bytes + kSequenceNumber) return false;
  if (header > 0) {
    const unsigned char* const counts = packet.data + lasers_at;
    const bool fits = number_at<std::uint16_t>(packet.data) == kPacketFlag &&
                      counts[0] == lasers.size() && counts[1] == blocks && counts[kUnit] > 0;
    if (!fits) return false;
  }
  for (std::size_t b = 0; b < blocks; ++b) {
    const unsigned char* const at = block_of(packet, b);
    const bool has_flag = header > 0 || number_at<std::uint16_t>(at) == kBlockFlag;
    if (!has_flag || azimuth_of(at) >= kTurn) return false;
  }
  return true;
}

const HesaiModel* hesai_model_of_size(std::size_t size) {
  for (const HesaiModel& model : kModels) {
    if (size == model.bytes || size == model.bytes + kSequenceNumber) return &model;
  }
  return nullptr;
}

const HesaiModel& hesai_model(const std::vector<HesaiPacket>& packets) {
  std::map<std::size_t, std::size_t> counts;  // by the size of packets
  for (const HesaiPacket& packet : packets) ++counts[packet.size];
  const auto most =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  if (const HesaiModel* model = hesai_model_of_size(most->first)) return *model;
  const auto example = std::find_if(packets.begin(), packets.end(), [&](const HesaiPacket& packet) {
    return packet.size == most->first;
  });
  throw InputError("packets of " + std::to_string(most->first) + " bytes" + header_of(*example) +
                   " are not read, only those of " + names() +
                   "; convert them with the cloud node of the sensor's driver");
}

HesaiCalibration nominal_calibration(const HesaiModel& model) {
  HesaiCalibration calibration;
  for (const HesaiLaser& laser : model.lasers) {
    calibration.lasers.push_back(
        {laser.elevation_deg * kRadPerDeg, laser.azimuth_deg * kRadPerDeg});
  }
  return calibration;
}

}  // namespace lidar_mapping::preprocessing
