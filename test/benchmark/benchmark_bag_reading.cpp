// SPDX-License-Identifier: BSD-3-Clause
// Reading all messages of a bag: this package's reader beside that of rosbag.
//   BAG=drive.bag benchmark_bag_reading
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/ros/bag_set.hpp"
#include "lidar_mapping/ros/recorded_cloud.hpp"

namespace lidar_mapping::ros_border {
namespace {

std::string path() {
  const char* given = std::getenv("BAG");
  return given != nullptr ? given : "";
}

/// Reads every message, and takes the clouds apart, as map_bag does before it decodes points.
void bag_stream(benchmark::State& state) {
  std::size_t points = 0;
  for (auto _ : state) {
    const BagSet bags({path()});
    std::vector<std::string> topics;
    for (const BagTopic& topic : bags.topics()) topics.push_back(topic.name);
    BagStream stream = bags.messages_of(topics);
    while (const auto message = stream.next()) {
      if (const auto cloud = read_cloud(*message)) points += cloud->message.width;
    }
  }
  benchmark::DoNotOptimize(points);
}

/// The same with rosbag, which copies each cloud.
void rosbag_view(benchmark::State& state) {
  std::size_t points = 0;
  for (auto _ : state) {
    rosbag::Bag bag(path(), rosbag::bagmode::Read);
    for (const rosbag::MessageInstance& message : rosbag::View(bag)) {
      const auto cloud = message.instantiate<sensor_msgs::PointCloud2>();
      if (cloud) points += cloud->width;
    }
  }
  benchmark::DoNotOptimize(points);
}

BENCHMARK(bag_stream)->Unit(benchmark::kMillisecond);
BENCHMARK(rosbag_view)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lidar_mapping::ros_border

int main(int argc, char** argv) {
  if (std::getenv("BAG") == nullptr) {
    std::fprintf(stderr,
                 "benchmark_bag_reading: no bag; use BAG=drive.bag benchmark_bag_reading\n");
    return 2;
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
