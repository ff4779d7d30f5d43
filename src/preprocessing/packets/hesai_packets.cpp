// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/hesai_packets.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/number_bytes.hpp"
#include "lidar_mapping/common/units.hpp"

#include "packets/hesai_models.hpp"
#include "packets/packet_decoding.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr double kRadPerCount = 0.01 * kRadPerDeg;  // of an azimuth, by the user's manual

// The calibration beside the packets, by HesaiLidar_General_ROS 1.1.4 and later: a flag, two bytes
// that are not used, the length of the text (big-endian) and the text of a calibration file.
constexpr unsigned kCalibrationFlag = 0x7447;  // little-endian, by the driver's format
constexpr std::size_t kTextLength = 4;         // byte of the length, by the driver's format
constexpr std::size_t kText = 8;               // byte of the text, by the driver's format

bool is_calibration(const HesaiPacket& packet) {
  return packet.size >= kText && number_at<std::uint16_t>(packet.data) == kCalibrationFlag;
}

/// Throws InputError if the text is cut off or none of a calibration.
HesaiCalibration calibration_in(const HesaiPacket& packet) {
  std::size_t length = 0;
  for (std::size_t i = 0; i < 4; ++i) length = 256 * length + packet.data[kTextLength + i];
  if (length > packet.size - kText) {
    throw InputError("the calibration in a scan of a Hesai has " +
                     std::to_string(packet.size - kText) + " bytes instead of " +
                     std::to_string(length) + "; name its file in hesai_calibration");
  }
  const std::string text(reinterpret_cast<const char*>(packet.data + kText), length);
  try {
    return parse_hesai_calibration(text, "in a scan of a Hesai");
  } catch (const ConfigError& error) {
    throw InputError(error.what());
  }
}

std::vector<double> times_of(const std::vector<HesaiPacket>& packets, const HesaiModel& model,
                             Stamp stamp) {
  std::vector<PacketTime> times;
  for (const HesaiPacket& packet : packets) {
    times.push_back({packet.stamp, model.microseconds_of(packet)});
  }
  return packet_times(times, kHesaiSecond, stamp);
}

/// A laser whose functions of constant angles are known.
struct Laser {
  explicit Laser(const HesaiLaserAngles& angles)
      : azimuth(angles.azimuth), cos(std::cos(angles.elevation)), sin(std::sin(angles.elevation)) {}

  double azimuth;
  double cos, sin;
};

/// Collects the points of a scan.
class PointCollector {
 public:
  PointCollector(const HesaiModel& model, const HesaiCalibration& calibration, PointCloud& cloud)
      : model_(model), cloud_(cloud) {
    for (const HesaiLaserAngles& angles : calibration.lasers) lasers_.emplace_back(angles);
    azimuths_.resize(model.blocks);
  }

  /// `time`: of the packet, s after the scan's stamp.
  void add(const HesaiPacket& packet, double time) {
    for (std::size_t b = 0; b < model_.blocks; ++b) {
      azimuths_[b] = model_.azimuth_of(model_.block_of(packet, b));
    }
    const std::vector<AzimuthGroup> groups = azimuth_groups(azimuths_.data(), azimuths_.size());
    const std::size_t known = model_.counts_from_first ? 0 : groups.size() - 1;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const double from_known = static_cast<double>(g) - static_cast<double>(known);
      const double begin = time + 1e-6 * (model_.offset_us + model_.block_us * from_known);
      for (std::size_t b = groups[g].begin; b < groups[g].end; ++b) {
        add_block(packet, groups[g], b, begin);
      }
    }
  }

 private:
  /// `begin`: to which the firing times of the block refer, s after the scan's stamp.
  void add_block(const HesaiPacket& packet, const AzimuthGroup& group, std::size_t block,
                 double begin) {
    const double resolution = model_.distance_resolution(packet);
    const unsigned char* const at = model_.block_of(packet, block);
    for (std::size_t laser = 0; laser < lasers_.size(); ++laser) {
      const unsigned char* const measured = model_.channel_of(at, laser);
      const unsigned counts = number_at<std::uint16_t>(measured);
      if (counts == 0 || is_repeated(packet, group, block, laser, counts)) continue;
      const double firing = model_.lasers[laser].firing_us;
      const double turned = group.azimuth + group.step * firing / model_.block_us;
      const double azimuth = turned * kRadPerCount + lasers_[laser].azimuth;
      const double range = counts * resolution, across = range * lasers_[laser].cos;
      cloud_.points.push_back({static_cast<float>(across * std::sin(azimuth)),
                               static_cast<float>(across * std::cos(azimuth)),
                               static_cast<float>(range * lasers_[laser].sin),
                               static_cast<float>(measured[2])});
      cloud_.times.push_back(static_cast<float>(begin + 1e-6 * firing));
    }
  }

  /// Whether an earlier block of the same azimuth has the same return: the strongest one is often
  /// the last one, too.
  bool is_repeated(const HesaiPacket& packet, const AzimuthGroup& group, std::size_t block,
                   std::size_t laser, unsigned counts) const {
    for (std::size_t other = group.begin; other < block; ++other) {
      const unsigned char* const measured =
          model_.channel_of(model_.block_of(packet, other), laser);
      if (number_at<std::uint16_t>(measured) == counts) return true;
    }
    return false;
  }

  const HesaiModel& model_;
  PointCloud& cloud_;
  std::vector<Laser> lasers_;
  std::vector<unsigned> azimuths_;  ///< of the packet's blocks, counts
};

/// The calibration that is given, else that beside the packets, else the nominal one.
HesaiCalibration fitting(const std::optional<HesaiCalibration>& given,
                         const std::vector<HesaiPacket>& packets, const HesaiModel& model) {
  const auto beside = std::find_if(packets.begin(), packets.end(), is_calibration);
  if (!given && beside == packets.end()) return nominal_calibration(model);
  HesaiCalibration calibration = given ? *given : calibration_in(*beside);
  check_lasers(given ? "hesai_calibration" : "the calibration in the scan",
               calibration.lasers.size(), model.name, model.lasers.size());
  return calibration;
}

}  // namespace

std::string hesai_model_name(const HesaiPacket& packet) {
  const HesaiModel* const model = hesai_model_of_size(packet.size);
  return model == nullptr ? "" : model->name;
}

HesaiDecoder::HesaiDecoder(std::optional<HesaiCalibration> calibration)
    : calibration_(std::move(calibration)) {}

PacketScan HesaiDecoder::decode(const std::vector<HesaiPacket>& packets, Stamp stamp,
                                PointCloud buffer) const {
  std::vector<HesaiPacket> measured;
  std::remove_copy_if(packets.begin(), packets.end(), std::back_inserter(measured), is_calibration);
  if (measured.empty()) throw InputError("a scan of a Hesai holds no packets");
  const HesaiModel& model = hesai_model(measured);
  const auto is_whole = [&](const HesaiPacket& packet) { return model.is_whole(packet); };
  PacketScan scan = scan_of_whole(measured, is_whole, "Hesai", model.name, std::move(buffer));
  const std::vector<double> times = times_of(measured, model, stamp);
  PointCollector points(model, fitting(calibration_, packets, model), scan.cloud);
  for (std::size_t i = 0; i < measured.size(); ++i) points.add(measured[i], times[i]);
  scan.span = time_span(scan.cloud);
  return scan;
}

}  // namespace lidar_mapping::preprocessing
