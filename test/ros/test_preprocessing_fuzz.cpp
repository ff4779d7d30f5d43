// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"

#include "cloud_builder.hpp"
#include "clouds/point_fields.hpp"

// Random and truncated messages through decoder and stage. FUZZ_SECONDS lets it run longer, for
// instance with -fsanitize=address,undefined.
namespace lidar_mapping::ros_border {
namespace {

/// The coordinates come first.
std::vector<const char*> field_names_of_drivers() {
  std::vector<const char*> names = {"x", "y", "z", "ring", "time_nsec"};
  names.insert(names.end(), kIntensityNames.begin(), kIntensityNames.end());
  names.insert(names.end(), kTimeNames.begin(), kTimeNames.end());
  return names;
}

class Fuzz {
 public:
  explicit Fuzz(std::uint32_t seed) : engine_(seed) {}

  std::uint32_t below(std::uint32_t limit) { return static_cast<std::uint32_t>(engine_() % limit); }
  bool chance(int in) { return below(static_cast<std::uint32_t>(in)) == 0; }

  /// Mostly plausible, sometimes anything.
  double number() {
    static const double kOdd[] = {0.0,
                                  -0.0,
                                  1e300,
                                  -1e300,
                                  1e-310,
                                  std::numeric_limits<double>::quiet_NaN(),
                                  std::numeric_limits<double>::infinity(),
                                  -std::numeric_limits<double>::infinity()};
    if (chance(8)) return kOdd[below(8)];
    return std::uniform_real_distribution<double>(-100.0, 100.0)(engine_);
  }

  ros::Time stamp() {
    if (chance(50)) return ros::Time(below(4000000000U), below(999999999U));
    now_ += 0.001 * below(200);
    if (chance(100)) now_ -= 5.0;
    return ros::Time(now_);
  }

  std::string frame() {
    static const char* const kFrames[] = {"lidar", "/lidar", "", "nowhere"};
    return kFrames[chance(10) ? below(4) : 0];
  }

  sensor_msgs::PointCloud2 cloud() {
    static const std::vector<const char*> kNames = field_names_of_drivers();
    std::vector<test::FieldLayout> fields;
    std::uint32_t offset = 0;
    const std::uint32_t count = 3 + below(6);
    for (std::uint32_t f = 0; f < count; ++f) {
      const bool plain = f < 3 && !chance(30);
      fields.push_back({kNames[plain ? f : below(static_cast<std::uint32_t>(kNames.size()))],
                        static_cast<std::uint8_t>(plain ? 7 : below(chance(20) ? 256 : 11)),
                        chance(40) ? static_cast<std::uint32_t>(engine_()) : offset});
      offset += plain ? 4 : 1 + below(8);
    }
    auto message = test::cloud_with(fields, std::max(offset, 1U) + below(4), below(300), stamp());
    message.header.frame_id = frame();
    for (auto& byte : message.data) byte = static_cast<std::uint8_t>(engine_());
    if (!chance(3)) fill_with_points(message);
    if (chance(10)) message.data.resize(below(static_cast<std::uint32_t>(message.data.size()) + 1));
    if (chance(30)) message.width = static_cast<std::uint32_t>(engine_());
    if (chance(30)) message.height = below(5);
    if (chance(30)) message.row_step = static_cast<std::uint32_t>(engine_());
    if (chance(30)) message.point_step = below(40);
    message.is_bigendian = chance(50);
    return message;
  }

  sensor_msgs::Imu imu() {
    sensor_msgs::Imu message;
    message.header.stamp = stamp();
    message.header.frame_id = frame();
    for (double* value :
         {&message.angular_velocity.x, &message.angular_velocity.y, &message.linear_acceleration.z,
          &message.orientation.x, &message.orientation.w, &message.orientation_covariance[0]}) {
      *value = number();
    }
    return message;
  }

  geometry_msgs::TwistStamped velocity() {
    geometry_msgs::TwistStamped message;
    message.header.stamp = stamp();
    message.header.frame_id = frame();
    message.twist.linear.x = number();
    message.twist.angular.z = number();
    return message;
  }

  sensor_msgs::NavSatFix fix() {
    sensor_msgs::NavSatFix message;
    message.header.stamp = stamp();
    message.header.frame_id = frame();
    message.latitude = number();
    message.longitude = number();
    message.altitude = number();
    message.status.status = static_cast<std::int8_t>(static_cast<int>(below(5)) - 1);
    message.position_covariance_type = static_cast<std::uint8_t>(below(4));
    for (double& value : message.position_covariance) value = number();
    return message;
  }

 private:
  void fill_with_points(sensor_msgs::PointCloud2& message) {
    for (std::size_t i = 0; i < message.width && message.point_step >= 12; ++i) {
      for (std::uint32_t axis = 0; axis < 3; ++axis) {
        test::put(message, i, 4 * axis, static_cast<float>(number()));
      }
    }
  }

  std::mt19937 engine_;
  double now_ = 1e9;
};

double seconds_to_run() {
  const char* wanted = std::getenv("FUZZ_SECONDS");
  return wanted == nullptr ? 0.0 : std::atof(wanted);
}

/// What went in and what came of it.
struct Tally {
  std::size_t clouds = 0;
  std::size_t unreadable = 0;
};

void feed(Fuzz& fuzz, preprocessing::Preprocessor& stage,
          const preprocessing::PreprocessingConfig& config, Tally& tally) {
  const auto check = [](const std::vector<preprocessing::SyncedScan>& scans) {
    for (const auto& scan : scans) {
      for (const Point& p : scan.scan.cloud.points) ASSERT_TRUE(p.position().allFinite());
      if (scan.gnss) {
        ASSERT_TRUE(scan.gnss->p_enu_antenna.allFinite());
      }
    }
  };
  try {
    switch (fuzz.below(4)) {
      case 0: {
        ++tally.clouds;
        const auto message = std::make_shared<sensor_msgs::PointCloud2>(fuzz.cloud());
        check(stage.process(decode_lazily(*message, message, config).scan));
        break;
      }
      case 1: {
        const auto message = fuzz.imu();
        stage.add_imu(from_message(message), message.header.frame_id);
        break;
      }
      case 2: {
        const auto message = fuzz.velocity();
        stage.add_velocity(from_message(message), message.header.frame_id);
        break;
      }
      default: {
        const auto message = fuzz.fix();
        stage.add_gnss(from_message(message), message.header.frame_id);
      }
    }
    check(stage.take_complete());
  } catch (const InputError&) {
    ++tally.unreadable;
  }
}

TEST(PreprocessingFuzz, SurvivesAnythingAndCountsEveryDrop) {
  const ros::WallTime begin = ros::WallTime::now();
  constexpr int kMessages = 3000;  // of a seed
  std::uint32_t seed = 1;
  std::size_t clouds = 0, unreadable = 0, taken = 0, handed_on = 0, refused = 0;
  do {
    Fuzz fuzz(seed);
    preprocessing::PreprocessingConfig config;
    config.point_times = static_cast<preprocessing::PointTimes>(fuzz.below(3));
    config.downsample_method = static_cast<preprocessing::DownsampleMethod>(fuzz.below(3));
    preprocessing::Preprocessor stage(config, [](const std::string& frame) {
      return frame == "lidar" ? std::optional<Pose>(Pose::Identity()) : std::nullopt;
    });
    Tally tally;
    for (int i = 0; i < kMessages; ++i) feed(fuzz, stage, config, tally);
    stage.flush();
    const auto& counters = stage.counters();
    EXPECT_EQ(counters.scans_in, counters.scans_out + counters.scans_without_extrinsic +
                                     counters.scans_without_points + counters.scans_out_of_order +
                                     counters.scans_discarded)
        << "seed " << seed;
    EXPECT_LE(counters.scans_in, tally.clouds) << "seed " << seed;
    EXPECT_GT(tally.unreadable, 0U);
    clouds += tally.clouds;
    unreadable += tally.unreadable;
    taken += counters.scans_in;
    handed_on += counters.scans_out;
    refused += counters.samples_refused + counters.gnss_refused;
    ++seed;
  } while (seed <= 4 || (ros::WallTime::now() - begin).toSec() < seconds_to_run());
  std::printf(
      "%u seeds, %u messages: %zu clouds, %zu scans taken, %zu handed on; %zu messages not "
      "readable, %zu samples and fixes refused\n",
      seed - 1, (seed - 1) * kMessages, clouds, taken, handed_on, unreadable, refused);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
