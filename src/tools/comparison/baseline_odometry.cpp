// SPDX-License-Identifier: BSD-3-Clause
#include "comparison/baseline_odometry.hpp"

#include <deque>
#include <memory>
#include <utility>

#include <Eigen/LU>
#include <pcl/common/transforms.h>
#include <pcl/filters/filter.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/registration/ndt.h>

#include "lidar_mapping/front_end/step_timer.hpp"

namespace lidar_mapping::tools {

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

// By definition the parameters of the front end of lidar_localization (doc/reference/ancestors.md):
// key frames in the window, those from which on it is thinned, Manhattan distance between them (m),
// edges of voxels (m), and of NDT: cells (m), step (m), epsilon (m) and iterations.
constexpr std::size_t kWindow = 20;
constexpr std::size_t kThinnedFrom = 10;
constexpr float kKeyFrameDistance = 2.0F;
constexpr float kFrameLeaf = 1.3F;
constexpr float kLocalMapLeaf = 0.6F;
constexpr float kResolution = 1.0F;
constexpr double kStepSize = 0.1;
constexpr double kTransformationEpsilon = 0.01;
constexpr int kMaxIterations = 30;

Cloud::Ptr converted(const PointCloud& cloud) {
  const Cloud::Ptr result(new Cloud);
  result->reserve(cloud.size());
  for (const Point& p : cloud.points) result->push_back(pcl::PointXYZ(p.x, p.y, p.z));
  result->is_dense = false;
  std::vector<int> indices;
  pcl::removeNaNFromPointCloud(*result, *result, indices);
  return result;
}

Cloud::Ptr thinned(const Cloud::Ptr& cloud, float leaf) {
  pcl::VoxelGrid<pcl::PointXYZ> filter;
  filter.setInputCloud(cloud);
  filter.setLeafSize(leaf, leaf, leaf);
  const Cloud::Ptr result(new Cloud);
  filter.filter(*result);
  return result;
}

class BaselineOdometry {
 public:
  BaselineOdometry() {
    ndt_.setResolution(kResolution);
    ndt_.setStepSize(kStepSize);
    ndt_.setTransformationEpsilon(kTransformationEpsilon * kTransformationEpsilon);
    ndt_.setMaximumIterations(kMaxIterations);
  }

  front_end::FrontEndResult process(const Scan& scan) {
    timer_.start("sampling");
    Frame frame{Eigen::Matrix4f::Identity(), converted(scan.cloud)};
    const Cloud::Ptr sample = thinned(frame.cloud, kFrameLeaf);
    if (!window_.empty()) {
      timer_.start("matching");
      frame.pose = matched(sample);
    }
    timer_.start("insertion");
    const bool key_frame = is_key_frame(frame.pose);
    front_end::FrontEndResult result;
    result.stamp = scan.stamp;
    result.T_odom_base = Pose::from_matrix(frame.pose.cast<double>());
    if (key_frame) keep(std::move(frame));
    result.status.step_seconds = timer_.take();
    return result;
  }

 private:
  struct Frame {
    Eigen::Matrix4f pose;
    Cloud::Ptr cloud;
  };

  Eigen::Matrix4f matched(const Cloud::Ptr& sample) {
    Cloud aligned;
    ndt_.setInputSource(sample);
    ndt_.align(aligned, last_pose_ * step_);
    const Eigen::Matrix4f pose = ndt_.getFinalTransformation();
    step_ = last_pose_.inverse() * pose;
    last_pose_ = pose;
    return pose;
  }

  bool is_key_frame(const Eigen::Matrix4f& pose) const {
    if (window_.empty()) return true;
    const Eigen::Vector3f way = pose.block<3, 1>(0, 3) - window_.back().pose.block<3, 1>(0, 3);
    return way.lpNorm<1>() > kKeyFrameDistance;
  }

  void keep(Frame frame) {
    window_.push_back(std::move(frame));
    if (window_.size() > kWindow) window_.pop_front();
    const Cloud::Ptr local_map(new Cloud);
    for (const Frame& kept : window_) {
      Cloud placed;
      pcl::transformPointCloud(*kept.cloud, placed, kept.pose);
      *local_map += placed;
    }
    ndt_.setInputTarget(window_.size() < kThinnedFrom ? local_map
                                                      : thinned(local_map, kLocalMapLeaf));
  }

  pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ> ndt_;
  std::deque<Frame> window_;
  Eigen::Matrix4f last_pose_ = Eigen::Matrix4f::Identity();
  Eigen::Matrix4f step_ = Eigen::Matrix4f::Identity();
  front_end::StepTimer timer_;
};

}  // namespace

std::function<front_end::FrontEndResult(const Scan&)> baseline_odometry() {
  return [odometry = std::make_shared<BaselineOdometry>()](const Scan& scan) {
    return odometry->process(scan);
  };
}

}  // namespace lidar_mapping::tools
