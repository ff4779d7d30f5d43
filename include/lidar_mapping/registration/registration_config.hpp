#pragma once

#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/config/schema.hpp"
#include "lidar_mapping/registration/neighbor_search.hpp"

namespace lidar_mapping::registration {

/// Methods that make_registration() knows. The last ones are hdl_graph_slam's names; each stands
/// for one of the methods above, see implemented_by().
enum class Method { kNdt, kVgicp, kPclNdt, kIcp, kGicp, kNdtOmp, kFastGicp, kFastVgicp, kGicpOmp };

/// Parameters of scan matching; each is described once, in schema(). All thresholds are lengths in
/// metres and angles in radians, whatever the method's library makes of them.
struct RegistrationConfig {
  Method method = Method::kNdt;
  double resolution = 1.0;                ///< edge of a voxel of the target, m
  double step_size = 0.1;                 ///< longest step of the line search, m
  double transformation_epsilon = 0.001;  ///< a shorter step ends the search, m
  double rotation_epsilon = 0.0001;       ///< and a smaller turn, rad
  int max_iterations = 64;
  double max_correspondence_distance = 2.5;  ///< m
  int correspondence_randomness = 20;        ///< neighbours per covariance
  int max_optimizer_iterations = 20;
  NeighborSearch neighbor_search = NeighborSearch::kDirect1;
  int num_threads = 1;
  bool use_reciprocal_correspondences = false;
  double fitness_max_range = 1.0;  ///< m

  static const config::Schema<RegistrationConfig>& schema();
  /// Without the method and the fitness, for a stage that has a choice and a fitness of its own.
  static const config::Schema<RegistrationConfig>& parameters();
};

/// The names of the methods in configuration files.
const std::vector<std::pair<std::string, Method>>& method_names();

/// The method of this package that does the work of `method`.
Method implemented_by(Method method);

/// One sentence that says so where the name asked for is another system's; else an empty text.
std::string method_notice(const RegistrationConfig& config);

/// The name of a method as configuration files write it.
std::string to_string(Method method);

}  // namespace lidar_mapping::registration
