#include "lidar_mapping/front_end/ndt_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/LU>

#include "lidar_mapping/front_end/key_frame_rule.hpp"
#include "lidar_mapping/front_end/local_map.hpp"
#include "lidar_mapping/front_end/motion_filter.hpp"
#include "lidar_mapping/front_end/pose_search.hpp"
#include "lidar_mapping/front_end/scan_sampler.hpp"

namespace lidar_mapping::front_end {
namespace {

using registration::MotionBelief;
using registration::NdtMatch;
using registration::NdtMatcher;
using registration::NdtOptions;
using registration::NdtPoints;

/// So many points of a scan are looked at for matching; of more only a part.
constexpr std::size_t kCandidates = 16000;
/// The first scans are put into the map wherever they are.
constexpr int kFirstScans = 3;

std::size_t odd_stride(std::size_t points) {
  // Odd, so that it visits all rings of a cloud that is stored firing by firing.
  return (points / kCandidates) | 1U;
}

}  // namespace

class NdtTracker::Impl {
 public:
  explicit Impl(const FrontEndConfig& config)
      : config_(config),
        map_(config.voxel_size, config.local_map_radius),
        filter_(config.acceleration_sigma, config.angular_acceleration_sigma),
        search_(NdtOptions{}) {}

  TrackedScan track(const Scan& scan, const MotionPrior& prior) {
    take_sample(scan);
    if (scans_ == 0) return begin(scan, prior);
    filter_.predict(to_seconds(scan.stamp - stamp_) + offset_ - last_offset_);
    NdtMatch match = scans_ == 1 ? first_match(scan) : find();
    TrackedScan result;
    filter_.set(match.state, match.information.inverse());
    result.status.converged = match.converged;
    result.status.iterations = match.iterations;
    result.status.fitness = match.fitness;
    result.status.inlier_fraction = match.inlier_fraction;
    result.status.overlap = match.overlap;
    result.status.rescued = rescued_;
    keep(scan);
    finish(scan, result);
    return result;
  }

  void restart(const Pose& T_odom_base) {
    map_.clear();
    start_ = T_odom_base;
    scans_ = 0;
  }

  PointCloud local_map() const { return map_.cloud(); }

 private:
  void take_sample(const Scan& scan) {
    SamplingOptions options;
    options.resolution = config_.scan_resolution;
    options.max_range = config_.max_range;
    options.stride = odd_stride(scan.cloud.size());
    options.phase = static_cast<std::size_t>(scans_) % options.stride;
    sampler_.sample(scan.cloud, options, sample_);
    last_offset_ = offset_;
    offset_ = 0.0;
    if (sample_.size() > 0) {
      const auto [first, last] = std::minmax_element(sample_.s.begin(), sample_.s.end());
      offset_ = 0.5 * (*first + *last);
    }
    for (float& s : sample_.s) s -= static_cast<float>(offset_);
    points_.assign(sample_.x, sample_.y, sample_.z, sample_.s);
  }

  void take_dense_sample(const Scan& scan) {
    SamplingOptions options;
    options.resolution = config_.insertion_resolution;
    options.max_range = config_.max_range;
    dense_sampler_.sample(scan.cloud, options, dense_);
    for (float& s : dense_.s) s -= static_cast<float>(offset_);
  }

  TrackedScan begin(const Scan& scan, const MotionPrior& prior) {
    if (prior.T_odom_base_initial) start_ = *prior.T_odom_base_initial;
    filter_.reset(start_, 15.0, 1.0);
    keep(scan);
    first_ = dense_;
    first_offset_ = offset_;
    TrackedScan result;
    finish(scan, result);
    return result;
  }

  NdtMatch first_match(const Scan& scan) {
    const double dt = to_seconds(scan.stamp - stamp_);
    std::vector<MotionState> starts;
    const MotionState rest = filter_.state();
    starts.push_back(rest);
    for (double distance = 0.75; distance < 35.0 * dt; distance += 0.75) {
      for (const double sign : {1.0, -0.4}) {
        Vector6d d = Vector6d::Zero();
        d[0] = sign * distance;
        MotionState start = rest;
        start.T_map_sensor = perturbed(rest.T_map_sensor, d);
        start.twist = d / dt;
        starts.push_back(start);
      }
    }
    NdtMatch match = search_.search(points_, map_, filter_.belief(), starts);
    if (!scan.cloud.has_times()) return match;
    for (int i = 0; i < 3; ++i) {
      map_.clear();
      MotionState first{moved(start_, match.state.twist, first_offset_), match.state.twist};
      map_.insert(first_, first);
      match = matcher_.match(points_, map_.fine(), filter_.belief(), match.state, NdtOptions{});
    }
    return match;
  }

  NdtMatch find() {
    rescued_ = false;
    const MotionBelief prior = filter_.belief();
    few_.assign_thinned(points_, 8);
    NdtOptions wide;
    wide.kernel *= 3.0;
    const NdtMatch quick = matcher_.evaluate(few_, map_.fine(), prior.state, wide);
    MotionState start = prior.state;
    if (quick.quality < 0.75 * usual_quick_) start = search_.approach(points_, map_, prior, start);
    usual_quick_ += 0.1 * (quick.quality - usual_quick_);
    NdtMatch match = matcher_.match(points_, map_.fine(), prior, start, NdtOptions{});
    if (match.quality < 0.75 * usual_quality_) {
      rescued_ = true;
      std::vector<MotionState> starts;
      starts.push_back(prior.state);
      for (double x = -2.4; x <= 6.0; x += 1.5) {
        for (double yaw = -0.6; yaw < 0.61; yaw += 0.2) {
          Vector6d d = Vector6d::Zero();
          d[0] = x;
          d[5] = yaw;
          MotionState s = prior.state;
          s.T_map_sensor = perturbed(filter_.state().T_map_sensor, d);
          starts.push_back(s);
        }
      }
      const NdtMatch found = search_.search(points_, map_, prior, starts);
      if (found.quality > 1.1 * match.quality) match = found;
    }
    usual_quality_ += 0.1 * (match.quality - usual_quality_);
    return match;
  }

  void keep(const Scan& scan) {
    const Pose& now = filter_.state().T_map_sensor;
    if (scans_ >= kFirstScans && !insertion_rule_.reached(inserted_.inverse() * now, 0)) return;
    take_dense_sample(scan);
    map_.insert(dense_, filter_.state());
    inserted_ = now;
  }

  void finish(const Scan& scan, TrackedScan& result) {
    const MotionState& state = filter_.state();
    result.T_odom_base = moved(state.T_map_sensor, state.twist, -offset_);
    result.twist = state.twist;
    result.covariance = filter_.covariance().topLeftCorner<6, 6>();
    map_.follow(state.T_map_sensor.translation);
    stamp_ = scan.stamp;
    ++scans_;
  }

  FrontEndConfig config_;
  LocalMap map_;
  MotionFilter filter_;
  PoseSearch search_;
  NdtMatcher matcher_;
  ScanSampler sampler_{15};
  ScanSampler dense_sampler_{17};
  KeyFrameRule insertion_rule_{2.0, 0.1, 0.0};
  SampledPoints sample_, dense_, first_;
  NdtPoints points_, few_;
  Pose start_, inserted_;
  Stamp stamp_ = 0;
  double offset_ = 0.0, last_offset_ = 0.0, first_offset_ = 0.0;
  int scans_ = 0;
  bool rescued_ = false;
  double usual_quality_ = 0.0;
  double usual_quick_ = 0.0;
};

NdtTracker::NdtTracker(const FrontEndConfig& config) : impl_(std::make_unique<Impl>(config)) {}
NdtTracker::~NdtTracker() = default;
TrackedScan NdtTracker::track(const Scan& scan, const MotionPrior& prior) {
  return impl_->track(scan, prior);
}
void NdtTracker::restart(const Pose& T_odom_base) { impl_->restart(T_odom_base); }
PointCloud NdtTracker::local_map() const { return impl_->local_map(); }

}  // namespace lidar_mapping::front_end
