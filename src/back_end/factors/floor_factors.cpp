// SPDX-License-Identifier: BSD-3-Clause
#include "factors/floor_factors.hpp"

#include "factors/weak_prior.hpp"
#include "weights/edge_covariance.hpp"

namespace lidar_mapping::back_end {

namespace {

void add_floor_pairs(const DriveGraph& drive, const BackEndConfig& config,
                     pose_graph::FactorGraph& graph) {
  for (std::size_t i = 1; i < drive.floors.size(); ++i) {
    const DriveFloor& a = drive.floors[i - 1];
    const DriveFloor& b = drive.floors[i];
    // Floors that are further apart need not be in one plane.
    if (b.node != a.node + 1 || !drive.nodes[b.node].connected) continue;
    const Eigen::Matrix3d covariance = neighbours_covariance(a.floor, b.floor, config);
    graph.add({pose_graph::common_floor_residual(a.floor, b.floor, covariance), a.node, b.node},
              config.floor_robust_kernel, config.robust_kernel_size);
  }
}

/// A frame in the first floor whose z axis is the normal.
Pose plane_pose(const DriveGraph& drive, const DriveFloor& first) {
  const Pose& T_map_base = drive.nodes[first.node].T_map_base;
  const Eigen::Vector3d normal = T_map_base.rotation * first.floor.normal;
  return {Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal),
          T_map_base.translation - first.floor.offset * normal};
}

/// A node of its own represents the plane, so that no single floor determines it.
void add_floor_plane(const DriveGraph& drive, const BackEndConfig& config,
                     pose_graph::FactorGraph& graph) {
  if (drive.floors.empty()) return;
  const Pose pose = plane_pose(drive, drive.floors.front());
  const int plane = graph.add_node(pose);
  Vector6d stddev;  // the plane is free in height and tilt, and fixed within itself
  stddev << 1.0, 1.0, kWeakStddev_m, kWeakHeadingStddev_rad, kWeakHeadingStddev_rad, 1.0;
  graph.add({pose_graph::prior_residual(
                 pose, pose_graph::g2o_information(stddev.cwiseAbs2().asDiagonal())),
             plane});
  for (const DriveFloor& floor : drive.floors) {
    const Eigen::Matrix3d covariance = floor.floor.covariance + floor_covariance(config);
    graph.add(
        {pose_graph::common_floor_residual(Floor{}, floor.floor, covariance), plane, floor.node},
        config.floor_robust_kernel, config.robust_kernel_size);
  }
}

}  // namespace

void add_floors(const DriveGraph& drive, const BackEndConfig& config,
                pose_graph::FactorGraph& graph) {
  switch (config.floor_constraint) {
    case FloorConstraint::kNone:
      break;
    case FloorConstraint::kNeighbours:
      add_floor_pairs(drive, config, graph);
      break;
    case FloorConstraint::kPlane:
      add_floor_plane(drive, config, graph);
      break;
  }
}

}  // namespace lidar_mapping::back_end
