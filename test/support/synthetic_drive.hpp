// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::test {

/// A drive round a town block, twice, with odometry that drifts.
struct DriveSettings {
  int laps = 2;
  double side = 100.0;   ///< m, of the square block
  double hill = 3.0;     ///< m, height of the street's swell
  double spacing = 1.0;  ///< m between key frames
  double speed = 10.0;   ///< m/s
  double odometry_stddev_m = 0.01;
  double odometry_stddev_deg = 0.01;
  double scale_error = 0.002;   ///< loops cannot see the size of a block
  double turn_bias_deg = 0.01;  ///< per key frame, about z
  double start_yaw = 0.0;       ///< of the first pose in the true frame
  unsigned seed = 1;
};

/// Key frames with their true poses.
struct SyntheticDrive {
  std::vector<KeyFrame> key_frames;
  std::vector<Pose> truth;  ///< T_enu_base
};

inline Pose square_street(double s, const DriveSettings& settings) {
  const double perimeter = 4.0 * settings.side;
  const double around = std::fmod(s, perimeter);
  const int edge = std::min(3, static_cast<int>(around / settings.side));
  const double along = around - edge * settings.side;
  // Corners of 10 m radius would be closer to a car; turning within 10 m of the edge will do.
  const double blend = std::min(1.0, std::max(0.0, (along - settings.side + 10.0) / 10.0));
  const double yaw = (edge + blend) * M_PI / 2.0;
  const double corner_x[] = {0.0, 1.0, 1.0, 0.0};
  const double corner_y[] = {0.0, 0.0, 1.0, 1.0};
  const double direction = edge * M_PI / 2.0;
  Pose pose;
  pose.rotation = exp_so3({0.0, 0.0, settings.start_yaw + yaw});
  const Eigen::Vector3d flat(corner_x[edge] * settings.side + std::cos(direction) * along,
                             corner_y[edge] * settings.side + std::sin(direction) * along,
                             settings.hill * std::sin(2.0 * M_PI * around / perimeter));
  pose.translation = exp_so3({0.0, 0.0, settings.start_yaw}) * flat;
  return pose;
}

inline Vector6d noise(std::mt19937& engine, double sigma_m, double sigma_rad) {
  std::normal_distribution<double> normal;
  Vector6d d;
  for (int i = 0; i < 6; ++i) d[i] = normal(engine) * (i < 3 ? sigma_m : sigma_rad);
  return d;
}

inline SyntheticDrive make_drive(const DriveSettings& settings = {}) {
  std::mt19937 engine(settings.seed);
  SyntheticDrive drive;
  const int count = static_cast<int>(settings.laps * 4.0 * settings.side / settings.spacing);
  for (int i = 0; i < count; ++i) {
    drive.truth.push_back(square_street(i * settings.spacing, settings));
    KeyFrame key_frame;
    key_frame.index = static_cast<KeyFrameIndex>(i);
    key_frame.stamp = from_seconds(1000.0 + i * settings.spacing / settings.speed);
    key_frame.motion_covariance =
        diagonal_covariance(settings.odometry_stddev_m, settings.odometry_stddev_deg * kRadPerDeg);
    if (i > 0) {
      const std::size_t now = drive.truth.size() - 1;
      Pose motion = drive.truth[now - 1].inverse() * drive.truth[now];
      motion.translation *= 1.0 + settings.scale_error;
      motion = perturbed(motion, noise(engine, settings.odometry_stddev_m,
                                       settings.odometry_stddev_deg * kRadPerDeg));
      motion.rotation = motion.rotation * exp_so3({0.0, 0.0, settings.turn_bias_deg * kRadPerDeg});
      key_frame.T_odom_base = drive.key_frames.back().T_odom_base * motion;
    }
    drive.key_frames.push_back(key_frame);
  }
  return drive;
}

/// A loop between two key frames as matching would find it.
inline Loop make_loop(const SyntheticDrive& drive, int from, int to, std::mt19937& engine,
                      double sigma_m = 0.02, double sigma_rad = 0.002) {
  Loop loop;
  loop.from = static_cast<KeyFrameIndex>(from);
  loop.to = static_cast<KeyFrameIndex>(to);
  loop.stamp = drive.key_frames[to].stamp;
  loop.T_from_to =
      perturbed(drive.truth[from].inverse() * drive.truth[to], noise(engine, sigma_m, sigma_rad));
  loop.covariance = diagonal_covariance(sigma_m, sigma_rad);
  return loop;
}

inline GnssPosition make_gnss(const SyntheticDrive& drive, int at, std::mt19937& engine,
                              double sigma_m,
                              const Eigen::Vector3d& lever = Eigen::Vector3d(0.5, 0.2, 1.5)) {
  std::normal_distribution<double> normal(0.0, sigma_m);
  GnssPosition position;
  position.stamp = drive.key_frames[at].stamp;
  position.p_base_antenna = lever;
  position.p_enu_antenna =
      drive.truth[at] * lever + Eigen::Vector3d(normal(engine), normal(engine), normal(engine));
  position.covariance = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
  return position;
}

/// Root mean square of the position errors, the estimate first moved onto the truth if `align` (by
/// Umeyama's rigid motion).
inline double position_rmse(const std::vector<KeyFramePose>& poses, const std::vector<Pose>& truth,
                            bool align) {
  Eigen::Matrix3Xd estimated(3, static_cast<Eigen::Index>(poses.size()));
  Eigen::Matrix3Xd wanted(3, static_cast<Eigen::Index>(poses.size()));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    estimated.col(static_cast<Eigen::Index>(i)) = poses[i].T_map_base.translation;
    wanted.col(static_cast<Eigen::Index>(i)) = truth[poses[i].index].translation;
  }
  if (align) {
    const Eigen::Matrix4d T = Eigen::umeyama(estimated, wanted, false);
    estimated = (T.topLeftCorner<3, 3>() * estimated).colwise() + T.topRightCorner<3, 1>().eval();
  }
  return std::sqrt((estimated - wanted).squaredNorm() / static_cast<double>(poses.size()));
}

}  // namespace lidar_mapping::test
