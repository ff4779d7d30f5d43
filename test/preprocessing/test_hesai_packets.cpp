// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/preprocessing/hesai_packets.hpp"

#include "error_text.hpp"
#include "hesai_encoder.hpp"
#include "near.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::HesaiBlock;
using test::HesaiBytes;
using test::HesaiPacketWriter;
using test::HesaiReturn;
using test::HesaiSensor;
using test::near;

constexpr Stamp kStamp = 1'700'000'000'500'000'000;

/// Packets that follow one another in time by the sensor's clock and by their stamps.
class Packets {
 public:
  void add(HesaiBytes packet, Stamp stamp) {
    bytes_.push_back(std::move(packet));
    stamps_.push_back(stamp);
  }
  std::vector<HesaiPacket> get() const {
    std::vector<HesaiPacket> packets;
    for (std::size_t i = 0; i < bytes_.size(); ++i) {
      packets.push_back({stamps_[i], bytes_[i].data(), bytes_[i].size()});
    }
    return packets;
  }
  HesaiBytes& operator[](std::size_t i) { return bytes_[i]; }

 private:
  std::vector<HesaiBytes> bytes_;
  std::vector<Stamp> stamps_;
};

/// Each laser measures its own range.
HesaiReturn own_range(std::size_t laser) {
  return {static_cast<std::uint16_t>(1000 + 10 * laser), static_cast<std::uint8_t>(laser)};
}
double range_of(std::size_t laser) { return 0.004 * (1000.0 + 10.0 * static_cast<double>(laser)); }

/// How packets are made: from 359 degrees on, while a new second begins.
struct Turn {
  unsigned step = 18;             ///< counts of azimuth from one to the next
  std::uint32_t packet_us = 400;  ///< from packet to packet
  std::size_t returns = 1;        ///< blocks of the same azimuth
  std::size_t count = 3;          ///< of packets
  bool numbered = true;           ///< whether packets have a number
};

Packets packets_of(const HesaiSensor& sensor, const Turn& turn) {
  Packets packets;
  for (std::size_t p = 0; p < turn.count; ++p) {
    std::vector<HesaiBlock> blocks;
    for (std::size_t b = 0; b < sensor.blocks; ++b) {
      const std::size_t group = (sensor.blocks * p + b) / turn.returns;
      blocks.push_back(
          {static_cast<std::uint16_t>((35900 + turn.step * group) % 36000), own_range});
    }
    const auto passed = static_cast<std::uint32_t>(p) * turn.packet_us;
    packets.add(
        HesaiPacketWriter(sensor).write(blocks, (999'500U + passed) % 1'000'000U, turn.numbered),
        kStamp + Stamp{passed} * 1000);
  }
  return packets;
}

/// Point `i` of the scan, in the order of packets, blocks and lasers.
void expect_point(const PacketScan& scan, std::size_t i, const Eigen::Vector3d& position,
                  double time_us) {
  ASSERT_LT(i, scan.cloud.size());
  EXPECT_TRUE(near(scan.cloud.points[i].position().cast<double>(), position, 1e-5)) << i;
  EXPECT_NEAR(scan.cloud.times[i], 1e-6 * time_us, 1e-8) << i;
}

/// The time of a block, us, after that of its packet.
using BlockTime = std::function<double(std::size_t block)>;

/// What is expected of a laser: its elevation and offset of azimuth, degrees, and when it fires, us
/// after the time of its block.
struct ExpectedLaser {
  std::size_t index;
  double elevation, azimuth, firing_us;
};

/// Expects a laser at its place and time in all packets in single return mode.
void expect_laser(const PacketScan& scan, const HesaiSensor& sensor, const Turn& turn,
                  const ExpectedLaser& laser, double block_us, const BlockTime& block_time) {
  for (std::size_t block = 0; block < turn.count * sensor.blocks; ++block) {
    const double turned = static_cast<double>(block) + laser.firing_us / block_us;
    const double azimuth = 359.0 + 0.01 * turn.step * turned + laser.azimuth;
    const double time = static_cast<double>(turn.packet_us * (block / sensor.blocks)) +
                        block_time(block % sensor.blocks) + laser.firing_us;
    expect_point(scan, sensor.lasers * block + laser.index,
                 test::hesai_seen_at(range_of(laser.index), azimuth, laser.elevation), time);
  }
}

PacketScan decoded(const HesaiSensor& sensor, const Turn& turn) {
  const PacketScan scan = HesaiDecoder().decode(packets_of(sensor, turn).get(), kStamp);
  EXPECT_EQ(scan.cloud.size(), turn.count * sensor.blocks * sensor.lasers);
  EXPECT_EQ(scan.damaged_packets, 0U);
  return scan;
}

/// By the user's manual: the time of a packet is that of its last block but for 5.632 us.
double xt_block_time(std::size_t block) {
  return 5.632 - 50.0 * (7.0 - static_cast<double>(block));
}

TEST(HesaiDecoder, KnowsEachFiringOfAPandarXt32) {
  const Turn turn;
  const PacketScan scan = decoded(test::kPandarXt32, turn);
  EXPECT_EQ(scan.contents, "3 packets of a Hesai PandarXT-32");
  for (std::size_t laser = 0; laser < 32; ++laser) {
    const auto number = static_cast<double>(laser);
    expect_laser(scan, test::kPandarXt32, turn, {laser, 15.0 - number, 0.0, 0.368 + 1.512 * number},
                 50.0, xt_block_time);
    EXPECT_EQ(scan.cloud.points[laser].intensity, static_cast<float>(laser));
  }
  EXPECT_NEAR(scan.span.begin, 1e-6 * (5.632 - 350.0 + 0.368), 1e-8);
  EXPECT_NEAR(scan.span.end, scan.cloud.times.back(), 1e-9);
}

TEST(HesaiDecoder, KnowsEachFiringOfAPandarXt16) {
  const Turn turn;
  const PacketScan scan = decoded(test::kPandarXt16, turn);
  EXPECT_EQ(scan.contents, "3 packets of a Hesai PandarXT-16");
  for (std::size_t laser = 0; laser < 16; ++laser) {
    const auto number = static_cast<double>(laser);
    expect_laser(scan, test::kPandarXt16, turn,
                 {laser, 15.0 - 2.0 * number, 0.0, 0.368 + 3.024 * number}, 50.0, xt_block_time);
  }
}

TEST(HesaiDecoder, KnowsLasersAndFiringsOfAPandar40p) {
  for (const bool numbered : {false, true}) {
    const Turn turn{20, 556, 1, 3, numbered};
    const PacketScan scan = decoded(test::kPandar40p, turn);
    EXPECT_EQ(scan.contents, "3 packets of a Hesai Pandar40P");
    const auto end_of_block = [](std::size_t block) {
      return -28.58 - 55.56 * (9.0 - static_cast<double>(block));
    };
    for (const ExpectedLaser& laser :
         {ExpectedLaser{0, 15.0, -1.042, -42.22}, ExpectedLaser{3, 5.0, -1.042, -3.62},
          ExpectedLaser{7, 1.33, -5.208, -54.67}, ExpectedLaser{9, 0.67, 3.125, -33.71},
          ExpectedLaser{39, -25.0, -1.042, -3.62}}) {
      expect_laser(scan, test::kPandar40p, turn, laser, 55.56, end_of_block);
    }
  }
}

TEST(HesaiDecoder, KnowsLasersAndFiringsOfAPandar64) {
  for (const bool numbered : {false, true}) {
    const Turn turn{20, 333, 1, 3, numbered};
    const PacketScan scan = decoded(test::kPandar64, turn);
    EXPECT_EQ(scan.contents, "3 packets of a Hesai Pandar64");
    const auto end_of_block = [](std::size_t block) {
      return -42.58 - 55.56 * (5.0 - static_cast<double>(block));
    };
    for (const ExpectedLaser& laser :
         {ExpectedLaser{0, 14.882, -1.042, -(15 * 1.304 + 3.62)},
          ExpectedLaser{11, 1.013, -1.042, -(15 * 1.304 + 16 * 1.968 + 3.62)},
          ExpectedLaser{50, -5.565, 5.208, -3.62}, ExpectedLaser{60, -12.974, -1.042, -3.62},
          ExpectedLaser{63, -24.897, -1.042, -(7 * 1.304 + 3.62)}}) {
      expect_laser(scan, test::kPandar64, turn, laser, 55.56, end_of_block);
    }
  }
}

TEST(HesaiDecoder, KnowsLasersAndFiringsOfAPandarQt) {
  for (const bool numbered : {false, true}) {
    const Turn turn{60, 667, 1, 3, numbered};
    const PacketScan scan = decoded(test::kPandarQt, turn);
    EXPECT_EQ(scan.contents, "3 packets of a Hesai PandarQT");
    const auto begin_of_block = [](std::size_t block) {
      return 25.71 + 500.0 / 3.0 * static_cast<double>(block);
    };
    for (const ExpectedLaser& laser :
         {ExpectedLaser{0, -52.121, 8.736, 12.31}, ExpectedLaser{31, -0.725, -4.881, 77.86},
          ExpectedLaser{32, 0.725, 5.493, 80.9}, ExpectedLaser{55, 36.064, -5.974, 129.6},
          ExpectedLaser{63, 52.133, -7.892, 146.45}}) {
      expect_laser(scan, test::kPandarQt, turn, laser, 500.0 / 3.0, begin_of_block);
    }
  }
}

TEST(HesaiDecoder, GivesBothReturnsOnceWhereTheyAreEqual) {
  const Turn turn{18, 200, 2, 2, true};
  Packets packets = packets_of(test::kPandarXt32, turn);
  // The second return of laser 5 at the second azimuth: behind the header and three blocks.
  const std::size_t at = 12 + 3 * 130 + 2 + 4 * 5;
  packets[0][at] = 0xA0;
  packets[0][at + 1] = 0x0F;  // 4000 counts
  const PacketScan scan = HesaiDecoder().decode(packets.get(), kStamp);
  ASSERT_EQ(scan.cloud.size(), 2U * 4U * 32U + 1U);
  const double firing_us = 0.368 + 1.512 * 5.0;
  const double azimuth = 359.0 + 0.18 * (1.0 + firing_us / 50.0);
  const double time = 5.632 - 50.0 * 2.0 + firing_us;
  expect_point(scan, 32 + 5, test::hesai_seen_at(range_of(5), azimuth, 10.0), time);
  expect_point(scan, 64, test::hesai_seen_at(16.0, azimuth, 10.0), time);
}

/// Two blocks of a PandarQT are measured at the beginning of a packet in dual return mode.
TEST(HesaiDecoder, CountsTheAzimuthsOfAPandarQtInDualReturnMode) {
  const PacketScan scan =
      HesaiDecoder().decode(packets_of(test::kPandarQt, {60, 333, 2, 2, true}).get(), kStamp);
  ASSERT_EQ(scan.cloud.size(), 2U * 2U * 64U);
  EXPECT_NEAR(scan.cloud.times[0], 1e-6 * (25.71 + 12.31), 1e-8);
  EXPECT_NEAR(scan.cloud.times[64], 1e-6 * (25.71 + 500.0 / 3.0 + 12.31), 1e-8);
}

TEST(HesaiDecoder, TakesTheTimesOfTheSensorAndTheStampThatCameSoonest) {
  const std::vector<Stamp> delays = {5'000'000, 1'000'000, 3'000'000};
  const Packets packets = packets_of(test::kPandarXt32, {});
  std::vector<HesaiPacket> late = packets.get();
  for (std::size_t i = 0; i < late.size(); ++i) late[i].stamp += delays[i];
  const auto expected = HesaiDecoder().decode(packets.get(), kStamp).cloud.times;
  const auto times = HesaiDecoder().decode(late, kStamp + 1'000'000).cloud.times;
  ASSERT_EQ(times.size(), expected.size());
  for (std::size_t i = 0; i < times.size(); i += 100) EXPECT_NEAR(times[i], expected[i], 1e-8);
}

HesaiCalibration calibration_of(std::size_t lasers, double elevation, double azimuth) {
  HesaiCalibration calibration;
  calibration.lasers.assign(lasers, {elevation, azimuth});
  return calibration;
}

std::string text_of(int lasers) {
  std::string text = "Laser id,Elevation,Azimuth\n";
  for (int i = 1; i <= lasers; ++i) text += std::to_string(i) + ",-5.5,2.25\n";
  return text;
}

TEST(HesaiDecoder, TakesTheCalibrationThatIsGivenOrBesideThePackets) {
  Packets packets = packets_of(test::kPandarXt32, {});
  packets.add(test::hesai_calibration_packet(text_of(32)), kStamp);
  const auto expect_direction = [&](const HesaiDecoder& decoder, double elevation, double azimuth) {
    const PacketScan scan = decoder.decode(packets.get(), kStamp);
    EXPECT_EQ(scan.damaged_packets, 0U);
    EXPECT_EQ(scan.contents, "3 packets of a Hesai PandarXT-32");
    const double firing_us = 0.368 + 1.512 * 3.0;
    const double turned = 359.0 + 0.18 * firing_us / 50.0 + azimuth;
    expect_point(scan, 3, test::hesai_seen_at(range_of(3), turned, elevation),
                 5.632 - 350.0 + firing_us);
  };
  expect_direction(HesaiDecoder(), -5.5, 2.25);
  expect_direction(HesaiDecoder(calibration_of(32, 0.1, -0.2)), 0.1 * kDegPerRad,
                   -0.2 * kDegPerRad);
}

std::string refusal_of(const Packets& packets, const HesaiDecoder& decoder = HesaiDecoder()) {
  return test::error_text<InputError>([&] { decoder.decode(packets.get(), kStamp); });
}

void expect_refusal(const std::string& refusal, const std::string& words) {
  EXPECT_NE(refusal.find(words), std::string::npos) << refusal;
}

TEST(HesaiDecoder, NamesWhatCannotBeDecoded) {
  expect_refusal(refusal_of({}), "a scan of a Hesai holds no packets");
  // A PandarXTM has six blocks of 32 lasers.
  const HesaiSensor other{32, 6, 6, true};
  expect_refusal(refusal_of(packets_of(other, {})),
                 "packets of 820 bytes (protocol 6.1, 32 lasers) are not read, only those of "
                 "Pandar40P, Pandar64, PandarQT, PandarXT-16, PandarXT-32; convert them with the "
                 "cloud node of the sensor's driver");
  Packets noise;
  noise.add(HesaiBytes(1206), kStamp);
  expect_refusal(refusal_of(noise), "packets of 1206 bytes are not read");
  Packets empty;
  empty.add(HesaiBytes(), kStamp);
  expect_refusal(refusal_of(empty), "packets of 0 bytes are not read");
}

TEST(HesaiDecoder, NamesCalibrationsThatDoNotFit) {
  Packets packets = packets_of(test::kPandarXt32, {});
  expect_refusal(refusal_of(packets, HesaiDecoder(calibration_of(16, 0.0, 0.0))),
                 "hesai_calibration is of 16 lasers, but the packets are those of a PandarXT-32 "
                 "with 32; name the file of this sensor");
  packets.add(test::hesai_calibration_packet(text_of(40)), kStamp);
  expect_refusal(refusal_of(packets), "the calibration in the scan is of 40 lasers");
  packets[3].resize(40);
  expect_refusal(refusal_of(packets), "has 32 bytes instead of 538");
  packets[3] = test::hesai_calibration_packet("1,2\n");
  expect_refusal(refusal_of(packets),
                 "the calibration in a scan of a Hesai, line 1: 2 values instead of 3");
}

TEST(HesaiDecoder, LeavesOutDamagedPackets) {
  Packets packets = packets_of(test::kPandarXt32, {18, 400, 1, 6, true});
  packets[1][0] = 0;         // the flag of the packet
  packets[2][6] = 31;        // the number of lasers
  packets[3][9] = 0;         // the unit
  packets[4][12 + 1] = 200;  // an azimuth of more than a turn
  packets[5].resize(700);
  const PacketScan scan = HesaiDecoder().decode(packets.get(), kStamp);
  EXPECT_EQ(scan.damaged_packets, 5U);
  EXPECT_EQ(scan.cloud.size(), 8U * 32U);
  EXPECT_EQ(scan.contents, "6 packets of a Hesai PandarXT-32");
  packets[0][0] = 0;
  expect_refusal(refusal_of(packets), "all 6 packets of a Hesai scan are damaged");
  Packets of_40p = packets_of(test::kPandar40p, {20, 556, 1, 2, true});
  of_40p[1][124] = 0;  // the flag of the second block
  EXPECT_EQ(HesaiDecoder().decode(of_40p.get(), kStamp).damaged_packets, 1U);
}

TEST(HesaiDecoder, LeavesOutWhatGivesNoReturn) {
  std::vector<HesaiBlock> blocks(
      8, {100, [](std::size_t laser) { return laser == 7 ? own_range(7) : HesaiReturn{}; }});
  for (std::size_t b = 0; b < 8; ++b) blocks[b].azimuth = static_cast<std::uint16_t>(100 + 18 * b);
  Packets packets;
  packets.add(HesaiPacketWriter(test::kPandarXt32).write(blocks, 5), kStamp);
  EXPECT_EQ(HesaiDecoder().decode(packets.get(), kStamp).cloud.size(), 8U);
}

TEST(HesaiModelName, FollowsFromTheSize) {
  const auto name_of_size = [](std::size_t size) { return hesai_model_name({0, nullptr, size}); };
  EXPECT_EQ(name_of_size(1262), "Pandar40P");
  EXPECT_EQ(name_of_size(1266), "Pandar40P");
  EXPECT_EQ(name_of_size(1198), "Pandar64");
  EXPECT_EQ(name_of_size(1072), "PandarQT");
  EXPECT_EQ(name_of_size(568), "PandarXT-16");
  EXPECT_EQ(name_of_size(1080), "PandarXT-32");
  EXPECT_EQ(name_of_size(820), "");
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
