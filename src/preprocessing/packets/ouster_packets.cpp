// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/ouster_packets.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/number_bytes.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::preprocessing {

/// Bytes of the parts of a packet, and where their numbers are.
struct OusterLayout {
  const char* name;
  std::size_t packet_header, packet_footer;
  std::size_t column_header, column_footer;
  std::size_t pixel;
  std::size_t frame;         ///< byte of the number of the turn in a packet
  std::uint32_t range_bits;  ///< bits of a range
  std::size_t returns;       ///< number in a pixel
  /// Bytes of a return's range (32 bits) and reflectivity (8 bits) in a pixel.
  std::size_t range[2], reflectivity[2];
};

namespace {

// By the manual, in the order of OusterProfile. The columns: name, packet_header, packet_footer,
// column_header, column_footer, pixel, frame, range_bits, returns, range, reflectivity.
constexpr OusterLayout kLayouts[] = {
    {"LEGACY", 0, 0, 16, 4, 12, 10, 0xFFFFF, 1, {0, 0}, {4, 0}},
    {"RNG19_RFL8_SIG16_NIR16", 32, 32, 12, 0, 12, 2, 0x7FFFF, 1, {0, 0}, {4, 0}},
    {"RNG19_RFL8_SIG16_NIR16_DUAL", 32, 32, 12, 0, 16, 2, 0x7FFFF, 2, {0, 4}, {3, 7}}};

constexpr std::size_t kColumnNumber = 8;   // byte in a column, behind its time, by the manual
constexpr std::size_t kColumnStatus = 10;  // byte in a column but of LEGACY, by the manual
constexpr double kMetresPerCount = 1e-3;   // of a range, by the manual
/// Largest number of pixels and of columns, so that damaged metadata do not exhaust the memory.
/// Chosen: far above any sensor's 128 and 4096.
constexpr std::size_t kMost = 10'000;

/// Latest time of a column or of the IMU, ns. Chosen: 146 years, so that sums of times do not
/// overflow.
constexpr std::uint64_t kLastTime = std::uint64_t{1} << 62U;

Stamp stamp_at(const std::uint8_t* bytes) {
  return static_cast<Stamp>(number_at<std::uint64_t>(bytes));
}

bool is_number(double value) { return std::isfinite(value); }

void check(const OusterFormat& format) {
  const auto is_count = [](std::size_t count) { return count > 0 && count <= kMost; };
  const bool fits = is_count(format.pixels_per_column) && is_count(format.columns_per_packet) &&
                    is_count(format.columns_per_frame) &&
                    format.last_column < format.columns_per_frame &&
                    format.altitudes.size() == format.pixels_per_column &&
                    format.azimuths.size() == format.pixels_per_column;
  if (!fits) {
    throw InputError("the numbers of beams (" + std::to_string(format.altitudes.size()) + ", " +
                     std::to_string(format.azimuths.size()) + "), pixels (" +
                     std::to_string(format.pixels_per_column) + ") and columns (" +
                     std::to_string(format.columns_per_packet) + " of " +
                     std::to_string(format.columns_per_frame) + ") do not fit each other");
  }
  const bool are_numbers =
      std::all_of(format.altitudes.begin(), format.altitudes.end(), is_number) &&
      std::all_of(format.azimuths.begin(), format.azimuths.end(), is_number) &&
      is_number(format.origin_to_beam) && is_number(format.beam_height);
  if (!are_numbers) throw InputError("an angle or distance of the beams is not a number");
}

}  // namespace

OusterProfile ouster_profile(const std::string& name) {
  for (std::size_t i = 0; i < std::size(kLayouts); ++i) {
    if (name == kLayouts[i].name) return static_cast<OusterProfile>(i);
  }
  throw InputError("packets of the profile " + name +
                   " are not read; set udp_profile_lidar to RNG19_RFL8_SIG16_NIR16, or record the "
                   "clouds that the driver makes of them");
}

OusterDecoder::OusterDecoder(OusterFormat format)
    : format_(std::move(format)), layout_(&kLayouts[static_cast<std::size_t>(format_.profile)]) {
  check(format_);
  column_size_ =
      layout_->column_header + format_.pixels_per_column * layout_->pixel + layout_->column_footer;
  packet_size_ =
      layout_->packet_header + format_.columns_per_packet * column_size_ + layout_->packet_footer;
  // By the manual, the range counts from the turning axis along the beam's offset and the beam.
  const double offset = std::hypot(format_.origin_to_beam, format_.beam_height);
  for (std::size_t i = 0; i < format_.pixels_per_column; ++i) {
    const double altitude = format_.altitudes[i], azimuth = -format_.azimuths[i];
    directions_.emplace_back(std::cos(altitude) * std::cos(azimuth),
                             std::cos(altitude) * std::sin(azimuth), std::sin(altitude));
    starts_.push_back(Eigen::Vector3d(format_.origin_to_beam, 0.0, format_.beam_height) -
                      offset * directions_.back());
  }
  // The encoder counts clockwise.
  for (std::size_t i = 0; i < format_.columns_per_frame; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(format_.columns_per_frame);
    encoder_.emplace_back(std::cos(-2.0 * kPi * part), std::sin(-2.0 * kPi * part));
  }
}

std::uint16_t OusterDecoder::frame(const std::uint8_t* packet) const {
  return number_at<std::uint16_t>(packet + layout_->frame);
}

const std::uint8_t* OusterDecoder::column(const std::uint8_t* packet, std::size_t index) const {
  return packet + layout_->packet_header + index * column_size_;
}

/// The numbers of a packet's columns follow each other.
bool OusterDecoder::has_column(const std::uint8_t* packet, std::size_t number) const {
  const std::size_t first = number_at<std::uint16_t>(column(packet, 0) + kColumnNumber);
  return number >= first && number < first + format_.columns_per_packet;
}

Stamp OusterDecoder::last_stamp(const std::uint8_t* packet) const {
  return stamp_at(column(packet, format_.columns_per_packet - 1));
}

/// LEGACY has 32 bits behind the pixels that are all set, the others a bit behind the number.
bool OusterDecoder::is_valid(const std::uint8_t* column) const {
  if (number_at<std::uint64_t>(column) > kLastTime) return false;
  if (number_at<std::uint16_t>(column + kColumnNumber) >= format_.columns_per_frame) return false;
  if (layout_->column_footer == 0) return (column[kColumnStatus] & 1U) != 0;
  return number_at<std::uint32_t>(column + column_size_ - layout_->column_footer) == 0xFFFFFFFF;
}

void OusterDecoder::decode(const std::uint8_t* packet, std::vector<OusterPoint>& points) const {
  for (std::size_t i = 0; i < format_.columns_per_packet; ++i) {
    const std::uint8_t* const at = column(packet, i);
    if (is_valid(at)) decode_column(at, points);
  }
}

void OusterDecoder::decode_column(const std::uint8_t* column,
                                  std::vector<OusterPoint>& points) const {
  const Stamp stamp = stamp_at(column);
  const Eigen::Vector2d& encoder = encoder_[number_at<std::uint16_t>(column + kColumnNumber)];
  for (std::size_t pixel = 0; pixel < format_.pixels_per_column; ++pixel) {
    const std::uint8_t* const at = column + layout_->column_header + pixel * layout_->pixel;
    std::uint32_t earlier = 0;
    for (std::size_t i = 0; i < layout_->returns; ++i) {
      const std::uint32_t counts =
          number_at<std::uint32_t>(at + layout_->range[i]) & layout_->range_bits;
      if (counts == 0 || counts == earlier) continue;  // no return, or the same one again
      earlier = counts;
      const Eigen::Vector3d p = starts_[pixel] + kMetresPerCount * counts * directions_[pixel];
      points.push_back(
          {{static_cast<float>(encoder.x() * p.x() - encoder.y() * p.y()),
            static_cast<float>(encoder.y() * p.x() + encoder.x() * p.y()),
            static_cast<float>(p.z()), static_cast<float>(at[layout_->reflectivity[i]])},
           stamp});
    }
  }
}

ImuSample ouster_imu(const std::uint8_t* packet) {
  // Bytes: behind the times of system and accelerometer that of the gyro; g; degrees/s, by the
  // manual.
  constexpr std::size_t kGyroTime = 16, kAcceleration = 24, kTurning = 36;  // by the manual
  const auto vector_at = [&](std::size_t byte) {
    Eigen::Vector3f vector;
    std::memcpy(vector.data(), packet + byte, 3 * sizeof(float));
    return Eigen::Vector3d(vector.cast<double>());
  };
  if (number_at<std::uint64_t>(packet + kGyroTime) > kLastTime) {
    throw InputError("a time of the sensor is out of range");
  }
  ImuSample sample;
  sample.stamp = stamp_at(packet + kGyroTime);
  sample.linear_acceleration = kStandardGravity * vector_at(kAcceleration);
  sample.angular_velocity = kRadPerDeg * vector_at(kTurning);
  return sample;
}

}  // namespace lidar_mapping::preprocessing
