#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/front_end/front_end_status.hpp"

#include "campaign_case.hpp"

namespace lidar_mapping::tools {

/// A step is wrong from here on.
constexpr double kWrongStep = 0.3;       // m
constexpr double kWrongStepAngle = 1.0;  // deg

/// What the front end made of one drive.
struct CampaignFigures {
  std::size_t scans = 0;
  std::optional<double> drift_percent;  ///< none where the drive is too short
  std::size_t silent = 0;               ///< steps that are wrong though called tracking
  std::size_t lost = 0;
  std::size_t degraded = 0;
  std::size_t degenerate = 0;
  double largest_error = 0.0;      ///< m, of a step that is called tracking
  double largest_error_deg = 0.0;  ///< likewise
  double cpu_ms = 0.0;             ///< per scan
  double way = 0.0;                ///< m
  double ape = 0.0;                ///< m, root mean square after alignment
};

/// Tells wrong steps that are called right. A step leads from the last scan that was not called
/// lost or degraded: a guess in between claims nothing.
class StepChecker {
 public:
  /// The pose of the next scan and what was said of it, `new_segment` where the poses before do not
  /// hang together with it.
  void take(const Pose& T_map_base, const Pose& T_odom_base, front_end::TrackingState state,
            bool new_segment);
  std::size_t silent() const { return silent_; }
  double largest_error() const { return largest_error_; }
  double largest_error_deg() const { return largest_error_deg_; }

 private:
  struct Claim {
    Pose T_map_base;
    Pose T_odom_base;
  };
  std::optional<Claim> last_;
  std::size_t silent_ = 0;
  double largest_error_ = 0.0;
  double largest_error_deg_ = 0.0;
};

/// Simulates the case and runs the front end over `duration` seconds of it. Throws ConfigError.
CampaignFigures run_case(const CampaignCase& campaign_case, double duration);

}  // namespace lidar_mapping::tools
