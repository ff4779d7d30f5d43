// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/registration/gaussian_voxel_map.hpp"
#include "lidar_mapping/registration/ndt_points.hpp"
#include "lidar_mapping/registration/neighbor_search.hpp"

namespace lidar_mapping::registration {

/// Perturbation of a MotionState: that of the pose, then that of the twist.
using Vector12d = Eigen::Matrix<double, 12, 1>;
/// 12x12, in the order of Vector12d.
using Matrix12d = Eigen::Matrix<double, 12, 12>;

/// Pose of the sensor at a reference time and its twist during the sweep (own axes, m/s and rad/s).
/// Perturbations: that of perturbed() for the pose, then the twist's.
struct MotionState {
  Pose T_map_sensor;                  ///< at the reference time
  Vector6d twist = Vector6d::Zero();  ///< constant during the sweep, m/s and rad/s
};

/// The pose perturbed as perturbed() does it, and the twist plus the last six numbers of d.
MotionState perturbed(const MotionState& state, const Vector12d& d);
/// The d for which perturbed(a, d) equals b.
Vector12d difference(const MotionState& a, const MotionState& b);

/// Prior of a match; an information of zero is no prior.
struct MotionBelief {
  MotionState state;                          ///< the most likely one
  Matrix12d information = Matrix12d::Zero();  ///< inverse of its covariance
};

/// How a match is done.
struct NdtOptions {
  /// Voxels whose planes a point is matched with. The figures of how well the points fit, and the
  /// information, are those of one pair per point.
  NeighborSearch neighbor_search = NeighborSearch::kDirect1;
  /// Distance in standard deviations at which a point loses most of its weight (Geman-McClure).
  double kernel = 2.5;
  /// Factor by which the squared kernel is wider in the first iteration.
  double kernel_widening = 100.0;
  /// Factor by which it gets narrower with each iteration, until it has its own width.
  double kernel_fall = 16.0;
  int max_iterations = 30;            ///< after which the match has not converged
  double translation_epsilon = 1e-3;  ///< m: a step below both limits ends the search
  double rotation_epsilon = 5e-5;     ///< rad
  /// Weight of a residual against the prior: below one because neighbouring points err together.
  double data_weight = 0.3;
  /// Directions (unit vectors in the sensor's axes) along which the points are ignored: their
  /// information is marginalised out, and the prior decides there.
  std::vector<Eigen::Vector3d> blind_directions;
  /// Whether NdtMatch::parts and NdtMatch::slices are wanted.
  bool parts = false;
};

/// Normal equations of one part of the points for the pose, at the state before the last step and
/// with the robust weights there, for independent residuals: hessian * d = -gradient, axes of the
/// sensor.
struct NdtPart {
  Matrix6d hessian = Matrix6d::Zero();   ///< Gauss-Newton, for perturbed() of the pose
  Vector6d gradient = Vector6d::Zero();  ///< of half the weighted sum of squared residuals
};

/// Number of sectors of equal angle around the sensor into which the points of a match are divided.
/// Chosen: 45 degrees, so that a wall or a vehicle beside the sensor is in few of them.
constexpr std::size_t kNdtSectors = 8;
/// Parts of a match, twice kNdtSectors: the sectors with their points that are nearer than the mean
/// range, then the sectors with the farther ones.
constexpr std::size_t kNdtParts = 2 * kNdtSectors;

/// Normal equations of the points of nearly the same time for a change of the sensor's pose at that
/// time, in the axes of the sensor at the reference time.
struct NdtSlice {
  double time = 0.0;  ///< mean of its points, s after the reference time
  NdtPart part;       ///< the normal equations
};

/// What NdtMatcher::weights() gives a point without a plane. Chosen: no weight is negative.
constexpr float kNoPlane = -1.0F;

/// Where the points fit best, and how well.
struct NdtMatch {
  MotionState state;       ///< where the search ended
  bool converged = false;  ///< the last step was below the limits
  int iterations = 0;      ///< number of steps
  double excursion = 0.0;  ///< m: distance from the start to the farthest position on the way
  /// Gauss-Newton Hessian of the points alone for the pose, for independent residuals.
  Matrix6d pose_hessian = Matrix6d::Zero();
  /// Information of the points, weighted against the prior: NdtOptions::data_weight times their
  /// Hessian.
  Matrix12d points_information = Matrix12d::Zero();
  /// Information of points and prior together: the inverse of the state's covariance.
  Matrix12d information = Matrix12d::Zero();
  double quality = 0.0;          ///< mean robust weight of all points, 0 to 1
  double inlier_fraction = 0.0;  ///< inliers of the kernel / points
  double overlap = 0.0;          ///< points with a plane in their own voxel / points
  /// Mean squared distance of the points to their planes, in units of the planes' variances.
  double residual_variance = 0.0;
  double fitness = 0.0;  ///< mean squared distance of the inliers to their planes, m^2
  /// kNdtParts of them if they were asked for, else none.
  std::vector<NdtPart> parts;
  /// The time slices of the points in their order, if parts were asked for. Blind directions are
  /// not marginalised out.
  std::vector<NdtSlice> slices;
};

/// Aligns points with a GaussianVoxelMap: point to plane of the voxel that a point falls into, with
/// a robust weight and analytic derivatives, for pose and twist together
/// (doc/front_end_matching.md). Only scratch memory is kept between calls. One thread at a time
/// uses a matcher.
class NdtMatcher {
 public:
  /// Chooses the kernels that the processor can run.
  NdtMatcher();
  ~NdtMatcher();

  /// Gauss-Newton from `start`; the prior pulls towards prior.state.
  NdtMatch match(const NdtPoints& points, GaussianVoxelMap& map, const MotionBelief& prior,
                 const MotionState& start, const NdtOptions& options);
  /// How well the points fit at `state`, without moving it: all but the information.
  NdtMatch evaluate(const NdtPoints& points, GaussianVoxelMap& map, const MotionState& state,
                    const NdtOptions& options);
  /// The robust weight of each point at `state`, 0 to 1, or kNoPlane; of a point with several
  /// planes the greatest one. In the order of the points' arrays, with their filling, which has no
  /// planes.
  std::vector<float> weights(const NdtPoints& points, GaussianVoxelMap& map,
                             const MotionState& state, const NdtOptions& options);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::registration
