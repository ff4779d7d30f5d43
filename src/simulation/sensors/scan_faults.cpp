// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/simulation/scan_faults.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/random.hpp"

#include "sensors/fault_text.hpp"

namespace lidar_mapping::simulation {

namespace {

using Kind = ScanFault::Kind;

/// Independent streams of random numbers.
enum Stream : std::uint64_t {
  kOutlierStream = 1,
  kRainStream,
  kWallStream,
  kJitterStream,
  kSubsetStream
};

// Drops and spray are measured at distances where the laser is bright. Chosen; they are faint (8 of
// 255).
constexpr double kMinDropRange = 1.0;  // m
constexpr double kMaxDropRange = 8.0;  // m
constexpr float kDropIntensity = 8.0F;

// A truck with a trailer on the lane to the left, in the frame of the LiDAR, m: 18 m long and 4 m
// high, chosen as about what European law allows, and bright (intensity of 255).
constexpr double kTruckSide = 2.5;
constexpr double kTruckHalfLength = 9.0;
constexpr double kTruckBottom = -1.5;
constexpr double kTruckTop = 2.5;
constexpr float kTruckIntensity = 90.0F;

constexpr double kMaxJitter = 0.45;  // of a turn; chosen below a half: stamps stay in their order
constexpr double kDefaultFrozenPeriod = 10.0;  // s; chosen: several of them per drive

using Description = FaultDescription<Kind>;
constexpr Description kDescriptions[] = {
    {"outliers", Kind::kOutliers,
     "outliers=FRACTION with a fraction of the points from 0.001 to 0.9", 0.001, 0.9},
    {"rain", Kind::kRain, "rain=FRACTION with a fraction of the rays from 0.001 to 0.9", 0.001,
     0.9},
    {"wall", Kind::kWall, "wall without a number", 0.0, 0.0},
    {"jitter", Kind::kJitter, "jitter=SECONDS from 0.0001 to 1", 0.0001, 1.0},
    {"frozen", Kind::kFrozen, "frozen=TIMES or frozen=TIMES,EVERY_SECONDS, both 1 or more", 1.0,
     1e6},
    {"sparse", Kind::kSparse, "sparse=POINTS, 1 or more", 1.0, 1e9},
    {"times", Kind::kTimes, "times=none or times=negated", 0.0, 1.0}};

/// Return of one ray of a frame.
struct RayReturn {
  bool is_valid = false;
  Point point;  ///< Point in the frame of the LiDAR, m.
  std::uint8_t moving = 0;
};

/// A scan as a table with one entry per ray, in the order of ray_directions().
std::vector<RayReturn> returns_of(const SimulatedScan& scan, const LidarModel& lidar) {
  std::vector<RayReturn> returns(lidar.ray_count());
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    returns[scan.rays[i]] = {true, scan.cloud.points[i], scan.moving[i]};
  }
  return returns;
}

/// Converts such a table to a scan with the stamps of `scan`.
SimulatedScan scan_of(const std::vector<RayReturn>& returns, const SimulatedScan& scan,
                      const LidarModel& lidar) {
  const auto beams = static_cast<std::size_t>(lidar.beams);
  SimulatedScan result;
  result.stamp = scan.stamp;
  result.end = scan.end;
  for (std::size_t i = 0; i < returns.size(); ++i) {
    if (!returns[i].is_valid) continue;
    result.cloud.points.push_back(returns[i].point);
    result.moving.push_back(returns[i].moving);
    result.rays.push_back(static_cast<std::uint32_t>(i));
    if (!scan.cloud.has_times()) continue;
    const Stamp delay = column_delay(lidar, scan.end - scan.stamp, static_cast<int>(i / beams));
    result.cloud.times.push_back(static_cast<float>(to_seconds(delay)));
  }
  return result;
}

std::size_t count_valid(const std::vector<RayReturn>& rays) {
  return static_cast<std::size_t>(
      std::count_if(rays.begin(), rays.end(), [](const RayReturn& ray) { return ray.is_valid; }));
}

void set_return(RayReturn& ray, const Eigen::Vector3d& direction, double range, float intensity) {
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
    if (!hits || (rays[i].is_valid && rays[i].point.position().norm() < range)) continue;
    set_return(rays[i], d, range + range_noise * random.normal(), kTruckIntensity);
  }
}

void add_outliers(std::vector<RayReturn>& rays, const std::vector<Eigen::Vector3d>& directions,
                  double fraction, const LidarModel& lidar, Random random) {
  const auto valid_returns = static_cast<double>(count_valid(rays));
  // The probability for each ray such that the artificial points are this fraction of all points,
  // because some of them replace returns.
  const double chance =
      fraction * valid_returns /
      (static_cast<double>(rays.size()) * (1.0 - fraction) + fraction * valid_returns);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!random.chance(chance)) continue;
    const auto intensity = static_cast<float>(random.integer(0, 255));
    const double range = random.uniform(lidar.min_range, lidar.max_range);
    set_return(rays[i], directions[i], range, intensity);
  }
}

void add_rain(std::vector<RayReturn>& rays, const std::vector<Eigen::Vector3d>& directions,
              double fraction, Random random) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!random.chance(fraction)) continue;
    const double range = random.uniform(kMinDropRange, kMaxDropRange);
    if (rays[i].is_valid && rays[i].point.position().norm() < range) continue;
    set_return(rays[i], directions[i], range, kDropIntensity);
  }
}

/// Keeps `max` returns, which are drawn at random.
void keep_random_subset(std::vector<RayReturn>& rays, std::size_t max, Random random) {
  std::size_t candidates = count_valid(rays);
  std::size_t remaining = max;
  if (candidates <= max) return;
  for (RayReturn& ray : rays) {
    if (!ray.is_valid) continue;
    ray.is_valid =
        random.chance(static_cast<double>(remaining) / static_cast<double>(candidates--));
    if (ray.is_valid) --remaining;
  }
}

bool read(const Description& known, const std::optional<std::string>& value, ScanFault& fault) {
  fault.every_s = kDefaultFrozenPeriod;
  if (known.kind == Kind::kWall) return !value;
  if (!value) return false;
  if (known.kind == Kind::kTimes) {
    fault.amount = *value == "negated" ? 1.0 : 0.0;
    return *value == "none" || *value == "negated";
  }
  double* const every_s = known.kind == Kind::kFrozen ? &fault.every_s : nullptr;
  return read_numbers(*value, known, fault.amount, every_s) && fault.every_s >= 1.0;
}

}  // namespace

ScanFault parse_scan_fault(const std::string& text) {
  return parse_fault<ScanFault>(text, kDescriptions, read);
}

std::vector<std::string> scan_fault_formats() { return fault_formats(kDescriptions); }

ScanFaults::ScanFaults(std::vector<ScanFault> faults, std::uint64_t seed)
    : faults_(std::move(faults)), seed_(seed) {}

std::size_t ScanFaults::source(std::size_t index, Stamp period) const {
  for (const ScanFault& fault : faults_) {
    if (fault.kind != Kind::kFrozen) continue;
    const auto every = std::max<std::size_t>(
        1, static_cast<std::size_t>(std::llround(fault.every_s / to_seconds(period))));
    const std::size_t repetition = index % every;
    // The drive does not begin with a repeated scan.
    if (index >= every && repetition <= static_cast<std::size_t>(fault.amount))
      return index - repetition;
  }
  return index;
}

Stamp ScanFaults::stamp_error(std::size_t index, Stamp period) const {
  double seconds = 0.0;
  for (const ScanFault& fault : faults_) {
    if (fault.kind != Kind::kJitter) continue;
    seconds += fault.amount * Random(seed_ ^ mix64(index), kJitterStream).normal();
  }
  const double max = kMaxJitter * to_seconds(period);
  return from_seconds(std::clamp(seconds, -max, max));
}

void ScanFaults::corrupt(SimulatedScan& scan, std::size_t index, const LidarModel& lidar,
                         double range_noise) const {
  const auto amount_of = [this](Kind kind) {
    double amount = -1.0;
    for (const ScanFault& fault : faults_) {
      if (fault.kind == kind) amount = fault.amount;
    }
    return amount;
  };
  const auto stream = [&](Stream which) { return Random(seed_ ^ mix64(index), which); };
  const double outliers = amount_of(Kind::kOutliers);
  const double rain = amount_of(Kind::kRain);
  const double sparse = amount_of(Kind::kSparse);
  const bool has_wall = amount_of(Kind::kWall) >= 0.0;
  if (outliers > 0.0 || rain > 0.0 || sparse > 0.0 || has_wall) {
    const std::vector<Eigen::Vector3d> directions = ray_directions(lidar, index);
    std::vector<RayReturn> rays = returns_of(scan, lidar);
    if (has_wall) add_wall(rays, directions, range_noise, stream(kWallStream));
    if (outliers > 0.0) add_outliers(rays, directions, outliers, lidar, stream(kOutlierStream));
    if (rain > 0.0) add_rain(rays, directions, rain, stream(kRainStream));
    if (sparse > 0.0) {
      keep_random_subset(rays, static_cast<std::size_t>(sparse), stream(kSubsetStream));
    }
    scan = scan_of(rays, scan, lidar);
  }
  const double times = amount_of(Kind::kTimes);
  if (times == 0.0) scan.cloud.times.clear();
  if (times == 1.0) {
    for (float& time : scan.cloud.times) time = -time;
  }
}

}  // namespace lidar_mapping::simulation
