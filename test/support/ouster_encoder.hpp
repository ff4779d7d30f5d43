// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/common/units.hpp"

// Packets as sensors of Ouster send them, and by formulas of its own where their points lie.
namespace lidar_mapping::test {

struct OusterReturn {
  std::uint32_t counts = 0;  ///< mm; 0 for no return
  std::uint8_t reflectivity = 0;
};

/// A sensor of which only the numbers of beams and columns are made up.
struct OusterSensor {
  std::string profile = "RNG19_RFL8_SIG16_NIR16";
  std::size_t columns_per_packet = 8;
  std::size_t columns = 1800;
  std::vector<double> altitudes_deg, azimuths_deg;
  double origin_to_beam_mm = 15.806;

  bool is_legacy() const { return profile == "LEGACY"; }
  bool is_dual() const { return profile == "RNG19_RFL8_SIG16_NIR16_DUAL"; }
  std::size_t pixels() const { return altitudes_deg.size(); }

  /// As newer firmware has it; that of LEGACY has all keys at the top.
  std::string metadata() const {
    std::ostringstream text;
    text << (is_legacy() ? "{\"prod_line\": \"OS-1-16\", " : "{\"beam_intrinsics\": {");
    write_list(text, "beam_altitude_angles", altitudes_deg);
    write_list(text, "beam_azimuth_angles", azimuths_deg);
    text << "\"lidar_origin_to_beam_origin_mm\": " << origin_to_beam_mm;
    text << (is_legacy() ? ", \"data_format\": {" : "}, \"lidar_data_format\": {");
    text << "\"pixels_per_column\": " << pixels()
         << ", \"columns_per_packet\": " << columns_per_packet
         << ", \"columns_per_frame\": " << columns << ", \"column_window\": [0, " << columns - 1
         << "], \"pixel_shift_by_row\": [0]";
    if (!is_legacy()) text << ", \"udp_profile_lidar\": \"" << profile << "\"";
    text << "}}";
    return text.str();
  }

  std::size_t packet_size() const {
    const std::size_t ends = is_legacy() ? 0 : 64;
    return ends + columns_per_packet * column_size();
  }
  std::size_t column_size() const {
    return (is_legacy() ? 20 : 12) + (is_dual() ? 16 : 12) * pixels();
  }
  std::size_t column_at(std::size_t index) const {
    return (is_legacy() ? 0 : 32) + index * column_size();
  }

  /// Where a pixel sees a point in a column, in m: the manual's formula.
  Eigen::Vector3d point(std::size_t column, std::size_t pixel, double range_mm) const {
    const double encoder =
        2.0 * kPi * (1.0 - static_cast<double>(column) / static_cast<double>(columns));
    const double azimuth = -azimuths_deg[pixel] * kRadPerDeg;
    const double altitude = altitudes_deg[pixel] * kRadPerDeg;
    const double n = origin_to_beam_mm, r = range_mm - n;
    return 1e-3 * Eigen::Vector3d(
                      r * std::cos(encoder + azimuth) * std::cos(altitude) + n * std::cos(encoder),
                      r * std::sin(encoder + azimuth) * std::cos(altitude) + n * std::sin(encoder),
                      r * std::sin(altitude));
  }

 private:
  static void write_list(std::ostream& out, const char* key, const std::vector<double>& values) {
    out << '"' << key << "\": [";
    for (std::size_t i = 0; i < values.size(); ++i) out << (i == 0 ? "" : ", ") << values[i];
    out << "], ";
  }
};

template <typename Number>
void put_at(std::vector<std::uint8_t>& bytes, std::size_t at, Number number) {
  std::memcpy(&bytes[at], &number, sizeof number);
}

/// A packet whose columns begin with `first`. Times in ns; `measured(column, pixel)`.
template <typename Measured>
std::vector<std::uint8_t> ouster_packet(const OusterSensor& sensor, std::uint16_t frame,
                                        std::size_t first, std::uint64_t begin, std::uint64_t step,
                                        const Measured& measured) {
  std::vector<std::uint8_t> packet(sensor.packet_size());
  if (!sensor.is_legacy()) {
    put_at(packet, 0, std::uint16_t{1});
    put_at(packet, 2, frame);
  }
  for (std::size_t i = 0; i < sensor.columns_per_packet; ++i) {
    const std::size_t at = sensor.column_at(i), number = first + i;
    put_at(packet, at, begin + i * step);
    put_at(packet, at + 8, static_cast<std::uint16_t>(number));
    if (sensor.is_legacy()) {
      put_at(packet, at + 10, frame);
      put_at(packet, at + sensor.column_size() - 4, 0xFFFFFFFFU);
    } else {
      put_at(packet, at + 10, std::uint16_t{1});
    }
    for (std::size_t pixel = 0; pixel < sensor.pixels(); ++pixel) {
      const OusterReturn value = measured(number, pixel);
      const std::size_t to =
          at + (sensor.is_legacy() ? 16 : 12) + (sensor.is_dual() ? 16 : 12) * pixel;
      put_at(packet, to, value.counts);
      packet[to + (sensor.is_dual() ? 3 : 4)] = value.reflectivity;
    }
  }
  return packet;
}

/// A packet of the IMU: ns, g and degrees/s.
inline std::vector<std::uint8_t> ouster_imu_packet(std::uint64_t time, const Eigen::Vector3d& g,
                                                   const Eigen::Vector3d& deg_s) {
  std::vector<std::uint8_t> packet(48);
  put_at(packet, 0, time + 5);
  put_at(packet, 8, time + 3);
  put_at(packet, 16, time);
  for (int i = 0; i < 3; ++i) {
    put_at(packet, 24 + 4 * static_cast<std::size_t>(i), static_cast<float>(g[i]));
    put_at(packet, 36 + 4 * static_cast<std::size_t>(i), static_cast<float>(deg_s[i]));
  }
  return packet;
}

}  // namespace lidar_mapping::test
