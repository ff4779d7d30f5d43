#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/front_end/front_end_config.hpp"

namespace lidar_mapping::front_end {

/// What other sensors say about the motion at the scan's stamp; all optional.
struct MotionPrior {
  std::optional<Eigen::Vector3d> angular_velocity;  ///< rad/s, axes of base_link
  std::optional<Eigen::Vector3d> linear_velocity;   ///< m/s, axes of base_link
  /// Pose of base_link by an odometry outside; used instead of matching with `odometry: external`.
  std::optional<Pose> T_external_base;
  /// Pose of the first scan in odom; used once.
  std::optional<Pose> T_odom_base_initial;
};

enum class TrackingState {
  kTracking,
  kDegenerate,  ///< fits, but some directions were not observed: they follow the prediction
  kDegraded,    ///< fits poorly: the pose is used, the scan is not put into the map
  kLost         ///< does not fit: the pose is the prediction
};
const char* to_string(TrackingState state);

/// How one scan was judged.
struct FrontEndStatus {
  TrackingState state = TrackingState::kTracking;
  bool converged = false;
  int iterations = 0;
  double fitness = 0.0;          ///< mean squared distance of paired points, m^2
  double inlier_fraction = 0.0;  ///< 0 to 1
  double overlap = 0.0;          ///< 0 to 1
  std::vector<Eigen::Vector3d> degenerate_directions;  ///< in base_link
  bool rescued = false;                                ///< more than one start was needed
  double seconds = 0.0;                                ///< for the whole scan
  std::vector<std::pair<std::string, double>> step_seconds;
};

struct FrontEndResult {
  Stamp stamp = 0;  ///< that of the scan, bit for bit
  Pose T_odom_base;
  /// Of the motion since the previous scan, axes of base_link.
  Covariance6 covariance = Covariance6::Identity();
  Vector6d twist = Vector6d::Zero();  ///< of base_link in its own axes: m/s, rad/s
  PointCloudPtr cloud;                ///< in base_link, deskewed to the stamp
  std::optional<KeyFrame> key_frame;  ///< if this scan was chosen
  FrontEndStatus status;
};

/// Odometry of a spinning LiDAR: matches each scan against a sliding window of key frames
/// (Magnusson 2009; doc/front_end.md). Scans are in base_link; poses are T_odom_base at the scan's
/// stamp. One thread calls it; it owns no clock and no file.
class FrontEnd {
 public:
  explicit FrontEnd(const FrontEndConfig& config);
  ~FrontEnd();

  /// Throws InputError if the stamp does not increase. A poor match is no error: see the status.
  FrontEndResult process(const Scan& scan, const MotionPrior& prior = {});

  /// Goes on after a restart: the next scan begins a new segment, at this pose, and becomes the key
  /// frame `next_index`.
  void resume(KeyFrameIndex next_index, std::uint32_t next_segment, const Pose& T_odom_base);

  /// The clouds of the sliding window in odom, one point per voxel: for display.
  PointCloud local_map() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::front_end
