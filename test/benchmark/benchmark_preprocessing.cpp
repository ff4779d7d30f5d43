// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>

#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/outgoing_cloud.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"

// The stage from the message of a 64-beam scan to the synchronised cloud as it is published, to be
// compared with copying the scan's bytes. Both take their scans in turn from as many as the
// argument `scans` says: one stays in the cache, many come from memory.
namespace lidar_mapping {
namespace {

constexpr int kBeams = 64;
constexpr int kColumns = 2000;
constexpr Stamp kBegin = 1317384506000000000;

/// x y z intensity time of a room around the sensor, beam by beam.
sensor_msgs::PointCloud2 scan_message(bool with_times) {
  PointCloud cloud;
  for (int beam = 0; beam < kBeams; ++beam) {
    const double elevation = (2.0 - 26.8 * beam / kBeams) * M_PI / 180.0;
    for (int column = 0; column < kColumns; ++column) {
      const double azimuth = 2.0 * M_PI * column / kColumns;
      const double range = 10.0 + 8.0 * std::sin(3.0 * azimuth);
      cloud.points.push_back({static_cast<float>(range * std::cos(elevation) * std::cos(azimuth)),
                              static_cast<float>(range * std::cos(elevation) * std::sin(azimuth)),
                              static_cast<float>(range * std::sin(elevation)), 0.5F});
      if (with_times) cloud.times.push_back(0.1F * static_cast<float>(column) / kColumns);
    }
  }
  return ros_border::to_message(cloud, kBegin, "lidar");
}

using Message = std::shared_ptr<sensor_msgs::PointCloud2>;
using Messages = std::vector<Message>;

Messages scan_messages(std::int64_t count, bool with_times) {
  Messages messages;
  for (std::int64_t k = 0; k < count; ++k) {
    messages.push_back(std::make_shared<sensor_msgs::PointCloud2>(scan_message(with_times)));
  }
  return messages;
}

constexpr int kHot = 1, kCold = 64;

void copy_bytes(benchmark::State& state) {
  const Messages messages = scan_messages(state.range(0), true);
  std::size_t next = 0;
  for (auto _ : state) {
    std::vector<std::uint8_t> copy(messages[next++ % messages.size()]->data);
    benchmark::DoNotOptimize(copy.data());
  }
}
BENCHMARK(copy_bytes)
    ->ArgName("scans")
    ->Arg(kHot)
    ->Arg(kCold)
    ->Unit(benchmark::kMicrosecond)
    ->MinTime(0.5);

void add_motion(preprocessing::Preprocessor& stage, Stamp from, Stamp to) {
  for (Stamp stamp = from; stamp < to; stamp += 10000000) {
    ImuSample imu;
    imu.stamp = stamp;
    imu.angular_velocity.z() = 0.3;
    imu.linear_acceleration.z() = 9.81;
    stage.add_imu(imu, "imu");
    stage.add_velocity({stamp, {10.0, 0.0, 0.0}, {0.0, 0.0, 0.3}}, "imu");
  }
}

/// `moves`: whether the motion is compensated (points with times, IMU and velocity); `bytes`:
/// whether the publisher's writing of the bytes that it sends is counted.
void message_to_synced_cloud(benchmark::State& state) {
  const bool moves = state.range(0) != 0;
  const bool writes_bytes = state.range(2) != 0;
  const preprocessing::PreprocessingConfig config;
  preprocessing::Preprocessor stage(config, [](const std::string&) { return Pose::Identity(); });
  const Messages messages = scan_messages(state.range(1), moves);
  std::size_t next = 0;
  const Stamp period = 100000000;
  Stamp stamp = kBegin;
  PointCloud spare;
  for (auto _ : state) {
    state.PauseTiming();
    if (moves) add_motion(stage, stamp, stamp + period);
    const Message& message = messages[next++ % messages.size()];
    message->header.stamp = ros_border::to_ros(stamp);
    state.ResumeTiming();
    auto scans =
        stage.process(ros_border::decode_lazily(*message, message, config, std::move(spare)).scan);
    for (auto& scan : stage.flush()) scans.push_back(std::move(scan));
    for (auto& scan : scans) {
      const ros_border::OutgoingCloud sent(scan.scan.cloud, scan.scan.stamp, "base_link");
      if (writes_bytes) {
        benchmark::DoNotOptimize(ros::serialization::serializeMessage(sent).buf.get());
      }
      benchmark::ClobberMemory();
      spare = std::move(scan.scan.cloud);
    }
    stamp += period;
  }
}
BENCHMARK(message_to_synced_cloud)
    ->ArgNames({"moves", "scans", "bytes"})
    ->ArgsProduct({{0, 1}, {kHot, kCold}, {0, 1}})
    ->Unit(benchmark::kMicrosecond)
    ->MinTime(0.5);

}  // namespace
}  // namespace lidar_mapping

BENCHMARK_MAIN();
