// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "lidar_mapping/common/parallel.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

#include "fit.hpp"
#include "own_registration.hpp"
#include "voxels/voxel_target.hpp"

namespace lidar_mapping::registration {

namespace {

// Variance of a surface across itself, where along itself it is 1: the value of generalised ICP
// (Segal et al. 2009).
constexpr double kThickness = 1e-3;
// Points of a task. Chosen: a task takes long enough for its start to be negligible; sums are made
// per task, so the result depends on it.
constexpr std::size_t kGrain = 512;
// Values of the damping that are tried per step. Chosen: ten change it by orders of magnitude.
constexpr int kMaxTries = 10;

/// Covariance of a plane with a unit normal; a normal of zero gives a ball.
Eigen::Matrix3d plane_covariance(const Eigen::Vector3d& normal) {
  return Eigen::Matrix3d::Identity() - (1.0 - kThickness) * normal * normal.transpose();
}

/// A point of the source, a voxel of the target, and the weight of their difference.
struct Pair {
  Eigen::Vector3d p_source;
  Eigen::Vector3d mean;
  Eigen::Matrix3d weight;
};

struct Equations {
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  double error = 0.0;
};

void add(const Pair& pair, const Pose& T, Equations& sum) {
  const Eigen::Vector3d d = T * pair.p_source - pair.mean;
  const Eigen::Matrix3d R = T.rotation_matrix();
  Eigen::Matrix<double, 3, 6> J;
  J << R, -R * skew(pair.p_source);
  const Eigen::Matrix<double, 6, 3> weighted = J.transpose() * pair.weight;
  sum.hessian += weighted * J;
  sum.gradient += weighted * d;
  sum.error += d.dot(pair.weight * d);
}

/// Sums over chunks, added up in their order: the same bits for any number of threads.
Equations equations_of(const std::vector<Pair>& pairs, const Pose& T, int threads) {
  std::vector<Equations> chunks((pairs.size() + kGrain - 1) / kGrain);
  parallel_chunks(pairs.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) add(pairs[i], T, chunks[begin / kGrain]);
  });
  Equations sum;
  for (const Equations& chunk : chunks) {
    sum.hessian += chunk.hessian;
    sum.gradient += chunk.gradient;
    sum.error += chunk.error;
  }
  return sum;
}

/// Cells in which a point's partners are looked for, relative to its own.
std::vector<Eigen::Vector3i> neighborhood(NeighborSearch search) {
  std::vector<Eigen::Vector3i> cells = {Eigen::Vector3i::Zero()};
  if (search == NeighborSearch::kDirect1) return cells;
  for (int axis = 0; axis < 3; ++axis) {
    cells.push_back(Eigen::Vector3i::Unit(axis));
    cells.push_back(-Eigen::Vector3i::Unit(axis));
  }
  if (search == NeighborSearch::kDirect7) return cells;
  cells.clear();
  for (int i = 0; i < 27; ++i) cells.emplace_back(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1);
  return cells;
}

class VgicpRegistration : public Registration {
 public:
  explicit VgicpRegistration(const RegistrationConfig& config)
      : config_(config), neighborhood_(neighborhood(config.neighbor_search)) {}

  void set_target(const PointCloud& target) override {
    const PclCloud::Ptr cloud = to_pcl(target);
    map_.reset();
    if (cloud->size() < kLeastPoints) return;
    map_ = voxel_target(*cloud, config_.resolution, {});
    tree_.setInputCloud(cloud);
  }

  RegistrationResult align(const PointCloud& source, const Pose& T_target_source_guess) override {
    RegistrationResult result;
    result.T_target_source = T_target_source_guess;
    const PclCloud::Ptr cloud = to_pcl(source);
    if (!map_ || cloud->size() < kLeastPoints) return result;
    const std::vector<Eigen::Vector3d> normals = normals_of(cloud);
    Pose T = T_target_source_guess;
    double damping = 0.0;
    int iterations = 0;
    bool converged = false;
    while (iterations < config_.max_iterations && !converged) {
      ++iterations;
      const auto pairs = paired(*cloud, normals, T);
      if (pairs.empty()) break;
      const Vector6d step = improve(pairs, damping, T);
      converged = step.head<3>().norm() < config_.transformation_epsilon &&
                  step.tail<3>().norm() < config_.rotation_epsilon;
    }
    result = evaluate_fit(tree_, *cloud, T, config_.fitness_max_range);
    result.converged = converged;
    result.iterations = iterations;
    return result;
  }

 private:
  /// Normals of the surface through each point's neighbours; zero where there is none.
  std::vector<Eigen::Vector3d> normals_of(const PclCloud::Ptr& cloud) const {
    pcl::search::KdTree<pcl::PointXYZ> tree;
    tree.setInputCloud(cloud);
    std::vector<Eigen::Vector3d> normals(cloud->size(), Eigen::Vector3d::Zero());
    const auto body = [&](std::size_t begin, std::size_t end) {
      pcl::Indices indices;
      std::vector<float> squared_distances;
      for (std::size_t i = begin; i < end; ++i) {
        tree.nearestKSearch((*cloud)[i], config_.correspondence_randomness, indices,
                            squared_distances);
        if (const auto plane = fit_plane(*cloud, indices)) normals[i] = plane->normal;
      }
    };
    parallel_chunks(cloud->size(), kGrain, config_.num_threads, body);
    return normals;
  }

  std::vector<Pair> paired(const PclCloud& cloud, const std::vector<Eigen::Vector3d>& normals,
                           const Pose& T) {
    GaussianVoxelMap& map = *map_;
    const Eigen::Vector3d origin = map.origin();
    const Eigen::Matrix3d R = T.rotation_matrix();
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3d p_source = cloud[i].getVector3fMap().cast<double>();
      const Eigen::Vector3d p = T * p_source - origin;
      const Eigen::Vector3i cell = voxel_index(p / map.resolution());
      const Eigen::Matrix3d of_point = plane_covariance(R * normals[i]);
      for (const Eigen::Vector3i& offset : neighborhood_) {
        const Gaussian gaussian = map.gaussian(cell + offset);
        if (gaussian.count == 0) continue;
        const Eigen::Vector3f normal = map.plane(cell + offset).normal;
        const double length = static_cast<double>(normal.norm());
        const Eigen::Vector3d unit = length > 0.0 ? Eigen::Vector3d(normal.cast<double>() / length)
                                                  : Eigen::Vector3d::Zero();
        pairs.push_back(
            {p_source, gaussian.mean + origin, (plane_covariance(unit) + of_point).inverse()});
      }
    }
    return pairs;
  }

  /// One step of Levenberg and Marquardt; zero if no step lowers the error any more.
  Vector6d improve(const std::vector<Pair>& pairs, double& damping, Pose& T) const {
    const Equations now = equations_of(pairs, T, config_.num_threads);
    const double least_damping = 1e-9 * now.hessian.diagonal().maxCoeff();
    for (int attempt = 0; attempt < kMaxTries; ++attempt) {
      damping = std::max(damping, least_damping);
      const Matrix6d damped = now.hessian + damping * Matrix6d::Identity();
      Vector6d step = -damped.ldlt().solve(now.gradient);
      const Pose moved = perturbed(T, step);
      if (equations_of(pairs, moved, config_.num_threads).error <= now.error) {
        T = moved;
        damping /= 10.0;
        return step;
      }
      damping *= 10.0;
    }
    return Vector6d::Zero();
  }

  RegistrationConfig config_;
  std::vector<Eigen::Vector3i> neighborhood_;
  std::optional<GaussianVoxelMap> map_;  ///< none without a target
  pcl::search::KdTree<pcl::PointXYZ> tree_;
};

}  // namespace

std::unique_ptr<Registration> make_vgicp(const RegistrationConfig& config) {
  return std::make_unique<VgicpRegistration>(config);
}

}  // namespace lidar_mapping::registration
