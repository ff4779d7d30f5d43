// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "map_matcher.hpp"

namespace lidar_mapping::localization {

/// What a scan says about a place.
enum class Evidence {
  kAgrees,      ///< the map shows what the scan sees
  kUnknown,     ///< the map does not know what the scan sees
  kContradicts  ///< the map shows something else
};

/// The evidence of a match.
Evidence evidence_of(const MapMatch& match);

/// A place where the vehicle may be, carried along by odometry and matched with the map.
class Hypothesis {
 public:
  /// Begins at a verified pose.
  explicit Hypothesis(const PoseEstimate& verified) : estimate_(verified) {}

  /// Moves along with odometry. `covariance` is that of the motion, in the axes of its end.
  void move(const Pose& T_previous_base, const Covariance6& covariance);
  /// Matches a scan that was taken `way` metres after the one before, judges and follows it.
  Evidence update(const ScanPoints& points, MapSurfaces& map, MapMatcher& matcher, double way);
  /// Another verification led to this place.
  void verify(const PoseEstimate& verified);

  const PoseEstimate& estimate() const { return estimate_; }
  /// The last match.
  const MapMatch& match() const { return match_; }
  /// Logarithm of the odds that the place is right against that it is any other.
  double log_odds() const { return log_odds_; }
  int verifications() const { return verifications_; }
  /// The evidence refutes the place.
  bool is_refuted() const;
  /// Takes the greater belief of two hypotheses that became one.
  void absorb(const Hypothesis& other);

 private:
  void add(double evidence);

  PoseEstimate estimate_;
  MapMatch match_;
  double log_odds_ = kLogOddsOfVerification;
  int verifications_ = 1;

  /// Chosen: one of eight accepted matches without any knowledge of the place may be of another
  /// place that looks alike.
  static constexpr double kLogOddsOfVerification = 2.0;
};

}  // namespace lidar_mapping::localization
