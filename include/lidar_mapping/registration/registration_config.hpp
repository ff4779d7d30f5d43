// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/config/schema.hpp"
#include "lidar_mapping/registration/neighbor_search.hpp"

namespace lidar_mapping::registration {

/// Methods that make_registration() knows. The last ones are hdl_graph_slam's names; each stands
/// for one of the methods above, see implemented_by().
enum class Method {
  kNdt,        ///< points to the planes of voxels, this package's own (Magnusson 2009)
  kVgicp,      ///< voxelised generalised ICP, this package's own (Koide et al. 2021)
  kPclNdt,     ///< pcl::NormalDistributionsTransform
  kIcp,        ///< pcl::IterativeClosestPoint (Besl and McKay 1992)
  kGicp,       ///< pcl::GeneralizedIterativeClosestPoint (Segal et al. 2009)
  kNdtOmp,     ///< stands for kNdt
  kFastGicp,   ///< stands for kVgicp
  kFastVgicp,  ///< stands for kVgicp
  kGicpOmp     ///< stands for kGicp
};

/// Parameters of scan matching; each is described once, in schema(). All thresholds are lengths in
/// metres and angles in radians, whatever the method's library makes of them.
struct RegistrationConfig {
  /// Method that aligns clouds; hdl_graph_slam's names stand for ours.
  Method method = Method::kNdt;
  /// [m] Edge of a voxel of the target's normal distributions.
  double resolution = 1.0;
  /// [m] Longest step of the line search of PCL_NDT.
  double step_size = 0.1;
  /// [m] A step that is shorter ends the search.
  double transformation_epsilon = 0.001;
  /// [rad] A step that turns less, and is short, ends the search; pi looks at lengths alone.
  double rotation_epsilon = 0.0001;
  /// [iterations] Iterations after which a search has failed.
  int max_iterations = 64;
  /// [m] Points farther apart are no pair for ICP and GICP.
  double max_correspondence_distance = 2.5;
  /// [points] Neighbours from which GICP and VGICP take a point's covariance.
  int correspondence_randomness = 20;
  /// [iterations] Inner iterations of GICP.
  int max_optimizer_iterations = 20;
  /// Voxels in which NDT and VGICP look for a point's partners.
  NeighborSearch neighbor_search = NeighborSearch::kDirect1;
  /// Upper limit of VGICP's threads; 0 takes all cores. The result does not depend on it.
  int num_threads = 1;
  /// ICP pairs only points that are each other's nearest.
  bool use_reciprocal_correspondences = false;
  /// [m] Points farther from the target count neither in the fitness nor in the overlap.
  double fitness_max_range = 1.0;

  /// All fields.
  static const config::Schema<RegistrationConfig>& schema();
  /// Without the method and the fitness, for a stage that has a choice and a fitness of its own.
  static const config::Schema<RegistrationConfig>& parameters();
};

/// The names of the methods in configuration files.
const std::vector<std::pair<std::string, Method>>& method_names();

/// The method of this package that does the work of `method`.
Method implemented_by(Method method);

/// A sentence that names the method in use, if the configured name is that of another system; else
/// empty.
std::string describe_substitution(const RegistrationConfig& config);

/// The name of a method as configuration files write it.
std::string to_string(Method method);

}  // namespace lidar_mapping::registration
