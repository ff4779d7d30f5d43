// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/velodyne_packets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/number_bytes.hpp"
#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/units.hpp"

#include "packets/packet_decoding.hpp"
#include "packets/velodyne_models.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// Layout of a block and of a packet by the user's manual: numbers of bytes, and byte at which a
// value begins.
constexpr std::size_t kAzimuthAt = 2;         // in a block, by the manual
constexpr std::size_t kChannelsAt = 4;        // in a block: the first channel, by the manual
constexpr std::size_t kChannelBytes = 3;      // range (two) and reflectivity, by the manual
constexpr std::size_t kChannelsOfBlock = 32;  // by the user's manual
constexpr std::size_t kTimeAt = 1200;         // in a packet, by the manual
/// us until the sensor's time begins anew, by the manual: an hour.
constexpr std::int64_t kVelodyneHour = 3'600'000'000;
/// From packet to packet of an HDL-64E, s, by its user's manual (1.333 million points a second);
/// used where a scan has a single packet.
constexpr double kHdl64Packet = 288e-6;

// Distances of the two places at which an HDL-64E is calibrated, m, by its user's manual.
constexpr double kNearX = 2.4, kNearY = 1.93, kFar = 25.04;
/// Counts of the range of an HDL-64E at which its focal distances end, by its user's manual.
constexpr double kFocalEnd = 13100.0;

unsigned azimuth_of(const unsigned char* block) {
  return number_at<std::uint16_t>(block + kAzimuthAt);
}

bool is_whole(const VelodynePacket& packet) {
  for (std::size_t b = 0; b < kBlocksOfPacket; ++b) {
    const unsigned char* block = packet.data + b * kBlockBytes;
    const unsigned flag = number_at<std::uint16_t>(block);
    if ((flag != kUpperBlock && flag != kLowerBlock) || azimuth_of(block) >= kTurn) return false;
  }
  return true;
}

/// Times of the packets' first firings, s after the scan's stamp.
std::vector<double> times_of(const std::vector<VelodynePacket>& packets, Stamp stamp) {
  std::vector<PacketTime> times;
  for (const VelodynePacket& packet : packets) {
    times.push_back({packet.stamp, number_at<std::uint32_t>(packet.data + kTimeAt)});
  }
  return packet_times(times, kVelodyneHour, stamp);
}

/// s from packet to packet.
double packet_duration(const std::vector<double>& times) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  const double step = steps.empty() ? 0.0 : median(steps);
  return step > 0.0 ? step : kHdl64Packet;
}

std::vector<AzimuthGroup> groups_of(const unsigned char* packet) {
  std::array<unsigned, kBlocksOfPacket> azimuths{};
  for (std::size_t b = 0; b < kBlocksOfPacket; ++b)
    azimuths[b] = azimuth_of(packet + b * kBlockBytes);
  return azimuth_groups(azimuths.data(), kBlocksOfPacket);
}

/// A laser of an HDL-64E is calibrated at two distances, and by its manual the correction is linear
/// in between: by how much it differs at `distance` (m) from that at kFar.
double near_correction(double distance, double near_place, double near_value, double far_value) {
  return (far_value - near_value) * (distance - near_place) / (kFar - near_place) + near_value -
         far_value;
}

/// A laser whose functions of constant angles are known.
class Laser {
 public:
  Laser(const LaserCorrection& correction, double resolution)
      : c_(correction),
        resolution_(resolution),
        cos_(std::cos(correction.vert_correction)),
        sin_(std::sin(correction.vert_correction)),
        focal_(256.0 * square(1.0 - correction.focal_distance / kFocalEnd)) {}

  /// The point at an azimuth in rad, clockwise from ahead.
  Point point(unsigned counts, unsigned reflectivity, double azimuth) const {
    const double c = std::cos(azimuth - c_.rot_correction);
    const double s = std::sin(azimuth - c_.rot_correction);
    const double range = counts * resolution_ + c_.dist_correction;
    double side = range, ahead = range;
    if (c_.has_two_points) {
      side += near_correction(std::abs(right(range, c, s)), kNearX, c_.dist_correction_x,
                              c_.dist_correction);
      ahead += near_correction(std::abs(front(range, c, s)), kNearY, c_.dist_correction_y,
                               c_.dist_correction);
    }
    const double up = ahead * sin_ + c_.vert_offset_correction * cos_;
    return {static_cast<float>(front(ahead, c, s)), static_cast<float>(-right(side, c, s)),
            static_cast<float>(up), intensity(counts, reflectivity)};
  }

 private:
  static double square(double value) { return value * value; }

  double horizontal(double range) const { return range * cos_ - c_.vert_offset_correction * sin_; }
  double right(double range, double c, double s) const {
    return horizontal(range) * s - c_.horiz_offset_correction * c;
  }
  double front(double range, double c, double s) const {
    return horizontal(range) * c + c_.horiz_offset_correction * s;
  }
  float intensity(unsigned counts, unsigned reflectivity) const {
    const double from_focus = std::abs(focal_ - 256.0 * square(1.0 - counts / 65535.0));
    const double value = reflectivity + c_.focal_slope * from_focus;
    return static_cast<float>(std::max(c_.min_intensity, std::min(c_.max_intensity, value)));
  }

  LaserCorrection c_;
  double resolution_;
  double cos_, sin_;
  double focal_;
};

/// Collects the points of a scan.
class PointCollector {
 public:
  PointCollector(const VelodyneModel& model, const VelodyneCalibration& calibration,
                 PointCloud& cloud)
      : model_(model), cloud_(cloud) {
    for (const LaserCorrection& correction : calibration.lasers) {
      lasers_.emplace_back(correction, calibration.distance_resolution);
    }
  }

  /// `begin`: of the packet, s after the scan's stamp. `duration`: s to the next packet, for models
  /// whose firing times are not known.
  void add(const unsigned char* packet, double begin, double duration) {
    const std::vector<AzimuthGroup> groups = groups_of(packet);
    const double known = static_cast<double>(model_.sequences) * model_.sequence;
    const double step = known > 0.0 ? known : duration / static_cast<double>(groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const double time = begin + static_cast<double>(g) * step;
      for (std::size_t block = groups[g].begin; block < groups[g].end; ++block) {
        add_block(packet, groups[g], block, time, step);
      }
    }
  }

 private:
  void add_block(const unsigned char* packet, const AzimuthGroup& group, std::size_t block,
                 double time, double duration) {
    const unsigned char* const at = packet + block * kBlockBytes;
    const unsigned char* const first = first_return(packet, group, block);
    const std::size_t bank = number_at<std::uint16_t>(at) == kLowerBlock ? kChannelsOfBlock : 0;
    for (std::size_t channel = 0; channel < kChannelsOfBlock; ++channel) {
      const unsigned char* const measured = at + kChannelsAt + channel * kChannelBytes;
      const unsigned counts = number_at<std::uint16_t>(measured);
      if (counts == 0) continue;  // no return
      if (first != nullptr &&
          counts == number_at<std::uint16_t>(first + kChannelsAt + channel * kChannelBytes)) {
        continue;  // the strongest return is the last one, too
      }
      const std::size_t laser = (channel + bank) % model_.lasers;
      const double delay = firing_delay(channel, laser);
      const double azimuth = group.azimuth + group.step * delay / duration;
      cloud_.points.push_back(
          lasers_[laser].point(counts, measured[2], azimuth * 0.01 * kRadPerDeg));
      cloud_.times.push_back(static_cast<float>(time + delay));
    }
  }

  /// The block with the other return of the same lasers; null for the first one.
  static const unsigned char* first_return(const unsigned char* packet, const AzimuthGroup& group,
                                           std::size_t block) {
    const unsigned flag = number_at<std::uint16_t>(packet + block * kBlockBytes);
    for (std::size_t other = group.begin; other < block; ++other) {
      if (number_at<std::uint16_t>(packet + other * kBlockBytes) == flag)
        return packet + other * kBlockBytes;
    }
    return nullptr;
  }

  /// s after the beginning of the block.
  double firing_delay(std::size_t channel, std::size_t laser) const {
    const std::size_t sequence = channel / std::min(model_.lasers, kChannelsOfBlock);
    return static_cast<double>(sequence) * model_.sequence +
           static_cast<double>(laser / model_.together) * model_.firing;
  }

  const VelodyneModel& model_;
  PointCloud& cloud_;
  std::vector<Laser> lasers_;
};

VelodyneCalibration fitting(const std::optional<VelodyneCalibration>& calibration,
                            const VelodyneModel& model) {
  if (!calibration) return nominal_calibration(model);
  check_lasers("velodyne_calibration", calibration->lasers.size(), model.name, model.lasers);
  return *calibration;
}

}  // namespace

VelodyneDecoder::VelodyneDecoder(std::optional<VelodyneCalibration> calibration)
    : calibration_(std::move(calibration)) {}

PacketScan VelodyneDecoder::decode(const std::vector<VelodynePacket>& packets, Stamp stamp,
                                   PointCloud buffer) const {
  if (packets.empty()) throw InputError("a scan of a Velodyne holds no packets");
  const VelodyneModel& model = velodyne_model(packets, calibration_);
  std::vector<VelodynePacket> whole = packets;
  PacketScan scan = scan_of_whole(whole, is_whole, "Velodyne", model.name, std::move(buffer));
  const std::vector<double> times = times_of(whole, stamp);
  const double duration = packet_duration(times);
  PointCollector points(model, fitting(calibration_, model), scan.cloud);
  for (std::size_t i = 0; i < whole.size(); ++i) points.add(whole[i].data, times[i], duration);
  scan.span = time_span(scan.cloud);
  return scan;
}

}  // namespace lidar_mapping::preprocessing
