// SPDX-License-Identifier: BSD-3-Clause
// Map insertion, one alignment, one whole scan, on a stretch of the simulated town.

#include <vector>

#include <benchmark/benchmark.h>

#include "lidar_mapping/common/voxel_filter.hpp"
#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/registration/gaussian_voxel_map.hpp"
#include "lidar_mapping/registration/registration.hpp"
#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping {
namespace {

using registration::Method;

constexpr std::size_t kFirstScan = 60;  // at speed
constexpr std::size_t kScans = 30;

/// Scans in base_link, and their true poses.
struct Stretch {
  std::vector<Scan> scans;
  std::vector<Pose> T_map_base;
};

const Stretch& stretch() {
  static const Stretch instance = [] {
    simulation::DriveOptions options;
    options.duration = 0.1 * static_cast<double>(kFirstScan + kScans + 2);
    options.undistorted = true;
    const simulation::Drive drive(options);
    Stretch result;
    for (std::size_t i = kFirstScan; i < kFirstScan + kScans; ++i) {
      result.scans.push_back(drive.base_scan(i));
      result.T_map_base.push_back(drive.trajectory().pose(drive.scan_stamp(i)));
    }
    return result;
  }();
  return instance;
}

void insertion(benchmark::State& state) {
  const PointCloud cloud = voxel_filtered(stretch().scans.front().cloud, 0.4);
  std::vector<float> x, y, z;
  for (const Point& p : cloud.points) {
    x.push_back(p.x);
    y.push_back(p.y);
    z.push_back(p.z);
  }
  registration::GaussianVoxelMap map(1.0, 1U << 17);
  for (auto _ : state) map.insert(x.data(), y.data(), z.data(), x.size());
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * x.size()));
}

/// Two scans a few steps apart, from where constant velocity would have put the second one.
void alignment(benchmark::State& state, Method method) {
  const Stretch& s = stretch();
  registration::RegistrationConfig config;
  config.method = method;
  const auto registration = registration::make_registration(config);
  registration->set_target(voxel_filtered(s.scans[0].cloud, 0.3));
  const PointCloud source = voxel_filtered(s.scans[3].cloud, 0.8);
  Pose guess = s.T_map_base[0].inverse() * s.T_map_base[3];
  guess.translation.x() += 0.2;
  for (auto _ : state) benchmark::DoNotOptimize(registration->align(source, guess));
}

/// Time per scan of the whole front end, key frames and map upkeep in it.
void scan(benchmark::State& state, Method method) {
  front_end::FrontEndConfig config;
  config.registration.method = method;
  for (auto _ : state) {
    front_end::FrontEnd front_end(config);
    for (const Scan& scan : stretch().scans) benchmark::DoNotOptimize(front_end.process(scan));
  }
  state.counters["per_scan"] =
      benchmark::Counter(static_cast<double>(state.iterations() * kScans),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void register_all() {
  benchmark::RegisterBenchmark("insertion", insertion);
  for (const Method method :
       {Method::kNdt, Method::kVgicp, Method::kPclNdt, Method::kIcp, Method::kGicp}) {
    const std::string name = registration::to_string(method);
    benchmark::RegisterBenchmark(("alignment/" + name).c_str(), alignment, method)
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(("scan/" + name).c_str(), scan, method)
        ->Unit(benchmark::kMillisecond);
  }
}

}  // namespace
}  // namespace lidar_mapping

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  lidar_mapping::register_all();
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
