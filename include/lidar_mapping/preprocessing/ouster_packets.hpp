// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::preprocessing {

/// How an Ouster writes its pixels, by the names of its manual.
enum class OusterProfile {
  kLegacy,      ///< LEGACY
  kSingle,      ///< RNG19_RFL8_SIG16_NIR16
  kDualReturns  ///< RNG19_RFL8_SIG16_NIR16_DUAL
};

/// The profile of that name. Throws InputError for others, by name.
OusterProfile ouster_profile(const std::string& name);

struct OusterLayout;

/// What the metadata of an Ouster say of its packets and beams.
struct OusterFormat {
  OusterProfile profile = OusterProfile::kLegacy;  ///< of the packets
  std::size_t pixels_per_column = 0;               ///< number of beams
  std::size_t columns_per_packet = 0;              ///< number of angles of the encoder in a packet
  std::size_t columns_per_frame = 0;               ///< the same in a whole turn
  std::size_t first_column = 0;                    ///< of those that the sensor sends in a turn
  std::size_t last_column = 0;                     ///< the same, included
  std::vector<double> altitudes;                   ///< rad, of each pixel, upwards
  std::vector<double> azimuths;  ///< rad, of each pixel, clockwise from its column
  double origin_to_beam = 0.0;   ///< m, from the turning axis to where the beams begin
  double beam_height = 0.0;      ///< m, of the beams' origin above that of the LiDAR
};

/// A point of an Ouster, in the axes of its LiDAR frame.
struct OusterPoint {
  Point point;      ///< m; the intensity is the reflectivity
  Stamp stamp = 0;  ///< of its column by the sensor's clock, ns
};

/// Decodes packets of an Ouster by its manual ("Firmware User Manual", lidar data packet format and
/// coordinate frames): each column has its own time and angle of the encoder. Any thread may call
/// it.
class OusterDecoder {
 public:
  /// Throws InputError if the numbers of the format do not fit each other.
  explicit OusterDecoder(OusterFormat format);

  /// What was given to the constructor.
  const OusterFormat& format() const { return format_; }
  /// Bytes of a packet with points.
  std::size_t packet_size() const { return packet_size_; }
  /// Number of the turn that the packet belongs to; it begins anew after 65535.
  std::uint16_t frame(const std::uint8_t* packet) const;
  /// Whether the packet has this column of its turn.
  bool has_column(const std::uint8_t* packet, std::size_t number) const;
  /// Time of the packet's last column by the sensor's clock, ns.
  Stamp last_stamp(const std::uint8_t* packet) const;
  /// Appends the returns of the packet's valid columns. Of two returns both are points unless they
  /// are equal. Columns that cannot be of this sensor are left out.
  void decode(const std::uint8_t* packet, std::vector<OusterPoint>& points) const;

 private:
  const std::uint8_t* column(const std::uint8_t* packet, std::size_t index) const;
  bool is_valid(const std::uint8_t* column) const;
  void decode_column(const std::uint8_t* column, std::vector<OusterPoint>& points) const;

  OusterFormat format_;
  const OusterLayout* layout_;
  std::size_t column_size_ = 0;
  std::size_t packet_size_ = 0;
  /// Where the pixels' ranges begin, and in which direction they go, at angle 0 of the encoder.
  std::vector<Eigen::Vector3d> starts_, directions_;
  /// Cosine and sine of the encoder's angle at each column.
  std::vector<Eigen::Vector2d> encoder_;
};

/// Bytes of a packet of an Ouster's IMU.
constexpr std::size_t kOusterImuPacket = 48;  // by the manual
/// Such a packet, in the axes of the IMU: m/s^2 and rad/s; the stamp is that of the gyro by the
/// sensor's clock. Throws InputError for a time that no clock has, as of a damaged packet.
ImuSample ouster_imu(const std::uint8_t* packet);

}  // namespace lidar_mapping::preprocessing
