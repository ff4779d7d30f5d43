// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/evaluation/trajectory_errors.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lidar_mapping/common/path_length.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::evaluation {

namespace {

/// The estimated motion from i to j relative to the true one.
Pose motion_error(const std::vector<PosePair>& pairs, std::size_t i, std::size_t j) {
  const Pose truth = pairs[i].truth.inverse() * pairs[j].truth;
  const Pose estimate = pairs[i].estimate.inverse() * pairs[j].estimate;
  return truth.inverse() * estimate;
}

PoseErrors pose_errors(const std::vector<Pose>& errors) {
  std::vector<double> metres;
  std::vector<double> degrees;
  for (const Pose& error : errors) {
    metres.push_back(error.translation.norm());
    degrees.push_back(rotation_angle(error.rotation) * kDegPerRad);
  }
  return {statistics_of(std::move(metres)), statistics_of(std::move(degrees))};
}

/// First pose that lies at least `length` behind pose `first` on the path; the size if there is
/// none.
std::size_t end_of_segment(const std::vector<double>& distances, std::size_t first, double length) {
  return static_cast<std::size_t>(
      std::lower_bound(distances.begin() + static_cast<std::ptrdiff_t>(first), distances.end(),
                       distances[first] + length) -
      distances.begin());
}

}  // namespace

ErrorStatistics statistics_of(std::vector<double> values) {
  ErrorStatistics result;
  result.count = values.size();
  if (values.empty()) return result;
  std::sort(values.begin(), values.end());
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  const double squares = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
  const auto count = static_cast<double>(values.size());
  result.rmse = std::sqrt(squares / count);
  result.mean = sum / count;
  // Not median() of common/order_statistics.hpp, which takes the greater one of two in the middle:
  // other programs that evaluate trajectories give their mean.
  const std::size_t middle = values.size() / 2;
  result.median =
      values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
  result.max = values.back();
  return result;
}

PoseErrors absolute_pose_error(const std::vector<PosePair>& pairs) {
  std::vector<Pose> errors;
  for (const PosePair& pair : pairs) errors.push_back(pair.truth.inverse() * pair.estimate);
  return pose_errors(errors);
}

PoseErrors relative_pose_error(const std::vector<PosePair>& pairs, double delta_m) {
  const std::vector<double> distances = travelled_distances(pairs);
  std::vector<Pose> errors;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::size_t j = delta_m > 0.0 ? end_of_segment(distances, i, delta_m) : i + 1;
    if (j < pairs.size()) errors.push_back(motion_error(pairs, i, j));
  }
  return pose_errors(errors);
}

KittiErrors kitti_errors(const std::vector<PosePair>& pairs, const std::vector<double>& lengths_m,
                         std::size_t step) {
  const std::vector<double> distances = travelled_distances(pairs);
  KittiErrors result;
  double translation = 0.0;
  double rotation = 0.0;
  for (const double length : lengths_m) {
    const std::size_t before = result.segments;
    for (std::size_t i = 0; i < pairs.size(); i += std::max<std::size_t>(step, 1)) {
      const std::size_t j = end_of_segment(distances, i, length);
      if (j >= pairs.size()) break;
      const Pose error = motion_error(pairs, i, j);
      translation += error.translation.norm() / length;
      rotation += rotation_angle(error.rotation) / length;
      ++result.segments;
    }
    if (result.segments > before) result.lengths_m.push_back(length);
  }
  if (result.segments == 0) return result;
  const auto count = static_cast<double>(result.segments);
  result.translation_percent = 100.0 * translation / count;
  result.rotation_deg_per_100m = 100.0 * kDegPerRad * rotation / count;
  return result;
}

std::vector<double> usual_segment_lengths(const std::vector<PosePair>& pairs) {
  const std::vector<double> distances = travelled_distances(pairs);
  if (distances.empty() || distances.back() < 400.0) return {50.0, 100.0, 150.0, 200.0};
  return {100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0, 800.0};
}

std::vector<double> travelled_distances(const std::vector<PosePair>& pairs) {
  return lidar_mapping::travelled_distances(
      pairs.size(),
      [&](std::size_t i) -> const Eigen::Vector3d& { return pairs[i].truth.translation; });
}

}  // namespace lidar_mapping::evaluation
