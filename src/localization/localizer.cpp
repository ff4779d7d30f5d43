// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/localization/localizer.hpp"

#include <cmath>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

#include "hypotheses.hpp"
#include "map_noise.hpp"
#include "map_parts.hpp"
#include "place_finder.hpp"

namespace lidar_mapping::localization {

namespace {

/// m: standard deviation from which on a pose by odometry is worth nothing: a match does not find
/// back from there. Chosen: half of a street and more.
constexpr double kGreatestStddev = 5.0;

double probability_of(double log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); }

std::string sentence(Evidence evidence, const Agreement& agreement) {
  const double shown = 100.0 * agreement.agreement;
  switch (evidence) {
    case Evidence::kAgrees:
      return formatted("%.0f %% of the surroundings agree with the map", shown);
    case Evidence::kUnconfirmed:
      return formatted(
          "%.0f %% of the surroundings agree with the map, but the place is not confirmed yet; the "
          "pose is that of odometry",
          shown);
    case Evidence::kUnknown:
    case Evidence::kContradicts:
      break;
  }
  return formatted(
      "the map contains the places of %.0f %% of %zu points, and %.0f %% of the surroundings agree "
      "with it; the pose is that of odometry",
      100.0 * agreement.coverage, agreement.points, shown);
}

double position_stddev(const PoseEstimate& estimate) {
  return std::sqrt(estimate.covariance.diagonal().head<3>().maxCoeff());
}

}  // namespace

const char* to_string(LocalizationState state) {
  switch (state) {
    case LocalizationState::kSearching:
      return "searching";
    case LocalizationState::kFollowing:
      return "following";
    case LocalizationState::kBesideMap:
      return "beside_map";
    case LocalizationState::kLost:
      break;
  }
  return "lost";
}

bool has_pose(LocalizationState state) {
  return state == LocalizationState::kFollowing || state == LocalizationState::kBesideMap;
}

class Localizer::Impl {
 public:
  explicit Impl(MapIndex& map) : map_(map.parts()), finder_(map.parts()) {}

  void set_initial_pose(const Pose& T_map_base) {
    found_.reset();
    map_noise_.interrupt();
    finder_.restart();
    claim_ = T_map_base;
  }

  void restart() {
    found_.reset();
    map_noise_.interrupt();
    finder_.restart();
    claim_.reset();
    lost_because_.reset();
  }

  LocalizationResult process(const LocalizerInput& input) {
    check(input.scan.stamp);
    const double distance = move(input);
    points_ = sampler_.sample(input.scan.cloud, input.p_base_lidar);
    LocalizationResult result = found_ ? follow(input, distance) : search(input, distance);
    result.stamp = input.scan.stamp;
    return result;
  }

  std::vector<MatchedPoint> matched_points() {
    if (!found_) return {};
    return matcher_.weighted(points_, map_.surfaces, found_->estimate().T_map_base);
  }

 private:
  void check(Stamp stamp) {
    if (last_ && stamp <= *last_) {
      throw InputError("the scan at " + std::to_string(stamp) + " ns is not after the one at " +
                       std::to_string(*last_) + " ns; stamps must increase");
    }
    last_ = stamp;
  }

  /// Carries all along by odometry; returns the metres travelled.
  double move(const LocalizerInput& input) {
    if (!has_begun_) {
      has_begun_ = true;
      return 0.0;
    }
    if (!input.is_connected) return interrupt();
    finder_.move(input.T_previous_base, input.covariance);
    if (found_) found_->move(input.T_previous_base, input.covariance);
    map_noise_.move(input.T_previous_base);
    return input.T_previous_base.translation.norm();
  }

  /// Without odometry every place is possible.
  double interrupt() {
    if (found_) give_up("odometry was interrupted");
    finder_.restart();
    return 0.0;
  }

  LocalizationResult follow(const LocalizerInput& input, double distance) {
    const Evidence evidence = found_->update(points_, map_.surfaces, matcher_, distance);
    if (evidence == Evidence::kUnconfirmed) confirm(input, distance);
    if (evidence == Evidence::kAgrees) {
      finder_.restart();
      map_noise_.add_match(found_->estimate().T_map_base);
    }
    LocalizationResult result = described(*found_);
    result.reason = sentence(evidence, found_->match().agreement);
    result.state = evidence == Evidence::kAgrees ? LocalizationState::kFollowing
                                                 : LocalizationState::kBesideMap;
    if (position_stddev(found_->estimate()) > kGreatestStddev) {
      give_up(formatted("the standard deviation of the position is above %.0f m", kGreatestStddev));
    } else if (found_->is_refuted()) {
      give_up(result.reason);
    }
    if (found_) return result;
    result.reason = *lost_because_;
    result.state = LocalizationState::kLost;
    result.hypotheses = 0;
    return result;
  }

  /// A wrong place may agree as well as one that odometry has led to, so it has to be verified
  /// before it is followed again.
  void confirm(const LocalizerInput& input, double distance) {
    const auto confirmed = finder_.confirm(input, found_->match().estimate.T_map_base, distance);
    if (confirmed.outcome == PlaceFinder::Confirmation::kRefused) found_->refuse();
    if (confirmed.outcome == PlaceFinder::Confirmation::kAccepted) {
      found_->verify(confirmed.verified);
    }
  }

  void give_up(const std::string& reason) {
    found_.reset();
    map_noise_.interrupt();
    finder_.restart();
    lost_because_ = reason;
  }

  LocalizationResult search(const LocalizerInput& input, double distance) {
    if (claim_) finder_.claim(*claim_);
    claim_.reset();
    const auto found = finder_.search(input, points_, matcher_, distance);
    LocalizationResult result;
    if (const Hypothesis* best = finder_.hypotheses().best()) result = described(*best);
    result.hypotheses = finder_.hypotheses().size();
    result.probability = finder_.hypotheses().probability();
    result.state = lost_because_ ? LocalizationState::kLost : LocalizationState::kSearching;
    result.reason = lost_because_ ? "searching again: " + *lost_because_ : finder_.reason();
    if (!found) return result;
    found_ = *found;
    finder_.restart();
    lost_because_.reset();
    result.state = LocalizationState::kFollowing;
    result.reason = formatted("the place was found with a probability of %.3f", result.probability);
    return result;
  }

  /// To the covariance of a match belongs that of the map, whatever the number of points.
  LocalizationResult described(const Hypothesis& place) const {
    LocalizationResult result;
    result.T_map_base = place.estimate().T_map_base;
    result.covariance = place.estimate().covariance +
                        diagonal_covariance(map_noise_.stddev(), map_noise_.stddev_angle());
    result.probability = probability_of(place.log_odds());
    result.agreement = place.match().agreement.agreement;
    result.coverage = place.match().agreement.coverage;
    result.hypotheses = 1;
    return result;
  }

  MapParts& map_;
  ScanPointSampler sampler_;
  ScanPoints points_;  ///< of the newest scan
  MapMatcher matcher_;
  PlaceFinder finder_;
  MapNoise map_noise_;
  std::optional<Hypothesis> found_;
  std::optional<Pose> claim_;  ///< of the next scan
  std::optional<std::string> lost_because_;
  std::optional<Stamp> last_;
  bool has_begun_ = false;
};

Localizer::Localizer(MapIndex& map) : impl_(std::make_unique<Impl>(map)) {}
Localizer::~Localizer() = default;

void Localizer::set_initial_pose(const Pose& T_map_base) { impl_->set_initial_pose(T_map_base); }
void Localizer::restart() { impl_->restart(); }
LocalizationResult Localizer::process(const LocalizerInput& input) { return impl_->process(input); }
std::vector<MatchedPoint> Localizer::matched_points() { return impl_->matched_points(); }

}  // namespace lidar_mapping::localization
