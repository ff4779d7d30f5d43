// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/loop_closing/place_verifier.hpp"

#include "lidar_mapping/loop_closing/above_ground.hpp"

#include "decision/verified_candidate.hpp"
#include "matching/scan_alignment.hpp"
#include "matching/submap_builder.hpp"
#include "sight.hpp"

namespace lidar_mapping::loop_closing {

class PlaceVerifier::Impl {
 public:
  Impl(const LoopClosingConfig& config, CloudSource& clouds,
       const std::vector<KeyFrame>& key_frames, const Eigen::Vector3d& p_base_lidar)
      : config_(config), submaps_(config, clouds), alignment_(config) {
    submaps_.set_sensor_origin(p_base_lidar);
    for (const KeyFrame& key_frame : key_frames) trajectory_.append(key_frame);
  }

  void add_view(std::size_t place, const Points& points) {
    submaps_.add_view(trajectory_[place].segment, points);
  }

  void set_query(const PlaceQuery& query) {
    query_.points = query.surroundings;
    query_.above_ground = above_ground(query_.points);
    query_.sight = range_of_sight({query.scan, above_ground(query.scan)});
    query_.image = FreeSpaceImage(query.scan, query.p_base_lidar.cast<float>());
  }

  std::optional<PlaceMatch> match(std::size_t place, const Pose& T_place_scan_guess) {
    const auto submap = submaps_.around(trajectory_, place);
    if (submap == nullptr) return std::nullopt;
    Candidate candidate;
    candidate.node = place;
    candidate.source = LoopSource::kAppearance;
    candidate.T_from_to = T_place_scan_guess;
    const VerifiedCandidate result = verified(candidate, query_, *submap, config_, alignment_);
    if (!result.is_accepted()) return std::nullopt;
    const Alignment& alignment = result.match.alignment;
    return PlaceMatch{
        alignment.T_target_source,
        alignment.covariance + diagonal_covariance(config_.min_stddev_x, config_.min_stddev_q)};
  }

 private:
  const LoopClosingConfig config_;
  Trajectory trajectory_;
  SubmapBuilder submaps_;
  ScanAlignment alignment_;
  QueryScan query_;
};

PlaceVerifier::PlaceVerifier(const LoopClosingConfig& config, CloudSource& clouds,
                             const std::vector<KeyFrame>& key_frames,
                             const Eigen::Vector3d& p_base_lidar)
    : impl_(std::make_unique<Impl>(config, clouds, key_frames, p_base_lidar)) {}
PlaceVerifier::~PlaceVerifier() = default;

void PlaceVerifier::add_view(std::size_t place, const Points& points) {
  impl_->add_view(place, points);
}
void PlaceVerifier::set_query(const PlaceQuery& query) { impl_->set_query(query); }
std::optional<PlaceMatch> PlaceVerifier::match(std::size_t place, const Pose& T_place_scan_guess) {
  return impl_->match(place, T_place_scan_guess);
}

}  // namespace lidar_mapping::loop_closing
