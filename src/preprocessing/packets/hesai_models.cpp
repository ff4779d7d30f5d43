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

#include "packets/azimuth_groups.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr unsigned kPacketFlag = 0xFFEE;    // little-endian, by the user's manual
constexpr unsigned kBlockFlag = 0xEEFF;     // the same of a Pandar40P's block, by its manual
constexpr std::size_t kSequenceNumber = 4;  // bytes that may follow, by the user's manual
constexpr std::size_t kUnit = 3;            // behind the number of lasers, by the user's manual
constexpr double kPandar40pUnit = 4.0;      // mm of a count, by the user's manual
constexpr double kMetre = 1000.0;           // mm, by definition

/// Layouts and times of blocks by the user's manuals and by Hesai's driver. The time of a Pandar40P
/// or Pandar64 is that of its blocks' ends, of the others that of their beginnings. The columns:
/// name, bytes, header, lasers_at, blocks, block, azimuth, channel, time, block_us, offset_us,
/// counts_from_first, lasers.
const std::vector<HesaiModel>& models() {
  static const std::vector<HesaiModel> all = {
      {"Pandar40P", 1262, 0, 0, 10, 124, 2, 3, 1250, 55.56, -28.58, false, pandar40p_lasers()},
      {"Pandar64", 1194, 8, 2, 6, 194, 0, 3, 1182, 55.56, -42.58, false, pandar64_lasers()},
      {"PandarQT", 1068, 12, 6, 4, 258, 0, 4, 1056, 500.0 / 3.0, 25.71, true, pandar_qt_lasers()},
      {"PandarXT-16", 564, 12, 6, 8, 66, 0, 4, 559, 50.0, 5.632, false, pandar_xt16_lasers()},
      {"PandarXT-32", 1076, 12, 6, 8, 130, 0, 4, 1071, 50.0, 5.632, false, pandar_xt32_lasers()}};
  return all;
}

std::string names() {
  std::vector<std::string> all;
  for (const HesaiModel& model : models()) all.push_back(model.name);
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
  for (const HesaiModel& model : models()) {
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
