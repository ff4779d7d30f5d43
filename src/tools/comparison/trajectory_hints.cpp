// SPDX-License-Identifier: BSD-3-Clause
#include "comparison/trajectory_hints.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/evaluation/lever_arm.hpp"
#include "lidar_mapping/evaluation/trajectory_errors.hpp"

namespace lidar_mapping::tools {

namespace {

using namespace evaluation;
using Pairs = std::vector<PosePair>;

constexpr double kMaxRemaining = 0.5;      // of the error, with a hint; chosen: more is no cause
constexpr double kLeastGain_m = 0.02;      // chosen: smaller gains are not worth a hint
constexpr double kLeastGain_deg = 0.5;     // chosen, as above
constexpr double kLeastLeverArm_m = 0.05;  // chosen: about what is measured by hand

double position_error(const Pairs& pairs) { return absolute_pose_error(pairs).translation_m.rmse; }
double angle_error(const Pairs& pairs) { return absolute_pose_error(pairs).rotation_deg.rmse; }

Pairs rigidly_aligned(const Pairs& pairs) { return aligned(pairs, rigid_alignment(pairs)); }

/// An option to compare the trajectories, and the remaining error.
struct Proposal {
  double error = 0.0;
  bool align = false;
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();

  bool has_lever_arm() const { return lever_arm.norm() > kLeastLeverArm_m; }
};

Proposal with_lever_arm(const Pairs& pairs, bool align) {
  Proposal proposal;
  proposal.align = align;
  proposal.lever_arm = estimated_lever_arm(pairs, align).value_or(Eigen::Vector3d::Zero());
  const Pairs moved = moved_on_vehicle(pairs, {Eigen::Quaterniond::Identity(), proposal.lever_arm});
  proposal.error = position_error(align ? rigidly_aligned(moved) : moved);
  return proposal;
}

/// From the simplest option to that with most freedom; a later one has to halve the remaining
/// error.
Proposal best_proposal(const Pairs& pairs, const AppliedOptions& applied) {
  std::vector<Proposal> proposals;
  if (!applied.alignment) {
    proposals.push_back({position_error(rigidly_aligned(pairs)), true, Eigen::Vector3d::Zero()});
  }
  if (!applied.lever_arm) {
    if (!applied.alignment) proposals.push_back(with_lever_arm(pairs, false));
    proposals.push_back(with_lever_arm(pairs, true));
  }
  Proposal best{position_error(pairs), false, Eigen::Vector3d::Zero()};
  for (const Proposal& proposal : proposals) {
    if (proposal.error < kMaxRemaining * best.error && proposal.error < best.error - kLeastGain_m) {
      best = proposal;
    }
  }
  return best;
}

std::string sentence(const Proposal& proposal, double now) {
  std::string options = proposal.align ? " --align" : "";
  std::string reason = "the trajectories lie in different frames";
  if (proposal.has_lever_arm()) {
    const Eigen::Vector3d& l = proposal.lever_arm;
    options += formatted(" --lever-arm %.2f %.2f %.2f", l.x(), l.y(), l.z());
    reason = "the truth seems to be that of another point of the vehicle";
  }
  return formatted("the APE would be %.3f m instead of %.3f m with%s: %s", proposal.error, now,
                   options.c_str(), reason.c_str());
}

/// Roll, pitch and yaw in degrees.
Eigen::Vector3d angles_of(const Eigen::Quaterniond& rotation) {
  const Eigen::Matrix3d R = rotation.toRotationMatrix();
  const Eigen::Vector3d angles(std::atan2(R(2, 1), R(2, 2)),
                               std::asin(std::clamp(-R(2, 0), -1.0, 1.0)),
                               std::atan2(R(1, 0), R(0, 0)));
  // To a tenth; the sum makes 0 of -0.
  return (10.0 * kDegPerRad * angles).array().round() / 10.0 + 0.0;
}

}  // namespace

std::vector<std::string> trajectory_hints(const Pairs& pairs, const AppliedOptions& applied) {
  std::vector<std::string> hints;
  if (pairs.size() < 3) return hints;
  const double now = position_error(pairs);
  const Proposal best = best_proposal(pairs, applied);
  if (best.align || best.has_lever_arm()) hints.push_back(sentence(best, now));
  if (applied.lever_rotation) return hints;
  const Pairs compared = best.align ? rigidly_aligned(pairs) : pairs;
  const Eigen::Quaterniond turn = estimated_turn(compared);
  const double before = angle_error(compared);
  const double after = angle_error(moved_on_vehicle(compared, {turn, Eigen::Vector3d::Zero()}));
  // Axes explain no error that an alignment alone brings in.
  const double least = std::min(before, angle_error(pairs));
  if (after > kMaxRemaining * least || after > least - kLeastGain_deg) return hints;
  const Eigen::Vector3d angles = angles_of(turn);
  hints.push_back(formatted(
      "the angles would be %.2f deg off instead of %.2f deg with%s --lever-rotation %.1f %.1f "
      "%.1f: the axes of the truth seem to be others",
      after, before, best.align ? " --align" : "", angles.x(), angles.y(), angles.z()));
  return hints;
}

}  // namespace lidar_mapping::tools
