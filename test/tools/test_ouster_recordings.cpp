// SPDX-License-Identifier: BSD-3-Clause
// A drive as the packets of an Ouster: the poses have to be those of the clouds that they stand
// for.
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>

#include "input_forms.hpp"
#include "mcap_writer.hpp"
#include "ouster_messages.hpp"

namespace lidar_mapping::tools {
namespace {

using sensor_msgs::PointCloud2;
using test::OusterPacketMessage;
using test::OusterSweep;
using test::OusterSweepWriter;

constexpr char kLidar[] = "/ouster/lidar_packets", kImu[] = "/ouster/imu_packets";

class OusterRecordings : public test::InputForms {
 protected:
  /// A sensor whose driver's frames have their places where those of the simulated sensors are.
  static tf2_msgs::TFMessage with_frames_of_the_driver(tf2_msgs::TFMessage message) {
    for (std::size_t i = message.transforms.size(); i-- > 0;) {
      geometry_msgs::TransformStamped transform = message.transforms[i];
      if (transform.child_frame_id == "imu_link") {
        transform.child_frame_id = "os_imu";
        message.transforms.push_back(transform);
      } else if (transform.child_frame_id == "velo_link") {
        transform.child_frame_id = "os_lidar";
        auto& q = transform.transform.rotation;
        const Eigen::Quaterniond backwards =
            Eigen::Quaterniond(q.w, q.x, q.y, q.z) * Eigen::Quaterniond(0.0, 0.0, 0.0, 1.0);
        q.w = backwards.w();
        q.x = backwards.x();
        q.y = backwards.y();
        q.z = backwards.z();
        message.transforms.push_back(transform);
      }
    }
    return message;
  }

  enum class Form { kClouds, kPackets, kPacketsWithoutMetadata };
  struct Clock {
    std::int64_t ahead = 0;              ///< of the recording, ns
    std::int64_t transport = 2'000'000;  ///< ns from a packet's end to its recording
  };

  /// The drive as packets of this profile, or as the clouds that these stand for.
  template <typename Write>
  static bool write(const rosbag::MessageInstance& m, const std::string& profile, Form form,
                    const Clock& clock, std::uint16_t& frame, const Write& write) {
    const auto recorded = [&](const ros::Time& end) {
      return end + ros::Duration().fromNSec(clock.transport);
    };
    if (const auto frames = m.instantiate<tf2_msgs::TFMessage>()) {
      write(m.getTopic(), m.getTime(), with_frames_of_the_driver(*frames));
    } else if (const auto imu = m.instantiate<sensor_msgs::Imu>()) {
      const ros::Time at = recorded(imu->header.stamp);
      if (form == Form::kClouds) write(kImu, at, plain_imu(*imu));
      if (form != Form::kClouds) write(kImu, at, imu_packet(*imu, clock.ahead));
    } else if (const auto cloud = m.instantiate<PointCloud2>()) {
      const OusterSweepWriter writer(*cloud, profile);
      if (frame == kFirstFrame && form == Form::kPackets) {
        std_msgs::String metadata;
        metadata.data = writer.sensor().metadata();
        write("/ouster/metadata", cloud->header.stamp, metadata);
      }
      const OusterSweep sweep = writer.write(frame++, clock.ahead);
      if (form == Form::kClouds) {
        write(kLidar, m.getTime(), sweep.cloud);
      } else {
        for (const auto& [end, packet] : sweep.packets) write(kLidar, recorded(end), packet);
      }
    } else {
      return false;
    }
    return true;
  }
  std::string recorded(const std::string& name, const std::string& profile, Form form,
                       const Clock& clock, bool has_others = true) const {
    std::uint16_t frame = kFirstFrame;
    return rewritten(name, [&](rosbag::Bag& to, const rosbag::MessageInstance& m) {
      const auto copy = [&](const std::string& topic, const ros::Time& time, const auto& message) {
        to.write(topic, time, message);
      };
      return write(m, profile, form, clock, frame, copy) || !has_others;
    });
  }
  std::string recorded(const std::string& name, const std::string& profile, Form form) const {
    return recorded(name, profile, form, {});
  }

  static constexpr std::uint16_t kFirstFrame = 65530;  // it begins anew within the drive

 private:
  static sensor_msgs::Imu plain_imu(sensor_msgs::Imu imu) {
    imu.header.frame_id = "os_imu";
    imu.orientation_covariance[0] = -1.0;
    return imu;
  }
  static OusterPacketMessage imu_packet(const sensor_msgs::Imu& imu, std::int64_t ahead) {
    const auto& a = imu.linear_acceleration;
    const auto& w = imu.angular_velocity;
    const auto time = static_cast<std::int64_t>(imu.header.stamp.toNSec()) + ahead;
    return {test::ouster_imu_packet(static_cast<std::uint64_t>(time),
                                    Eigen::Vector3d(a.x, a.y, a.z) / kStandardGravity,
                                    Eigen::Vector3d(w.x, w.y, w.z) * kDegPerRad)};
  }
};

TEST_F(OusterRecordings, PacketsOfAllProfilesGiveThePosesOfTheClouds) {
  for (const char* profile : {"LEGACY", "RNG19_RFL8_SIG16_NIR16", "RNG19_RFL8_SIG16_NIR16_DUAL"}) {
    SCOPED_TRACE(profile);
    const Trajectory plain = mapped(recorded("clouds", profile, Form::kClouds));
    const std::string packets = recorded("packets", profile, Form::kPackets);
    expect_equal_poses(mapped(packets), plain);
    expect_said(checked(packets), "points    /ouster/lidar_packets: 10.0 Hz, frame os_lidar", 0);
    EXPECT_TRUE(has_said("imu       /ouster/imu_packets: 100.0 Hz, frame os_imu"));
  }
}

TEST_F(OusterRecordings, AClockOfItsOwnIsBroughtToThatOfTheRecording) {
  const std::string profile = "RNG19_RFL8_SIG16_NIR16";
  const Trajectory plain = mapped(recorded("clouds", profile, Form::kClouds));
  Clock clock;
  clock.ahead = 37'000'000'000;  // atomic time, as PTP has it
  expect_equal_poses(mapped(recorded("ptp", profile, Form::kPackets, clock)), plain);
  clock.ahead = -1'300'000'000'000'000'000 + 123'456'789;  // it began when it was switched on
  clock.transport = 0;
  expect_equal_poses(mapped(recorded("own", profile, Form::kPackets, clock)), plain);
}

TEST_F(OusterRecordings, PacketsOfRos2) {
  const std::string profile = "RNG19_RFL8_SIG16_NIR16";
  const std::string path = folder_.path() / "packets.mcap";
  std::uint16_t frame = kFirstFrame;
  {
    test::McapWriter out(path);
    const rosbag::Bag in(drive(), rosbag::bagmode::Read);
    for (const rosbag::MessageInstance& m : rosbag::View(in)) {
      write(m, profile, Form::kPackets, {}, frame,
            [&](const std::string& topic, const ros::Time& time, const auto& message) {
              out.add(topic, time, message);
            });
    }
  }
  expect_equal_poses(mapped(path), mapped(recorded("clouds", profile, Form::kClouds, {}, false)));
}

TEST_F(OusterRecordings, WhatCannotBeReadIsNamed) {
  const std::string profile = "RNG19_RFL8_SIG16_NIR16";
  expect_said(checked(recorded("bare", profile, Form::kPacketsWithoutMetadata)),
              "record the driver's topic metadata beside them", 1);
  const auto with_metadata = [&](const std::string& name, const std::string& text) {
    const std::string from = recorded("from_" + name, profile, Form::kPackets);
    const std::string to = folder_.path() / (name + ".bag");
    test::rewrite_bag(from, to, [&](rosbag::Bag& out, const rosbag::MessageInstance& m) {
      auto metadata = m.instantiate<std_msgs::String>();
      if (!metadata) return false;
      metadata->data = text;
      out.write(m.getTopic(), m.getTime(), *metadata);
      return true;
    });
    return checked(to);
  };
  expect_said(with_metadata("json", "{ nothing"), "they are no JSON", 1);
  expect_said(with_metadata("keys", "{\"beam_intrinsics\": {}}"), "they have no lidar_data_format",
              1);
  test::OusterSensor sensor;
  sensor.profile = "FUSA_RNG15_RFL8_NIR8_DUAL";
  sensor.altitudes_deg = sensor.azimuths_deg = {0.0};
  expect_said(with_metadata("profile", sensor.metadata()),
              "packets of the profile FUSA_RNG15_RFL8_NIR8_DUAL are not read", 1);
  sensor.profile = profile;
  expect_said(with_metadata("other", sensor.metadata()), "bytes, not 256 as its metadata say", 1);
}

}  // namespace
}  // namespace lidar_mapping::tools
