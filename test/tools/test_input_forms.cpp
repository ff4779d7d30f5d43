// SPDX-License-Identifier: BSD-3-Clause
// The same drive in the forms of other drivers: the poses have to be those of the plain clouds.
#include <fstream>

#include <topic_tools/shape_shifter.h>

#include "hesai_messages.hpp"
#include "input_forms.hpp"

namespace lidar_mapping::tools {
namespace {

using sensor_msgs::PointCloud2;
using test::InputForms;
using test::kTopic;
using test::LivoxDriver;
using test::with;
using test::WriteCloud;

TEST_F(InputForms, SplitTimes) { expect_poses_of_the_drive("split", with(test::with_split_times)); }

TEST_F(InputForms, LivoxCustomMsgOfBothDrivers) {
  expect_poses_of_the_drive("livox", with(test::as_livox<LivoxDriver::kOne>));
  expect_poses_of_the_drive("livox2", with(test::as_livox<LivoxDriver::kTwo>));
  expect_said(checked(written("said", with(test::as_livox<LivoxDriver::kTwo>))),
              "fields offset_time x y z reflectivity tag line", 0);
  EXPECT_TRUE(has_said("times in `offset_time` (ns, relative)"));
}

TEST_F(InputForms, PointCloud1) {
  expect_poses_of_the_drive("cloud1", with(test::as_point_cloud1));
}

test::VelodyneTurn turn_of(const PointCloud2& cloud) {
  return test::VelodyneTurnWriter(cloud).write();
}

TEST_F(InputForms, VelodynePackets) {
  const std::string packets =
      written("packets", with([](const PointCloud2& cloud) { return turn_of(cloud).packets; }));
  const std::string clouds =
      written("clouds", with([](const PointCloud2& cloud) { return turn_of(cloud).cloud; }));
  expect_equal_poses(mapped(packets), mapped(clouds));
  expect_said(checked(packets), "75 packets of a Velodyne VLP-16", 0);
  EXPECT_TRUE(has_said("times in `packets` (us, absolute) from -0.0987 to 0.00"));
}

using test::PandarDriver;

test::HesaiTurn hesai_turn_of(const PointCloud2& cloud) {
  return test::HesaiTurnWriter(cloud).write();
}

/// As the drive's packets, spoilt before they are written.
template <PandarDriver driver, typename Spoil>
WriteCloud hesai_packets_with(const Spoil& spoil) {
  return with([spoil](const PointCloud2& cloud) {
    auto message = hesai_turn_of(cloud).message<driver>();
    spoil(message);
    return message;
  });
}

TEST_F(InputForms, HesaiPacketsOfBothDrivers) {
  const auto as_they_are = [](auto&) {};
  const std::string packets =
      written("hesai_lidar", hesai_packets_with<PandarDriver::kHesaiLidar>(as_they_are));
  const Trajectory plain = mapped(
      written("clouds", with([](const PointCloud2& cloud) { return hesai_turn_of(cloud).cloud; })));
  expect_equal_poses(mapped(packets), plain);
  expect_equal_poses(
      mapped(written("pandar_msgs", hesai_packets_with<PandarDriver::kPandarMsgs>(as_they_are))),
      plain);
  expect_said(checked(packets), "225 packets of a Hesai PandarXT-16", 0);
  EXPECT_TRUE(has_said("times in `packets` (us, absolute) from -0.0003 to 0.0996"));
}

TEST_F(InputForms, DamagedHesaiPacketsAreNamed) {
  constexpr PandarDriver kDriver = PandarDriver::kHesaiLidar;
  const auto said = [&](const std::string& name, const auto& spoil) {
    return checked(written(name, hesai_packets_with<kDriver>(spoil)));
  };
  expect_said(said("none", [](auto& m) { m.packets.clear(); }),
              "clouds cannot be read, first a scan of a Hesai holds no packets", 1);
  expect_said(said("some", [](auto& m) { m.packets[3].data[0] = 0; }),
              "packets of the sensor are damaged", 1);
  expect_said(said("other",
                   [](auto& m) {
                     for (auto& packet : m.packets) packet.data.resize(820);
                   }),
              "packets of 820 bytes (protocol 6.1, 16 lasers) are not read", 1);
  expect_said(said("calibration",
                   [](auto& m) {
                     m.packets.emplace_back(ros::Time(),
                                            test::hesai_calibration_packet("1,two,3\n"));
                   }),
              "the calibration in a scan of a Hesai, line 1: 'two' is no finite number", 1);
}

TEST_F(InputForms, ACalibrationOfAHesaiGoesOverTheNominalAngles) {
  const std::string packets =
      written("packets", hesai_packets_with<PandarDriver::kPandarMsgs>([](auto&) {}));
  const std::string file = folder_.path() / "lasers.csv";
  std::ofstream(file) << "Channel,Elevation,Azimuth\n1,15,zero\n";
  const std::string parameter = "preprocessing/hesai_calibration: " + file;
  EXPECT_EQ(run("map_bag", {packets, "-o", folder_.path() / "none", "--parameter", parameter}), 1);
  EXPECT_TRUE(has_said(file + ", line 2: 'zero' is no finite number"));
  std::ofstream nominal(file);
  for (int i = 0; i < 16; ++i) nominal << i + 1 << ',' << 15 - 2 * i << ",0\n";
  nominal.close();
  expect_equal_poses(mapped(packets, {"--parameter", parameter}), mapped(packets));
}

/// Where both are recorded, the clouds of a driver without times give way to the packets.
TEST_F(InputForms, PacketsGoBeforeCloudsWithoutTimes) {
  const auto both = [](rosbag::Bag& to, const ros::Time& recorded, const PointCloud2& cloud) {
    const test::VelodyneTurn turn = turn_of(cloud);
    PointCloud2 untimed = turn.cloud;
    untimed.fields.back().name = "ring";
    to.write("/velodyne_packets", recorded, turn.packets);
    to.write("/velodyne_points", recorded, untimed);
  };
  expect_said(checked(written("both", both)), "points    /velodyne_packets:", 0);
}

using test::VelodyneScanMessage;

/// A recording whose messages are spoilt before they are written.
template <typename Spoil>
WriteCloud packets_with(const Spoil& spoil) {
  return with([spoil](const PointCloud2& cloud) {
    VelodyneScanMessage message = turn_of(cloud).packets;
    spoil(message);
    return message;
  });
}

TEST_F(InputForms, DamagedPacketsAreNamed) {
  const auto said = [&](const std::string& name, const auto& spoil) {
    return checked(written(name, packets_with(spoil)));
  };
  expect_said(said("none", [](VelodyneScanMessage& m) { m.packets.clear(); }),
              "clouds cannot be read, first a scan of a Velodyne holds no packets", 1);
  expect_said(said("flags",
                   [](VelodyneScanMessage& m) {
                     for (auto& packet : m.packets) test::put_number(packet.data, 0, 0, 2);
                   }),
              "all 75 packets of a Velodyne scan are damaged", 1);
  expect_said(
      said("some", [](VelodyneScanMessage& m) { test::put_number(m.packets[3].data, 0, 0, 2); }),
      "packets of the sensor are damaged", 1);
  expect_said(said("product",
                   [](VelodyneScanMessage& m) {
                     for (auto& packet : m.packets) packet.data[1205] = 0x7F;
                   }),
              "unknown Velodyne product 0x7F; name its calibration file", 1);
  expect_said(said("hdl64",
                   [](VelodyneScanMessage& m) {
                     for (auto& packet : m.packets) test::put_number(packet.data, 100, 0xDDFF, 2);
                   }),
              "name the file in velodyne_calibration", 1);
  expect_said(said("half", [](VelodyneScanMessage& m) { m.packets.resize(20); }),
              "the points' times span 0.0266 s, scan_period is 0.1 s", 1);
  expect_said(said("no_returns",
                   [](VelodyneScanMessage& m) {
                     for (auto& packet : m.packets) {
                       for (std::size_t b = 0; b < 12; ++b) {
                         test::put_block(packet.data, b, static_cast<std::uint16_t>(200 * b),
                                         [](std::size_t) { return test::VelodyneReturn{}; });
                       }
                     }
                   }),
              "scans have no points", 1);
}

TEST_F(InputForms, AForeignDefinitionIsNamed) {
  const auto foreign = with([](const PointCloud2& cloud) {
    test::OtherVelodyneScan message;
    message.header = cloud.header;
    return message;
  });
  const std::string bag = written("foreign", foreign);
  const std::string words =
      "/points holds velodyne_msgs/VelodyneScan of another definition (MD5 sum 0000";
  expect_said(checked(bag), words, 1);
  expect_said(checked(bag, {"--points", kTopic}), words, 2);
}

/// Bytes of a serialised message under the name of another, as damaged recordings hold them.
TEST_F(InputForms, CutMessagesAreNamed) {
  const auto cut = [](rosbag::Bag& to, const ros::Time& recorded, const PointCloud2& cloud) {
    topic_tools::ShapeShifter message;
    auto whole = test::as_livox<LivoxDriver::kOne>(cloud);
    std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(whole));
    ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
    ros::serialization::serialize(stream, whole);
    ros::serialization::IStream half(bytes.data(), static_cast<std::uint32_t>(bytes.size() / 2));
    using Livox = test::LivoxMessage<LivoxDriver::kOne>;
    message.morph(ros::message_traits::md5sum<Livox>(), ros::message_traits::datatype<Livox>(),
                  ros::message_traits::definition<Livox>(), "");
    message.read(half);
    to.write(kTopic, recorded, message);
  };
  expect_said(checked(written("cut", cut)),
              "no message on /points (livox_ros_driver/CustomMsg) can be read: they are cut off",
              1);
}

TEST_F(InputForms, EmptyAndBackwardLivoxScansAreNamed) {
  using Livox = test::LivoxMessage<LivoxDriver::kTwo>;
  const auto empty = with([](const PointCloud2& cloud) {
    Livox message = test::as_livox<LivoxDriver::kTwo>(cloud);
    message.points.clear();
    return message;
  });
  expect_said(checked(written("empty", empty)), " scans have no points", 1);
  const auto backwards = [](rosbag::Bag& to, const ros::Time& recorded, const PointCloud2& cloud) {
    static std::int32_t count = 0;
    Livox message = test::as_livox<LivoxDriver::kTwo>(cloud);
    message.header.stamp -= ros::Duration(0, 150'000'000) * static_cast<double>(count++);
    to.write(kTopic, recorded, message);
  };
  expect_said(checked(written("backwards", backwards)), "stamps do not increase", 1);
}

}  // namespace
}  // namespace lidar_mapping::tools
