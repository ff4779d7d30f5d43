// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/preprocessing/velodyne_packets.hpp"

#include "error_text.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"
#include "velodyne_encoder.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::near;
using test::put_block;
using test::put_end;
using test::VelodyneBytes;
using test::VelodyneReturn;

constexpr Stamp kStamp = 1'700'000'000'500'000'000;

/// Packets that follow one another in time by the sensor's clock and by their stamps.
class Packets {
 public:
  void add(VelodyneBytes packet, Stamp stamp) {
    bytes_.push_back(packet);
    stamps_.push_back(stamp);
  }
  std::vector<VelodynePacket> get() const {
    std::vector<VelodynePacket> packets;
    for (std::size_t i = 0; i < bytes_.size(); ++i) {
      packets.push_back({stamps_[i], bytes_[i].data()});
    }
    return packets;
  }
  VelodyneBytes& operator[](std::size_t i) { return bytes_[i]; }

 private:
  std::vector<VelodyneBytes> bytes_;
  std::vector<Stamp> stamps_;
};

/// Each channel measures its own range.
VelodyneReturn own_range(std::size_t channel) {
  return {static_cast<std::uint16_t>(1000 + 10 * channel), static_cast<std::uint8_t>(channel)};
}

/// `step`: counts of azimuth from block to block.
Packets packets_of(std::uint8_t product, unsigned step, std::uint32_t packet_us, int count = 3,
                   std::uint8_t mode = test::kStrongest) {
  Packets packets;
  const std::size_t together = mode == test::kDual ? 2 : 1;
  for (int p = 0; p < count; ++p) {
    VelodyneBytes packet{};
    for (std::size_t b = 0; b < 12; ++b) {
      const std::size_t group = 12 / together * static_cast<std::size_t>(p) + b / together;
      put_block(packet, b, static_cast<std::uint16_t>((35900 + step * group) % 36000), own_range);
    }
    const auto passed = static_cast<std::uint32_t>(p) * packet_us;
    put_end(packet, (3'599'999'000U + passed) % 3'600'000'000U, mode, product);  // a new hour
    packets.add(packet, kStamp + Stamp{passed} * 1000);
  }
  return packets;
}

/// Point `i` of the scan, in the order of packets, blocks and channels.
void expect_point(const PacketScan& scan, std::size_t i, const Eigen::Vector3d& position,
                  double time) {
  ASSERT_LT(i, scan.cloud.size());
  EXPECT_TRUE(near(scan.cloud.points[i].position().cast<double>(), position, 1e-5)) << i;
  EXPECT_NEAR(scan.cloud.times[i], time, 1e-8) << i;
}

TEST(VelodyneDecoder, KnowsEachFiringOfAVlp16) {
  const auto packets = packets_of(test::kIsVlp16, 40, 1327);
  const PacketScan scan = VelodyneDecoder().decode(packets.get(), kStamp);
  EXPECT_EQ(scan.contents, "3 packets of a Velodyne VLP-16");
  ASSERT_EQ(scan.cloud.size(), 3U * 12U * 32U);
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const std::size_t block = i / 32, channel = i % 32;
    const double firing_us =
        55.296 * static_cast<double>(channel / 16) + 2.304 * static_cast<double>(channel % 16);
    const double azimuth = 359.0 + 0.4 * (static_cast<double>(block) + firing_us / 110.592);
    const double time = 1e-6 * (1327.0 * static_cast<double>(block / 12) +
                                110.592 * static_cast<double>(block % 12) + firing_us);
    const double range = 0.002 * (1000.0 + 10.0 * static_cast<double>(channel));
    expect_point(scan, i, test::seen_at(range, azimuth, test::kVlp16Elevations[channel % 16]),
                 time);
    EXPECT_EQ(scan.cloud.points[i].intensity, static_cast<float>(channel));
  }
  EXPECT_NEAR(scan.span.begin, 0.0, 1e-9);
  EXPECT_NEAR(scan.span.end, scan.cloud.times.back(), 1e-9);
}

TEST(VelodyneDecoder, KnowsLasersAndFiringsOfAnHdl32) {
  const PacketScan scan =
      VelodyneDecoder().decode(packets_of(test::kIsHdl32, 17, 553).get(), kStamp);
  ASSERT_EQ(scan.cloud.size(), 3U * 12U * 32U);
  const auto expect = [&](std::size_t block, std::size_t laser, double elevation) {
    const double firing_us = 1.152 * static_cast<double>(laser);
    const double azimuth = 359.0 + 0.17 * (static_cast<double>(block) + firing_us / 46.08);
    expect_point(
        scan, 32 * block + laser,
        test::seen_at(0.002 * (1000.0 + 10.0 * static_cast<double>(laser)), azimuth, elevation),
        1e-6 * (553.0 * static_cast<double>(block / 12) + 46.08 * static_cast<double>(block % 12) +
                firing_us));
  };
  expect(0, 0, -92.0 / 3.0);
  expect(0, 1, -28.0 / 3.0);
  expect(7, 15, 0.0);
  expect(20, 31, 32.0 / 3.0);
}

TEST(VelodyneDecoder, KnowsLasersAndFiringsOfAVlp32c) {
  const PacketScan scan =
      VelodyneDecoder().decode(packets_of(test::kIsVlp32c, 20, 664).get(), kStamp);
  ASSERT_EQ(scan.cloud.size(), 3U * 12U * 32U);
  const auto expect = [&](std::size_t block, std::size_t laser, double elevation, double offset) {
    const double firing_us = 2.304 * static_cast<double>(laser / 2);
    const double azimuth = 359.0 + 0.2 * (static_cast<double>(block) + firing_us / 55.296) + offset;
    expect_point(
        scan, 32 * block + laser,
        test::seen_at(0.004 * (1000.0 + 10.0 * static_cast<double>(laser)), azimuth, elevation),
        1e-6 * (664.0 * static_cast<double>(block / 12) + 55.296 * static_cast<double>(block % 12) +
                firing_us));
  };
  expect(0, 0, -25.0, 1.4);
  expect(3, 1, -1.0, -4.2);
  expect(14, 6, -0.667, 4.2);
  expect(35, 29, 15.0, -1.4);
}

TEST(VelodyneDecoder, GivesBothReturnsOnceWhereTheyAreEqual) {
  Packets packets = packets_of(test::kIsVlp16, 40, 664, 2, test::kDual);
  put_block(packets[0], 3, 35940, [](std::size_t channel) {
    return channel == 5 ? VelodyneReturn{4000, 9} : own_range(channel);
  });
  const PacketScan scan = VelodyneDecoder().decode(packets.get(), kStamp);
  ASSERT_EQ(scan.cloud.size(), 2U * 6U * 32U + 1U);
  const double firing_us = 2.304 * 5.0;
  const double time = 1e-6 * (110.592 + firing_us);
  const double azimuth = 359.4 + 0.4 * firing_us / 110.592;
  expect_point(scan, 32 + 5, test::seen_at(2.1, azimuth, 5.0), time);
  expect_point(scan, 64, test::seen_at(8.0, azimuth, 5.0), time);
}

TEST(VelodyneDecoder, TakesTheTimesOfTheSensorAndTheStampThatCameSoonest) {
  Packets packets = packets_of(test::kIsVlp16, 40, 1327);
  const auto delayed = [&](const std::vector<Stamp>& delays, Stamp stamp) {
    std::vector<VelodynePacket> all = packets.get();
    for (std::size_t i = 0; i < all.size(); ++i) all[i].stamp += delays[i];
    return VelodyneDecoder().decode(all, stamp).cloud.times;
  };
  const auto undisturbed = delayed({0, 0, 0}, kStamp);
  const auto late = delayed({5'000'000, 1'000'000, 3'000'000}, kStamp + 1'000'000);
  const auto from_end = delayed({0, 0, 0}, kStamp + 2'654'000);
  ASSERT_EQ(late.size(), undisturbed.size());
  for (std::size_t i = 0; i < late.size(); i += 100) {
    EXPECT_NEAR(late[i], undisturbed[i], 1e-8);
    EXPECT_NEAR(from_end[i], undisturbed[i] - 0.002654F, 1e-8);
  }
  for (std::size_t p = 0; p < 3; ++p) put_end(packets[p], 7, test::kStrongest, test::kIsVlp16);
  const auto without_clock = delayed({0, 200'000'000, 400'000'000}, kStamp);
  EXPECT_NEAR(without_clock[32 * 12], 0.201327, 1e-6);
}

/// An entry of a calibration file.
std::string laser(int id, const std::string& more) {
  return "- {laser_id: " + std::to_string(id) + ", " + more + "}\n";
}

std::string hdl64_calibration() {
  std::string text = "num_lasers: 64\ndistance_resolution: 0.002\nlasers:\n";
  for (int id = 63; id >= 0; --id) {
    text += laser(id, "rot_correction: " + std::to_string(0.001 * id) +
                          ", vert_correction: " + std::to_string(-0.4 + 0.006 * id) +
                          ", dist_correction: 1.2, dist_correction_x: 1.25, dist_correction_y: "
                          "1.22, two_pt_correction_available: true, vert_offset_correction: 0.2, "
                          "horiz_offset_correction: 0.026, min_intensity: 30, max_intensity: 235, "
                          "focal_distance: 12.0, focal_slope: 1.4");
  }
  return text;
}

class VelodyneCalibrations : public testing::Test {
 protected:
  VelodyneCalibration read(const std::string& text) {
    std::ofstream(folder_.path() / "a.yaml") << text;
    return read_velodyne_calibration(folder_.path() / "a.yaml");
  }
  std::string refusal_of(const std::string& text) {
    return test::error_text<Error>([&] { read(text); });
  }

  const test::TemporaryFolder folder_;
};

Packets hdl64_packets(bool dual) {
  Packets packets;
  for (int p = 0; p < 4; ++p) {
    VelodyneBytes packet{};
    const std::size_t together = dual ? 4 : 2;
    for (std::size_t b = 0; b < 12; ++b) {
      const std::size_t group = 12 / together * static_cast<std::size_t>(p) + b / together;
      put_block(packet, b, static_cast<std::uint16_t>(9000 + 17 * group), own_range,
                b % 2 == 0 ? 0xEEFF : 0xDDFF);
    }
    put_end(packet, 5000U + 288U * static_cast<std::uint32_t>(p), 0x48, 0x3B);
    packets.add(packet, kStamp + Stamp{p} * 288'000);
  }
  return packets;
}

/// By the formulas of the user's manual of the HDL-64E.
TEST_F(VelodyneCalibrations, CorrectTheLasersOfAnHdl64) {
  const VelodyneDecoder decoder(read(hdl64_calibration()));
  const PacketScan scan = decoder.decode(hdl64_packets(false).get(), kStamp);
  ASSERT_EQ(scan.cloud.size(), 4U * 12U * 32U);
  EXPECT_EQ(scan.contents, "4 packets of a Velodyne HDL-64E");
  const std::size_t block = 15, channel = 9, id = 41;  // of the lower block, in the second packet
  const double vertical = -0.4 + 0.006 * id,
               horizontal = 90.0 * kRadPerDeg + 17.0 * 7.0 * 0.01 * kRadPerDeg - 0.001 * id;
  const double range = 0.002 * 1090.0 + 1.2;
  const double plane = range * std::cos(vertical) - 0.2 * std::sin(vertical);
  const double x = std::abs(plane * std::sin(horizontal) - 0.026 * std::cos(horizontal));
  const double y = std::abs(plane * std::cos(horizontal) + 0.026 * std::sin(horizontal));
  const double range_x = 0.002 * 1090.0 + 1.25 + (1.2 - 1.25) * (x - 2.4) / (25.04 - 2.4);
  const double range_y = 0.002 * 1090.0 + 1.22 + (1.2 - 1.22) * (y - 1.93) / (25.04 - 1.93);
  const double plane_x = range_x * std::cos(vertical) - 0.2 * std::sin(vertical);
  const double plane_y = range_y * std::cos(vertical) - 0.2 * std::sin(vertical);
  const Eigen::Vector3d expected(plane_y * std::cos(horizontal) + 0.026 * std::sin(horizontal),
                                 -(plane_x * std::sin(horizontal) - 0.026 * std::cos(horizontal)),
                                 range_y * std::sin(vertical) + 0.2 * std::cos(vertical));
  expect_point(scan, 32 * block + channel, expected, 1e-6 * (288.0 + 48.0));
  const double focus = 256.0 * std::pow(1.0 - 12.0 / 13100.0, 2);
  const double from_focus = std::abs(focus - 256.0 * std::pow(1.0 - 1090.0 / 65535.0, 2));
  EXPECT_NEAR(scan.cloud.points[32 * block + channel].intensity,
              std::max(30.0, 9.0 + 1.4 * from_focus), 1e-3);
  EXPECT_EQ(decoder.decode(hdl64_packets(true).get(), kStamp).cloud.size(), 4U * 6U * 32U);
}

TEST_F(VelodyneCalibrations, GoOverTheNominalAngles) {
  std::string text = "lasers:\n";
  for (int id = 0; id < 16; ++id) {
    text += laser(id, "rot_correction: 0, vert_correction: 0.1, dist_correction: 0.5");
  }
  const VelodyneCalibration calibration = read(text);
  const auto packets = packets_of(test::kIsVlp16, 40, 1327);
  const PacketScan scan = VelodyneDecoder(calibration).decode(packets.get(), kStamp);
  EXPECT_NEAR(scan.cloud.points[0].position().norm(), 2.5, 1e-5);
  EXPECT_NEAR(scan.cloud.points[0].z, 2.5 * std::sin(0.1), 1e-5);
  // A sensor whose packets do not name the product is that of the calibration.
  const auto unnamed = packets_of(0, 40, 1327);
  EXPECT_EQ(VelodyneDecoder(calibration).decode(unnamed.get(), kStamp).cloud.size(),
            scan.cloud.size());
}

TEST_F(VelodyneCalibrations, AreRefusedWithTheLaserAndTheEntry) {
  EXPECT_NE(refusal_of("lasers: 3\n").find("has no list 'lasers'"), std::string::npos);
  EXPECT_NE(refusal_of("lasers: [1, 2]\n").find("2 lasers instead of 16, 32 or 64"),
            std::string::npos);
  std::string text = hdl64_calibration();
  EXPECT_EQ(refusal_of(text), "");
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string spoilt = text;
    spoilt.replace(spoilt.find(from), from.size(), to);
    return refusal_of(spoilt);
  };
  EXPECT_NE(replaced("laser_id: 60", "laser_id: 61").find("entry 3 has a laser_id"),
            std::string::npos);
  EXPECT_NE(replaced("vert_correction", "vertical").find("entry 0 has no entry 'vert_correction'"),
            std::string::npos);
  EXPECT_NE(replaced("dist_correction: 1.2", "dist_correction: .nan").find("no number of a laser"),
            std::string::npos);
  EXPECT_NE(replaced("resolution: 0.002", "resolution: 0").find("distance_resolution above 0"),
            std::string::npos);
  EXPECT_THROW(read_velodyne_calibration(folder_.path() / "none.yaml"), FileError);
}

std::string refusal_of(const Packets& packets, const VelodyneDecoder& decoder = VelodyneDecoder()) {
  return test::error_text<InputError>([&] { decoder.decode(packets.get(), kStamp); });
}

TEST(VelodyneDecoder, NamesWhatCannotBeDecoded) {
  EXPECT_NE(refusal_of({}).find("holds no packets"), std::string::npos);
  EXPECT_NE(refusal_of(packets_of(0x7F, 40, 1327)).find("unknown Velodyne product 0x7F"),
            std::string::npos);
  EXPECT_NE(refusal_of(hdl64_packets(false)).find("name the file in velodyne_calibration"),
            std::string::npos);
  VelodyneCalibration other;
  other.lasers.resize(32);
  EXPECT_NE(refusal_of(packets_of(test::kIsVlp16, 40, 1327), VelodyneDecoder(other))
                .find("is of 32 lasers, but the packets are those of a VLP-16 with 16"),
            std::string::npos);
  Packets noise;
  noise.add(VelodyneBytes{}, kStamp);
  EXPECT_NE(refusal_of(noise).find("none of 1 packets holds blocks of a Velodyne"),
            std::string::npos);
  Packets vls128;
  VelodyneBytes packet{};
  for (std::size_t b = 0; b < 12; ++b) {
    put_block(packet, b, 100, own_range, static_cast<std::uint16_t>(0xEEFF - 0x1100 * (b % 4)));
  }
  vls128.add(packet, kStamp);
  EXPECT_NE(refusal_of(vls128).find("VLS-128"), std::string::npos);
}

/// The flags of blocks that only other models have.
TEST(VelodyneDecoder, TakesTheModelOfMostPackets) {
  for (const unsigned flag : {0xCCFFU, 0xDDFFU}) {
    Packets packets = packets_of(test::kIsVlp16, 40, 1327);
    test::put_number(packets[1], 300, flag, 2);
    const PacketScan scan = VelodyneDecoder().decode(packets.get(), kStamp);
    EXPECT_EQ(scan.contents, "3 packets of a Velodyne VLP-16") << flag;
    EXPECT_GE(scan.cloud.size(), 2U * 12U * 32U) << flag;
  }
}

TEST(VelodyneDecoder, LeavesOutDamagedPackets) {
  Packets packets = packets_of(test::kIsVlp16, 40, 1327);
  test::put_number(packets[1], 300, 0x1234, 2);  // the flag of a block
  test::put_number(packets[2], 702, 36000, 2);   // an azimuth
  const PacketScan scan = VelodyneDecoder().decode(packets.get(), kStamp);
  EXPECT_EQ(scan.damaged_packets, 2U);
  EXPECT_EQ(scan.cloud.size(), 12U * 32U);
  test::put_number(packets[0], 102, 36000, 2);
  EXPECT_NE(refusal_of(packets).find("all 3 packets of a Velodyne scan are damaged"),
            std::string::npos);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
