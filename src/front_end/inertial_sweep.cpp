#include "lidar_mapping/front_end/inertial_sweep.hpp"

#include <algorithm>

#include <Eigen/LU>

#include "lidar_mapping/common/parallel.hpp"
#include "lidar_mapping/front_end/motion_filter.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr std::size_t kGrain = 16384;

using Affine = Eigen::Matrix<double, 3, 4>;

Affine matrix_of(const Pose& pose) {
  Affine matrix;
  matrix << pose.rotation_matrix(), pose.translation;
  return matrix;
}

/// As matcher and map move points: exp(s twist) to second order.
Affine placed(const Vector6d& twist, double s) {
  const Eigen::Matrix3d W = skew(twist.tail<3>());
  Affine place;
  place.leftCols<3>() = Eigen::Matrix3d::Identity() + s * W + 0.5 * s * s * W * W;
  place.col(3) = s * twist.head<3>() + 0.5 * s * s * W * twist.head<3>();
  return place;
}

Affine then(const Affine& first, const Affine& second) {
  Affine both = second.leftCols<3>() * first;
  both.col(3) += second.col(3);
  return both;
}

Affine inverse(const Affine& a) {
  Affine result;
  result.leftCols<3>() = a.leftCols<3>().inverse();
  result.col(3) = -result.leftCols<3>() * a.col(3);
  return result;
}

}  // namespace

Pose FollowedMotion::at(double time) const {
  const double last = static_cast<double>(T_reference_base.size() - 1);
  const double position = std::clamp((time - begin) / step, 0.0, last);
  const auto i = std::min(static_cast<std::size_t>(position), T_reference_base.size() - 2);
  return interpolate(T_reference_base[i], T_reference_base[i + 1],
                     position - static_cast<double>(i));
}

InertialSweep::InertialSweep(const FollowedMotion& motion, const Vector6d& twist, double reference)
    : begin_(motion.begin),
      step_(motion.step),
      reference_(reference),
      twist_(twist),
      matched_(twist),
      T_reference_stamp_(motion.at(-reference)) {
  for (std::size_t k = 0; k < motion.T_reference_base.size(); ++k) {
    Pose followed = motion.T_reference_base[k];
    if (!motion.R_seen_moved.empty()) {
      followed.rotation = (followed.rotation * motion.R_seen_moved[k]).normalized();
    }
    const double s = begin_ + step_ * static_cast<double>(k);
    bent_.push_back(then(matrix_of(followed), inverse(placed(twist, s))).cast<float>());
  }
}

InertialSweep::Matrix34 InertialSweep::at(const std::vector<Matrix34>& steps, float time) const {
  const auto last = static_cast<float>(steps.size() - 1);
  const float position =
      std::clamp((time - static_cast<float>(begin_)) / static_cast<float>(step_), 0.0F, last);
  const auto i = std::min(static_cast<std::size_t>(position), steps.size() - 2);
  const float f = position - static_cast<float>(i);
  return steps[i] + f * (steps[i + 1] - steps[i]);
}

void InertialSweep::bend(SampledPoints& points) const {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Matrix34 bent = at(bent_, points.s[i]);
    const Eigen::Vector3f p =
        bent.leftCols<3>() * Eigen::Vector3f(points.x[i], points.y[i], points.z[i]) + bent.col(3);
    points.x[i] = p.x();
    points.y[i] = p.y();
    points.z[i] = p.z();
  }
}

Pose InertialSweep::T_reference_stamp() const {
  const Pose followed = moved(Pose::Identity(), twist_, -reference_);
  const Pose matched = moved(Pose::Identity(), matched_, -reference_);
  return matched * followed.inverse() * T_reference_stamp_;
}

PointCloud InertialSweep::deskewed(PointCloud cloud, int threads) const {
  if (!cloud.has_times()) return cloud;
  const Affine to_stamp = matrix_of(T_reference_stamp().inverse());
  std::vector<Matrix34> steps;
  for (std::size_t k = 0; k < bent_.size(); ++k) {
    const Affine place = placed(matched_, begin_ + step_ * static_cast<double>(k));
    steps.push_back(then(then(bent_[k].cast<double>(), place), to_stamp).cast<float>());
  }
  const auto reference = static_cast<float>(reference_);
  parallel_chunks(cloud.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Point& point = cloud.points[i];
      const Matrix34 step = at(steps, cloud.times[i] - reference);
      const Eigen::Vector3f p =
          step.leftCols<3>() * Eigen::Vector3f(point.x, point.y, point.z) + step.col(3);
      point.x = p.x();
      point.y = p.y();
      point.z = p.z();
    }
  });
  cloud.times = {};
  return cloud;
}

}  // namespace lidar_mapping::front_end
