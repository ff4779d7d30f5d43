// SPDX-License-Identifier: BSD-3-Clause
#include "gnss/gnss_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lidar_mapping::back_end {

namespace {

constexpr int kIterations = 10;  // of reweighting; chosen, each costs one pass over the positions
// Pairs tried, each judged by all positions: bounds the time; chosen.
constexpr std::size_t kMaxPairs = 300;
// Drift deforms a long track by more than the noise of the fixes; the fixes must not be taken for
// outliers because of that. As a fraction of the track's extent; chosen above the usual drift.
constexpr double kTrackDeformation = 0.01;

/// Rotation about the vertical and horizontal shift: p_enu = R(yaw) p_level + shift.
struct PlanarMotion {
  double yaw = 0.0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();

  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const {
    return Eigen::Rotation2Dd(yaw) * p + shift;
  }
};

struct LevelSample {
  Eigen::Vector2d enu;
  Eigen::Vector2d level;
  double stddev;
};

Eigen::Vector2d mean_position(const std::vector<LevelSample>& samples) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const LevelSample& s : samples) sum += s.level;
  return sum / static_cast<double>(samples.size());
}

double track_extent(const std::vector<LevelSample>& samples) {
  Eigen::Array2d low = samples.front().level.array();
  Eigen::Array2d high = low;
  for (const LevelSample& s : samples) {
    low = low.min(s.level.array());
    high = high.max(s.level.array());
  }
  return (high - low).matrix().norm();
}

double normalised_error(const LevelSample& sample, const PlanarMotion& motion) {
  return ((motion * sample.level) - sample.enu).norm() / sample.stddev;
}

std::optional<PlanarMotion> motion_from_pair(const LevelSample& a, const LevelSample& b) {
  const Eigen::Vector2d along_level = b.level - a.level;
  const Eigen::Vector2d along_enu = b.enu - a.enu;
  // Both distances must agree, or one of the fixes is an outlier.
  const double tolerance = 3.0 * (a.stddev + b.stddev);
  if (std::abs(along_level.norm() - along_enu.norm()) > tolerance) return std::nullopt;
  PlanarMotion motion;
  motion.yaw =
      std::atan2(along_enu.y(), along_enu.x()) - std::atan2(along_level.y(), along_level.x());
  motion.shift =
      0.5 * (a.enu + b.enu) - Eigen::Rotation2Dd(motion.yaw) * (0.5 * (a.level + b.level));
  return motion;
}

double truncated_squared_error(const std::vector<LevelSample>& samples,
                               const PlanarMotion& motion) {
  double sum = 0.0;
  for (const LevelSample& s : samples)
    sum += std::min(9.0, std::pow(normalised_error(s, motion), 2));
  return sum;
}

/// The best of the motions from pairs of samples that are half the track apart.
PlanarMotion best_pair_motion(const std::vector<LevelSample>& samples) {
  PlanarMotion best;
  double smallest_error = std::numeric_limits<double>::infinity();
  const std::size_t gap = samples.size() / 2;
  const std::size_t step = std::max<std::size_t>(1, (samples.size() - gap) / kMaxPairs);
  for (std::size_t i = 0; i + gap < samples.size(); i += step) {
    const auto motion = motion_from_pair(samples[i], samples[i + gap]);
    if (!motion) continue;
    const double sum = truncated_squared_error(samples, *motion);
    if (sum >= smallest_error) continue;
    smallest_error = sum;
    best = *motion;
  }
  return best;
}

/// Weighted least squares for heading and shift (Umeyama 1991 in the plane) with weights of the
/// Cauchy kernel.
PlanarMotion refine_weighted(const std::vector<LevelSample>& samples, const PlanarMotion& motion) {
  double weights = 0.0;
  Eigen::Vector2d mean_level = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean_enu = Eigen::Vector2d::Zero();
  std::vector<double> weight_of;
  for (const LevelSample& s : samples) {
    const double weight =
        1.0 / (s.stddev * s.stddev * (1.0 + std::pow(normalised_error(s, motion), 2)));
    weight_of.push_back(weight);
    weights += weight;
    mean_level += weight * s.level;
    mean_enu += weight * s.enu;
  }
  mean_level /= weights;
  mean_enu /= weights;
  double cosine = 0.0;
  double sine = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Eigen::Vector2d a = samples[i].level - mean_level;
    const Eigen::Vector2d b = samples[i].enu - mean_enu;
    cosine += weight_of[i] * a.dot(b);
    sine += weight_of[i] * (a.x() * b.y() - a.y() * b.x());
  }
  PlanarMotion result;
  result.yaw = std::atan2(sine, cosine);
  result.shift = mean_enu - Eigen::Rotation2Dd(result.yaw) * mean_level;
  return result;
}

double heading_stddev(const std::vector<LevelSample>& samples, const PlanarMotion& motion) {
  const Eigen::Vector2d mean = mean_position(samples);
  double information = 0.0;
  for (const LevelSample& s : samples) {
    if (normalised_error(s, motion) > 3.0) continue;
    information += (s.level - mean).squaredNorm() / (s.stddev * s.stddev);
  }
  return 1.0 / std::sqrt(std::max(information, 1e-12));
}

/// Weighted median of the altitude differences: it tolerates outliers in up to half of the
/// altitudes.
double altitude_shift(const std::vector<AlignmentSample>& samples,
                      const Eigen::Quaterniond& R_level_map) {
  std::vector<std::pair<double, double>> shifts;
  double total = 0.0;
  for (const AlignmentSample& s : samples) {
    if (!std::isfinite(s.p_enu.z())) continue;
    const double weight = 1.0 / (s.stddev_altitude * s.stddev_altitude);
    shifts.emplace_back(s.p_enu.z() - (R_level_map * s.p_map).z(), weight);
    total += weight;
  }
  std::sort(shifts.begin(), shifts.end());
  double sum = 0.0;
  for (const auto& [shift, weight] : shifts) {
    sum += weight;
    if (sum >= 0.5 * total) return shift;
  }
  return 0.0;
}

}  // namespace

std::optional<Alignment> align_to_enu(const std::vector<AlignmentSample>& samples,
                                      const Eigen::Quaterniond& R_level_map,
                                      const AlignmentLimits& limits) {
  if (samples.size() < 3) return std::nullopt;
  std::vector<LevelSample> level;
  for (const AlignmentSample& s : samples) {
    level.push_back({s.p_enu.head<2>(), (R_level_map * s.p_map).head<2>(), s.stddev_horizontal});
  }
  const double size = track_extent(level);
  if (size < limits.min_extent) return std::nullopt;
  for (LevelSample& s : level) s.stddev = std::hypot(s.stddev, kTrackDeformation * size);
  PlanarMotion motion = best_pair_motion(level);
  for (int i = 0; i < kIterations; ++i) motion = refine_weighted(level, motion);

  Alignment alignment;
  double squares = 0.0;
  for (const LevelSample& s : level) {
    if (normalised_error(s, motion) > 3.0) continue;
    squares += (motion * s.level - s.enu).squaredNorm();
    ++alignment.inliers;
  }
  if (2 * alignment.inliers < static_cast<int>(level.size())) return std::nullopt;
  if (heading_stddev(level, motion) > limits.max_heading_stddev) return std::nullopt;
  alignment.rms_horizontal = std::sqrt(squares / alignment.inliers);
  alignment.T_enu_map.rotation = exp_so3({0.0, 0.0, motion.yaw}) * R_level_map;
  alignment.T_enu_map.translation << motion.shift, altitude_shift(samples, R_level_map);
  return alignment;
}

}  // namespace lidar_mapping::back_end
