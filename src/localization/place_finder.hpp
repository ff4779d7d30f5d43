// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "lidar_mapping/localization/localizer.hpp"

#include "hypotheses.hpp"
#include "map_parts.hpp"
#include "recent_scans.hpp"

namespace lidar_mapping::localization {

/// Finds the place of a vehicle in the map: looks for candidates by appearance, verifies some with
/// each scan, and carries all that are possible along until one alone is left.
class PlaceFinder {
 public:
  explicit PlaceFinder(MapParts& map);

  /// Begins anew, without any knowledge.
  void restart();
  /// A pose of the next scan that a person claims. Until it turns out wrong, only places near it
  /// are possible.
  void claim(const Pose& T_map_base) { claim_ = Claim{T_map_base}; }
  /// Carries all along by odometry.
  void move(const Pose& T_previous_base, const Covariance6& covariance);
  /// Looks at the next scan, `distance` metres after the one before; returns the place once it is
  /// certain.
  std::optional<Hypothesis> search(const LocalizerInput& input, const ScanPoints& points,
                                   MapMatcher& matcher, double distance);

  enum class Confirmation {
    kNotDue,   ///< the last one was less than a metre and five scans ago
    kRefused,  ///< the verification does not accept the place
    kAccepted
  };
  struct Confirmed {
    Confirmation outcome = Confirmation::kNotDue;
    PoseEstimate verified;  ///< if accepted
  };
  /// Verifies a place that is followed, if that is due: with this scan and those with which it was
  /// verified before.
  Confirmed confirm(const LocalizerInput& input, const Pose& T_map_base, double distance);

  const Hypotheses& hypotheses() const { return hypotheses_; }
  /// Number of searches that have ended.
  int searches() const { return searches_; }
  /// Why no place is certain yet, in one sentence.
  std::string reason() const;

 private:
  struct Claim {
    Pose T_map_base;   ///< carried along
    int searches = 0;  ///< that ended since
  };
  bool is_search_due() const;
  bool has_gone_on() const;
  void begin_search();
  std::size_t candidates_due(Stamp stamp) const;
  void verify(std::size_t count);
  void end_search();
  std::optional<Hypothesis> certain() const;
  bool claim_contradicts(const Hypothesis& place) const;

  MapParts& map_;
  RecentScans recent_;
  Hypotheses hypotheses_;
  std::optional<Claim> claim_;
  Pose T_start_base_;               ///< by odometry since the search began
  std::deque<Pose> candidates_;     ///< T_map_base of the newest scan, still to be verified
  std::optional<Stamp> last_scan_;  ///< that was searched with
  bool is_searching_ = false;       ///< candidates of a search are being verified
  int searches_ = 0;                ///< that have ended
  int scans_ = 0;                   ///< since the last search began
  double distance_ = 0.0;           ///< since then, m
};

}  // namespace lidar_mapping::localization
