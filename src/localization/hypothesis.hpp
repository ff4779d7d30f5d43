// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "map_matcher.hpp"

namespace lidar_mapping::localization {

/// What a scan says about a place.
enum class Evidence {
  kAgrees,       ///< the map shows what the scan sees
  kUnconfirmed,  ///< it does again, after it did not: to be verified
  kUnknown,      ///< the map does not know what the scan sees, or the scan sees next to nothing
  kContradicts   ///< the map shows something else
};

/// The evidence of a match alone; never kUnconfirmed.
Evidence evidence_of(const MapMatch& match);

/// A place where the vehicle may be, carried along by odometry and matched with the map.
class Hypothesis {
 public:
  /// Begins at a verified pose.
  explicit Hypothesis(const PoseEstimate& verified) : estimate_(verified) {}

  /// Moves along with odometry. `covariance` is that of the motion, in the axes of its end.
  void move(const Pose& T_previous_base, const Covariance6& covariance);
  /// Matches a scan that was taken `distance` metres after the one before, judges and follows it.
  Evidence update(const ScanPoints& points, MapSurfaces& map, MapMatcher& matcher, double distance);
  /// Another verification led to this place.
  void verify(const PoseEstimate& verified);
  /// A new search begins, which has not led here yet.
  void begin_search() { is_found_ = false; }

  /// A verification of the place failed.
  void refuse();

  const PoseEstimate& estimate() const { return estimate_; }
  /// The last match.
  const MapMatch& match() const { return match_; }
  /// What the last scan said.
  Evidence evidence() const { return evidence_; }
  /// Logarithm of the odds that the place is right against that it is any other.
  double log_odds() const { return log_odds_ - deficit_; }
  int verifications() const { return verifications_; }
  /// A verification has led here since begin_search().
  bool is_found() const { return is_found_; }
  /// The map refutes the place: it is given up.
  bool is_refuted() const { return log_odds_ < 0.0; }
  /// The place is as good as any other that is known.
  bool is_possible() const { return log_odds() >= 0.0; }
  /// Another place explains more of the scan: its agreement is `best`. `distance` as in update().
  void compare(double best, double distance);
  /// By how much another place has explained the path better, as a logarithm of odds; 0 for the
  /// best.
  double deficit() const { return deficit_; }
  /// Makes the deficit of the best place zero.
  void reduce_deficit(double that_of_best) { deficit_ -= that_of_best; }
  /// Takes the greater belief of two hypotheses that became one.
  void absorb(const Hypothesis& other);

 private:
  Evidence judged() const;
  void remember(double distance);
  void add(double evidence);

  PoseEstimate estimate_;
  MapMatch match_;
  Evidence evidence_ = Evidence::kUnknown;
  double usual_agreement_ = 0.0;    ///< where the map showed what was seen
  double agreeing_distance_ = 0.0;  ///< m, since the map last did not
  bool is_confirmed_ = true;        ///< verified since then
  bool is_found_ = true;            ///< verified since the search began
  double log_odds_ = kLogOddsOfVerification;
  double deficit_ = 0.0;
  int verifications_ = 1;

  /// Chosen: one of eight accepted matches without any knowledge of the place may be of another
  /// place that looks alike.
  static constexpr double kLogOddsOfVerification = 2.0;
};

}  // namespace lidar_mapping::localization
