// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/simulation/scan_faults.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/random.hpp"

#include "fault_text.hpp"
#include "ray_returns.hpp"

namespace lidar_mapping::simulation {

namespace {

using Kind = ScanFault::Kind;

/// Streams of random numbers, apart from each other.
enum Stream : std::uint64_t {
  kOutlierStream = 1,
  kRainStream,
  kWallStream,
  kJitterStream,
  kThinStream
};

// Drops and spray are seen where the laser is still bright.
constexpr double kNearestDrop = 1.0;   // m
constexpr double kFarthestDrop = 8.0;  // m
constexpr float kDropIntensity = 8.0F;

// A truck with its trailer on the lane to the left, in the LiDAR's frame, m.
constexpr double kTruckSide = 2.5;
constexpr double kTruckHalfLength = 9.0;
constexpr double kTruckBottom = -1.5;
constexpr double kTruckTop = 2.5;
constexpr float kTruckIntensity = 90.0F;

/// Stamps keep their order.
constexpr double kMostJitter = 0.45;        // of a turn
constexpr double kUsualFrozenEvery = 10.0;  // s

struct Description {
  const char* name;
  Kind kind;
  const char* form;
  double least;
  double most;
};
constexpr Description kDescriptions[] = {
    {"outliers", Kind::kOutliers, "outliers=SHARE with a share of the points from 0.001 to 0.9",
     0.001, 0.9},
    {"rain", Kind::kRain, "rain=SHARE with a share of the rays from 0.001 to 0.9", 0.001, 0.9},
    {"wall", Kind::kWall, "wall without a number", 0.0, 0.0},
    {"jitter", Kind::kJitter, "jitter=SECONDS from 0.0001 to 1", 0.0001, 1.0},
    {"frozen", Kind::kFrozen, "frozen=TIMES or frozen=TIMES,EVERY_SECONDS, both 1 or more", 1.0,
     1e6},
    {"sparse", Kind::kSparse, "sparse=POINTS, 1 or more", 1.0, 1e9},
    {"times", Kind::kTimes, "times=none or times=negated", 0.0, 1.0}};

void put(RayReturn& ray, const Eigen::Vector3d& direction, double range, float intensity) {
  const Eigen::Vector3f p = (range * direction).cast<float>();
  ray = {true, {p.x(), p.y(), p.z(), intensity}, 1};
}

void add_wall(std::vector<RayReturn>& rays, const std::vector<Eigen::Vector3d>& directions,
              double range_noise, Random random) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Vector3d& d = directions[i];
    if (d.y() <= 0.0) continue;
    const double range = kTruckSide / d.y();
    const bool hits = std::abs(range * d.x()) < kTruckHalfLength && range * d.z() > kTruckBottom &&
                      range * d.z() < kTruckTop;
    if (!hits || (rays[i].there && rays[i].point.position().norm() < range)) continue;
    put(rays[i], d, range + range_noise * random.normal(), kTruckIntensity);
  }
}

void add_outliers(std::vector<RayReturn>& rays, const std::vector<Eigen::Vector3d>& directions,
                  double share, const LidarModel& lidar, Random random) {
  const auto there = static_cast<double>(
      std::count_if(rays.begin(), rays.end(), [](const RayReturn& ray) { return ray.there; }));
  // So many of all rays, of which some had a return, make up the share of the points.
  const double chance =
      share * there / (static_cast<double>(rays.size()) * (1.0 - share) + share * there);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!random.chance(chance)) continue;
    put(rays[i], directions[i], random.uniform(lidar.min_range, lidar.max_range),
        static_cast<float>(random.integer(0, 255)));
  }
}

void add_rain(std::vector<RayReturn>& rays, const std::vector<Eigen::Vector3d>& directions,
              double share, Random random) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!random.chance(share)) continue;
    const double range = random.uniform(kNearestDrop, kFarthestDrop);
    if (rays[i].there && rays[i].point.position().norm() < range) continue;
    put(rays[i], directions[i], range, kDropIntensity);
  }
}

bool read(const Description& known, const std::optional<std::string>& value, ScanFault& fault) {
  if (known.kind == Kind::kWall) return !value;
  if (!value) return false;
  if (known.kind == Kind::kTimes) {
    fault.amount = *value == "negated" ? 1.0 : 0.0;
    return *value == "none" || *value == "negated";
  }
  const bool is_one = reads(*value, "%lf%n", &fault.amount);
  const bool is_two = known.kind == Kind::kFrozen &&
                      reads(*value, "%lf,%lf%n", &fault.amount, &fault.every_s) &&
                      fault.every_s >= 1.0;
  // Written so that NaN fails.
  return (is_one || is_two) && fault.amount >= known.least && fault.amount <= known.most;
}

/// Keeps `most` points, each with the same chance, in their order.
void thin_out(SimulatedScan& scan, std::size_t most, Random random) {
  std::size_t wanted = most;
  std::size_t kept = 0;
  const std::size_t size = scan.cloud.size();
  if (size <= most) return;
  for (std::size_t i = 0; i < size; ++i) {
    const double chance = static_cast<double>(wanted) / static_cast<double>(size - i);
    if (!random.chance(chance)) continue;
    scan.cloud.points[kept] = scan.cloud.points[i];
    scan.moving[kept] = scan.moving[i];
    scan.rays[kept] = scan.rays[i];
    if (scan.cloud.has_times()) scan.cloud.times[kept] = scan.cloud.times[i];
    ++kept;
    --wanted;
  }
  scan.cloud.points.resize(kept);
  scan.moving.resize(kept);
  scan.rays.resize(kept);
  if (scan.cloud.has_times()) scan.cloud.times.resize(kept);
}

}  // namespace

ScanFault parse_scan_fault(const std::string& text) {
  const auto usual = [](const Description& known) {
    return ScanFault{known.kind, 0.0, kUsualFrozenEvery};
  };
  return parse_fault(text, kDescriptions, usual, read);
}

std::vector<std::string> scan_fault_names() { return fault_names(kDescriptions); }

ScanFaults::ScanFaults(std::vector<ScanFault> faults, std::uint64_t seed)
    : faults_(std::move(faults)), seed_(seed) {}

std::size_t ScanFaults::source(std::size_t index, Stamp period) const {
  for (const ScanFault& fault : faults_) {
    if (fault.kind != Kind::kFrozen) continue;
    const auto every = std::max<std::size_t>(
        1, static_cast<std::size_t>(std::llround(fault.every_s / to_seconds(period))));
    const std::size_t since = index % every;
    // The drive does not begin with it.
    if (index >= every && since <= static_cast<std::size_t>(fault.amount)) return index - since;
  }
  return index;
}

Stamp ScanFaults::stamp_error(std::size_t index, Stamp period) const {
  double seconds = 0.0;
  for (const ScanFault& fault : faults_) {
    if (fault.kind != Kind::kJitter) continue;
    seconds += fault.amount * Random(seed_ ^ mixed(index), kJitterStream).normal();
  }
  const double most = kMostJitter * to_seconds(period);
  return from_seconds(std::clamp(seconds, -most, most));
}

void ScanFaults::spoil(SimulatedScan& scan, std::size_t index, const LidarModel& lidar,
                       double range_noise) const {
  const auto wanted = [this](Kind kind) {
    double amount = -1.0;
    for (const ScanFault& fault : faults_) {
      if (fault.kind == kind) amount = fault.amount;
    }
    return amount;
  };
  const auto stream = [&](Stream which) { return Random(seed_ ^ mixed(index), which); };
  const double outliers = wanted(Kind::kOutliers);
  const double rain = wanted(Kind::kRain);
  const bool has_wall = wanted(Kind::kWall) >= 0.0;
  if (outliers > 0.0 || rain > 0.0 || has_wall) {
    const std::vector<Eigen::Vector3d> directions = ray_directions(lidar, index);
    std::vector<RayReturn> rays = returns_of(scan, lidar);
    if (has_wall) add_wall(rays, directions, range_noise, stream(kWallStream));
    if (outliers > 0.0) add_outliers(rays, directions, outliers, lidar, stream(kOutlierStream));
    if (rain > 0.0) add_rain(rays, directions, rain, stream(kRainStream));
    scan = scan_of(rays, scan, lidar);
  }
  const double most = wanted(Kind::kSparse);
  if (most > 0.0) thin_out(scan, static_cast<std::size_t>(most), stream(kThinStream));
  const double times = wanted(Kind::kTimes);
  if (times == 0.0) scan.cloud.times.clear();
  if (times == 1.0) {
    for (float& time : scan.cloud.times) time = -time;
  }
}

}  // namespace lidar_mapping::simulation
