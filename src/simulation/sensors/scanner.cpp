// SPDX-License-Identifier: BSD-3-Clause
#include "sensors/scanner.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/simulation/random.hpp"

#include "worlds/palette.hpp"

namespace lidar_mapping::simulation {

namespace {

/// Returns are lost at random, more of them on dark, distant and grazed surfaces, most on glass.
/// Chosen: with this signal, at which 1/e are lost, asphalt begins to thin out at some 40 m.
constexpr double kLossAtBest = 0.01;
constexpr double kLossOnGlass = 0.6;
constexpr double kFaintSignal = 2.3e-6;
/// A signal so many times the faint one adds nothing to kLossAtBest, by definition of a double:
/// exp(-45) is less than half of that number's last bit.
constexpr double kFullSignal = 45.0;

/// One beam after the other, not one column after the other as `directions`: the rays of a beam in
/// columns side by side meet the same surfaces, which makes casting them quicker.
std::vector<Ray> make_rays(const ScanRequest& request,
                           const std::vector<Eigen::Vector3d>& directions) {
  std::vector<Ray> rays(directions.size());
  const int beams = request.lidar.beams, columns = request.lidar.columns;
  for (int column = 0; column < columns; ++column) {
    const Stamp delay =
        request.undistorted ? 0 : column_delay(request.lidar, request.period, column);
    const Pose T_map_lidar = request.trajectory.pose(request.stamp + delay) * request.T_base_lidar;
    const Eigen::Matrix3d rotation = T_map_lidar.rotation_matrix();
    for (int beam = 0; beam < beams; ++beam) {
      Ray& ray = rays[beam * columns + column];
      ray.origin = T_map_lidar.translation.cast<float>();
      ray.direction = (rotation * directions[column * beams + beam]).cast<float>();
      ray.time = static_cast<float>(to_seconds(delay) / to_seconds(request.period));
    }
  }
  return rays;
}

bool is_lost(const Hit& hit, Random& random) {
  const double signal =
      (0.1 + hit.reflectivity / 255.0) * hit.cosine / (static_cast<double>(hit.range) * hit.range);
  const double ratio = signal / kFaintSignal;
  const double faintness = ratio > kFullSignal ? 0.0 : std::exp(-ratio);
  const double min_loss = hit.reflectivity == kGlass ? kLossOnGlass : kLossAtBest;
  return random.chance(min_loss + (1.0 - min_loss) * faintness);
}

float measured_intensity(const Hit& hit, Random& random) {
  const double brightness = hit.reflectivity * (0.3 + 0.7 * hit.cosine);
  return static_cast<float>(
      std::clamp(std::round(brightness * (1.0 + 0.05 * random.normal())), 0.0, 255.0));
}

}  // namespace

SimulatedScan take_scan(const ScanRequest& request) {
  const std::vector<Eigen::Vector3d> directions = ray_directions(request.lidar, request.frame);
  const std::vector<Ray> rays = make_rays(request, directions);
  const double begin_s = to_seconds(request.stamp - request.trajectory.begin());
  const double end_s = begin_s + to_seconds(request.period);
  std::vector<Hit> hits;
  const auto min_range = static_cast<float>(request.lidar.min_range);
  request.caster.cast(rays, begin_s, end_s, request.near_objects_occlude ? 0.0F : min_range,
                      static_cast<float>(request.lidar.max_range), hits);

  SimulatedScan scan;
  scan.stamp = request.stamp;
  scan.end = request.stamp + request.period;
  Random random(request.noise_seed);
  scan.cloud.points.reserve(hits.size());
  scan.moving.reserve(hits.size());
  scan.rays.reserve(hits.size());
  if (!request.undistorted) scan.cloud.times.reserve(hits.size());
  const int beams = request.lidar.beams, columns = request.lidar.columns;
  for (int column = 0; column < columns; ++column) {
    const auto time =
        static_cast<float>(to_seconds(column_delay(request.lidar, request.period, column)));
    for (int beam = 0; beam < beams; ++beam) {
      const Hit& hit = hits[beam * columns + column];
      if (hit.range < min_range || is_lost(hit, random)) continue;
      const int ray = column * beams + beam;
      const double range = hit.range + request.range_noise * random.normal();
      const Eigen::Vector3f p_lidar = (range * directions[ray]).cast<float>();
      scan.cloud.points.push_back(
          {p_lidar.x(), p_lidar.y(), p_lidar.z(), measured_intensity(hit, random)});
      scan.moving.push_back(hit.moving ? 1 : 0);
      scan.rays.push_back(static_cast<std::uint32_t>(ray));
      if (!request.undistorted) scan.cloud.times.push_back(time);
    }
  }
  return scan;
}

}  // namespace lidar_mapping::simulation
