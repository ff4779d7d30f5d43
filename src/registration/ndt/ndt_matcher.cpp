// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/registration/ndt_matcher.hpp"

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "lidar_mapping/common/robust_weights.hpp"

#include "ndt/ndt_kernels.hpp"
#include "ndt/ndt_neighbors.hpp"
#include "ndt/ndt_parts.hpp"

namespace lidar_mapping::registration {
namespace {

// Fraction of the trace that is added to each diagonal element; chosen: far below the information
// of points, above the rounding of doubles.
constexpr double kMinTrace = 1e-12;

/// How well points fit with the planes of their own voxels, see NdtSums.
struct FitSums {
  double weight = 0.0;
  double paired = 0.0;
  double inliers = 0.0;
  double squared_residual = 0.0;
  double squared_distance = 0.0;

  void add(const NdtSums& sums) {
    weight += sums.weight;
    paired += sums.paired;
    inliers += sums.inliers;
    squared_residual += sums.squared_residual;
    squared_distance += sums.squared_distance;
  }
};

/// Normal equations of all points: hessian * d = -gradient, perturbations in the sensor's axes.
struct NormalEquations {
  Matrix12d hessian = Matrix12d::Zero();
  Vector12d gradient = Vector12d::Zero();
  Matrix6d pose_hessian = Matrix6d::Zero();
  FitSums fit;
  double weight = 0.0;  ///< sum of the robust weights of all pairs, also with other voxels
};

void add(const NdtPart& part, NdtPart& sum) {
  sum.hessian += part.hessian;
  sum.gradient += part.gradient;
}

void scale(double factor, NdtPart& part) {
  part.hessian *= factor;
  part.gradient *= factor;
}

/// The pairs of one point err together: all of them say no more than one. So each pair counts by
/// its share of a point, that of the weights of the own voxels in those of all pairs. It is 1 if a
/// point has one pair only.
double share_of_pair(const NormalEquations& sum, std::size_t planes_per_point) {
  const double least = 1.0 / static_cast<double>(planes_per_point);
  return sum.weight > 0.0 ? std::max(least, sum.fit.weight / sum.weight) : 1.0;
}

/// A point seen s seconds after the reference time moves with the twist as it moves with the pose,
/// times s. So the blocks of the twist follow from those of the pose, a time slice at a time. The
/// slice's mean time stands in the Jacobian only, never in the residual: the solution is exact.
void add_slice(const NdtSlice& slice, NormalEquations& sum) {
  const double s = slice.time;
  const Matrix6d& H = slice.part.hessian;
  const Vector6d& b = slice.part.gradient;
  sum.pose_hessian += H;
  sum.hessian.topLeftCorner<6, 6>() += H;
  sum.hessian.topRightCorner<6, 6>() += s * H;
  sum.hessian.bottomLeftCorner<6, 6>() += s * H;
  sum.hessian.bottomRightCorner<6, 6>() += s * s * H;
  sum.gradient.head<6>() += b;
  sum.gradient.tail<6>() += s * b;
}

SweepMotion sweep_motion(const MotionState& state, const Eigen::Vector3d& origin) {
  SweepMotion motion{};
  const Eigen::Matrix<float, 3, 3, Eigen::RowMajor> R =
      state.T_map_sensor.rotation_matrix().cast<float>();
  const Eigen::Vector3f t = (state.T_map_sensor.translation - origin).cast<float>();
  const Vector6d& twist = state.twist;
  std::copy(R.data(), R.data() + 9, motion.rotation);
  for (int axis = 0; axis < 3; ++axis) {
    motion.translation[axis] = t[axis];
    motion.velocity[axis] = static_cast<float>(twist[axis]);
    motion.angular_velocity[axis] = static_cast<float>(twist[axis + 3]);
  }
  return motion;
}

/// A column per direction for the pose, and one for the twist.
Eigen::MatrixXd motions_along(const std::vector<Eigen::Vector3d>& directions) {
  const auto count = static_cast<Eigen::Index>(directions.size());
  Eigen::MatrixXd along = Eigen::MatrixXd::Zero(12, 2 * count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector3d& direction = directions[i];
    along.block<3, 1>(0, i) = along.block<3, 1>(6, count + i) = direction;
  }
  return along;
}

/// Marginalises the information of the points along the directions out, and no more: in a bend of a
/// tunnel the heading is still correlated with the position.
void marginalise_out(const std::vector<Eigen::Vector3d>& directions, NormalEquations& sum) {
  if (directions.empty()) return;
  // Points without times give no information about the twist; the term makes H invertible.
  const Matrix12d H = sum.hessian + kMinTrace * sum.hessian.trace() * Matrix12d::Identity();
  const Eigen::MatrixXd along = motions_along(directions);
  const Eigen::MatrixXd response = H.ldlt().solve(along);
  const Eigen::MatrixXd marginal = (along.transpose() * response).inverse();
  sum.gradient -= along * (marginal * (response.transpose() * sum.gradient));
  sum.hessian -= along * marginal * along.transpose();
}

/// Between two positions, m.
double distance(const MotionState& a, const MotionState& b) {
  return (b.T_map_sensor.translation - a.T_map_sensor.translation).norm();
}

void write_figures(const FitSums& sum, std::size_t points, NdtMatch& match) {
  const double count = std::max<double>(1.0, static_cast<double>(points));
  match.quality = sum.weight / count;
  match.inlier_fraction = sum.inliers / count;
  match.overlap = sum.paired / count;
  match.residual_variance = sum.weight > 0.0 ? sum.squared_residual / sum.weight : 0.0;
  match.fitness = sum.inliers > 0.0 ? sum.squared_distance / sum.inliers : 0.0;
}

/// The weight that the kernels give to a point of the map; kNoPlane if its plane is none.
float weight_of(const Eigen::Vector3f& point, const PlaneArrays& planes, std::size_t i,
                double kernel) {
  const Eigen::Vector3f normal(planes.x[i], planes.y[i], planes.z[i]);
  if (!(normal.squaredNorm() > 0.0F)) return kNoPlane;
  const float residual = normal.dot(point) - planes.offset[i];
  return static_cast<float>(geman_mcclure_weight(residual, kernel));
}

}  // namespace

MotionState perturbed(const MotionState& state, const Vector12d& d) {
  return {perturbed(state.T_map_sensor, Vector6d(d.head<6>())), state.twist + d.tail<6>()};
}

Vector12d difference(const MotionState& a, const MotionState& b) {
  Vector12d d;
  d << difference(a.T_map_sensor, b.T_map_sensor), b.twist - a.twist;
  return d;
}

/// What is kept between calls, and the steps of a search.
struct NdtMatcher::Impl {
  void begin(const NdtPoints& points, const NdtOptions& options) {
    const std::size_t size = points.padded_size();
    for (auto* array : {&rotated.x, &rotated.y, &rotated.z}) array->resize(size);
    cells.resize(size);
    neighbors.begin(size, options.neighbor_search);
  }

  /// Points to where they are in the map, and their planes.
  SweepMotion locate(const NdtPoints& points, GaussianVoxelMap& map, const MotionState& state) {
    const SweepMotion motion = sweep_motion(state, map.origin());
    const SweepArrays arrays{points.x().data(), points.y().data(), points.z().data(),
                             points.s().data()};
    kernels.locate(motion, static_cast<float>(1.0 / map.resolution()), arrays, points.padded_size(),
                   rotated.x.data(), rotated.y.data(), rotated.z.data(), cells.data());
    rotated.translation = Eigen::Map<const Eigen::Vector3f>(motion.translation);
    rotated.viewpoint = points.viewpoint();
    if (rotated.viewpoint) {
      rotated.viewpoint = state.T_map_sensor.rotation.cast<float>() * *points.viewpoint();
    }
    neighbors.update(cells, rotated, map);
    return motion;
  }

  NormalEquations normal_equations(const NdtPoints& points, GaussianVoxelMap& map,
                                   const MotionState& state, double kernel_squared) {
    const SweepMotion motion = locate(points, map, state);
    const Eigen::Matrix3d R = state.T_map_sensor.rotation_matrix();
    NormalEquations sum;
    slices.clear();
    for (const NdtPoints::Slice& slice : points.slices()) {
      NdtSlice& equations = slices.emplace_back();
      equations.time = slice.time;
      for (std::size_t neighbor = 0; neighbor < neighbors.count(); ++neighbor) {
        const NdtSums sums =
            slice_sums(slice, neighbor, motion, static_cast<float>(kernel_squared));
        add(part_of(sums, R), equations.part);
        sum.weight += sums.weight;
        if (neighbor == kOwnVoxel) sum.fit.add(sums);
      }
    }
    const double share = share_of_pair(sum, neighbors.count());
    for (NdtSlice& equations : slices) {
      scale(share, equations.part);
      add_slice(equations, sum);
    }
    return sum;
  }

  NdtSums slice_sums(const NdtPoints::Slice& slice, std::size_t neighbor, const SweepMotion& motion,
                     float kernel_squared) const {
    const PlaneArrays& planes = neighbors.planes(neighbor);
    const std::size_t i = slice.begin;
    const float* const arrays[4] = {&planes.x[i], &planes.y[i], &planes.z[i], &planes.offset[i]};
    NdtSums sums{};
    kernels.accumulate(&rotated.x[i], &rotated.y[i], &rotated.z[i], arrays, motion.translation,
                       kernel_squared, slice.end - slice.begin, &sums);
    return sums;
  }

  const NdtKernels& kernels = ndt_kernels();
  RotatedPoints rotated;
  std::vector<std::int32_t> cells;
  NdtNeighbors neighbors;
  NdtParts parts;
  std::vector<NdtSlice> slices;  ///< of the last normal equations
};

NdtMatcher::NdtMatcher() : impl_(std::make_unique<Impl>()) {}
NdtMatcher::~NdtMatcher() = default;

NdtMatch NdtMatcher::match(const NdtPoints& points, GaussianVoxelMap& map,
                           const MotionBelief& prior, const MotionState& start,
                           const NdtOptions& options) {
  impl_->begin(points, options);
  NdtMatch match;
  match.state = start;
  const double final_kernel = options.kernel * options.kernel;
  double kernel = final_kernel * options.kernel_widening;
  NormalEquations sum;
  Eigen::Matrix3d R_map_sensor;
  while (match.iterations < options.max_iterations && !match.converged) {
    ++match.iterations;
    R_map_sensor = match.state.T_map_sensor.rotation_matrix();
    sum = impl_->normal_equations(points, map, match.state, kernel);
    marginalise_out(options.blind_directions, sum);
    match.points_information = options.data_weight * sum.hessian;
    match.information = match.points_information + prior.information;
    const Vector12d gradient = options.data_weight * sum.gradient +
                               prior.information * difference(prior.state, match.state);
    const Vector12d step = -match.information.ldlt().solve(gradient);
    if (!step.allFinite()) break;
    match.state = perturbed(match.state, step);
    match.excursion = std::max(match.excursion, distance(start, match.state));
    match.converged = kernel <= final_kernel &&
                      step.head<3>().norm() < options.translation_epsilon &&
                      step.segment<3>(3).norm() < options.rotation_epsilon;
    kernel = std::max(final_kernel, kernel / options.kernel_fall);
  }
  match.pose_hessian = sum.pose_hessian;
  write_figures(sum.fit, points.size(), match);
  if (options.parts) {
    match.slices = impl_->slices;
    match.parts = impl_->parts.of(points, impl_->rotated, impl_->neighbors.planes(kOwnVoxel),
                                  static_cast<float>(final_kernel), R_map_sensor);
  }
  return match;
}

NdtMatch NdtMatcher::evaluate(const NdtPoints& points, GaussianVoxelMap& map,
                              const MotionState& state, const NdtOptions& options) {
  impl_->begin(points, options);
  NdtMatch match;
  match.state = state;
  const SweepMotion motion = impl_->locate(points, map, state);
  const NdtPoints::Slice all{0, points.padded_size(), 0.0F};
  FitSums sum;
  sum.add(impl_->slice_sums(all, kOwnVoxel, motion,
                            static_cast<float>(options.kernel * options.kernel)));
  write_figures(sum, points.size(), match);
  return match;
}

std::vector<float> NdtMatcher::weights(const NdtPoints& points, GaussianVoxelMap& map,
                                       const MotionState& state, const NdtOptions& options) {
  impl_->begin(points, options);
  impl_->locate(points, map, state);
  std::vector<float> weights(points.padded_size(), kNoPlane);
  for (std::size_t neighbor = 0; neighbor < impl_->neighbors.count(); ++neighbor) {
    const PlaneArrays& planes = impl_->neighbors.planes(neighbor);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      weights[i] =
          std::max(weights[i], weight_of(impl_->rotated.position(i), planes, i, options.kernel));
    }
  }
  return weights;
}

}  // namespace lidar_mapping::registration
