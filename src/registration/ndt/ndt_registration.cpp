// SPDX-License-Identifier: BSD-3-Clause
#include <vector>

#include "lidar_mapping/registration/ndt_matcher.hpp"

#include "fit.hpp"
#include "own_registration.hpp"
#include "voxels/voxel_target.hpp"

namespace lidar_mapping::registration {

namespace {

// Fraction of inliers from which on the search is not repeated with coarser voxels. Chosen: a start
// outside of the basin of convergence has far fewer, occlusions seldom cost a third.
constexpr double kGoodInliers = 0.7;
// Edges of the voxels of all levels, in those of the finest; the finest is the last one.
constexpr double kLevels[] = {4.0, 2.0, 1.0};
// Information of a twist of zero, (m/s)^-2 and (rad/s)^-2: clouds without times do not determine a
// twist. Chosen: 1 mm/s is as good as none.
constexpr double kTwistInformation = 1e6;

NdtPoints points_of(const PclCloud& cloud) {
  std::vector<float> x, y, z;
  for (const pcl::PointXYZ& p : cloud) {
    x.push_back(p.x);
    y.push_back(p.y);
    z.push_back(p.z);
  }
  NdtPoints points;
  points.assign(x, y, z, std::vector<float>(cloud.size(), 0.0F));
  return points;
}

class NdtRegistration : public Registration {
 public:
  explicit NdtRegistration(const RegistrationConfig& config) : config_(config) {
    options_.neighbor_search = config.neighbor_search;
    options_.max_iterations = config.max_iterations;
    options_.translation_epsilon = config.transformation_epsilon;
    options_.rotation_epsilon = config.rotation_epsilon;
  }

  void set_target(const PointCloud& target) override {
    const PclCloud::Ptr cloud = to_pcl(target);
    levels_.clear();
    if (cloud->size() < kLeastPoints) return;
    for (const double level : kLevels) {
      levels_.push_back(voxel_target(*cloud, level * config_.resolution,
                                     level > 1.0 ? PlaneModel::coarse() : PlaneModel()));
    }
    tree_.setInputCloud(cloud);
  }

  RegistrationResult align(const PointCloud& source, const Pose& T_target_source_guess) override {
    RegistrationResult result;
    result.T_target_source = T_target_source_guess;
    const PclCloud::Ptr cloud = to_pcl(source);
    if (levels_.empty() || cloud->size() < kLeastPoints) return result;
    const NdtPoints points = points_of(*cloud);
    result = matched(*cloud, points, T_target_source_guess, levels_.size() - 1);
    if (result.converged && result.inlier_fraction >= kGoodInliers) return result;
    const RegistrationResult wider = matched(*cloud, points, T_target_source_guess, 0);
    return wider.inlier_fraction > result.inlier_fraction ? wider : result;
  }

 private:
  /// From level `first` to the finest.
  RegistrationResult matched(const PclCloud& cloud, const NdtPoints& points, const Pose& guess,
                             std::size_t first) {
    MotionBelief nothing;
    nothing.information.bottomRightCorner<6, 6>().diagonal().setConstant(kTwistInformation);
    NdtMatch match;
    match.state.T_map_sensor = guess;
    int iterations = 0;
    for (std::size_t level = first; level < levels_.size(); ++level) {
      match = matcher_.match(points, levels_[level], nothing, match.state, options_);
      iterations += match.iterations;
    }
    RegistrationResult result =
        evaluate_fit(tree_, cloud, match.state.T_map_sensor, config_.fitness_max_range);
    // Without a single pair there is no step either.
    result.converged = match.converged && match.overlap > 0.0;
    result.iterations = iterations;
    return result;
  }

  RegistrationConfig config_;
  NdtOptions options_;
  NdtMatcher matcher_;
  std::vector<GaussianVoxelMap> levels_;
  pcl::search::KdTree<pcl::PointXYZ> tree_;
};

}  // namespace

std::unique_ptr<Registration> make_ndt(const RegistrationConfig& config) {
  return std::make_unique<NdtRegistration>(config);
}

}  // namespace lidar_mapping::registration
