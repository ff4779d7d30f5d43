// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/scan_assembler.hpp"

#include <iterator>
#include <string>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/front_end/prior_of.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// A scan does not wait for an external odometry that lags by more than this number of scans.
/// Chosen: 5 s at 10 Hz; bounds the memory.
constexpr std::size_t kMostWaiting = 50;
/// An input is taken as lost after this number of newer scans. Chosen: 1 s with most sensors.
constexpr std::size_t kLost = 10;
/// s: longest gap of the external odometry over which poses are interpolated. Chosen: a vehicle
/// changes its motion within a second.
constexpr double kLongestGap = 0.5;
/// Largest numbers of samples, and of poses of an external odometry, that are kept without a scan.
/// Chosen: 20 s at 10 Hz, and 25 s at 200 Hz; bounds the memory.
constexpr std::size_t kMostSamples = 200;
constexpr std::size_t kMostOdometry = 5000;

}  // namespace

template <typename Sample>
void ScanAssembler::Stream<Sample>::add(Stamp stamp, const Sample& sample) {
  expected = true;
  samples[stamp] = sample;
  if (samples.size() > kMostSamples) samples.erase(samples.begin());
}

template <typename Sample>
bool ScanAssembler::Stream<Sample>::complete_for(Stamp stamp, bool last_chance) {
  if (has(stamp) || !expected) return true;
  if (last_chance) expected = false;
  return last_chance;
}

template <typename Sample>
std::optional<Sample> ScanAssembler::Stream<Sample>::take(Stamp stamp) {
  const auto found = samples.find(stamp);
  std::optional<Sample> sample;
  if (found != samples.end()) sample = found->second;
  samples.erase(samples.begin(), samples.upper_bound(stamp));
  return sample;
}

ScanAssembler::ScanAssembler(bool external_odometry) : external_odometry_(external_odometry) {}

void ScanAssembler::add_inputs(Stamp stamp, const SyncedInputs& inputs) {
  inputs_.add(stamp, inputs);
}

void ScanAssembler::add_imu(const ImuSample& sample_base) {
  imu_.add(sample_base.stamp, sample_base);
}

void ScanAssembler::add_velocity(const VelocitySample& sample_base) {
  velocity_.add(sample_base.stamp, sample_base);
}

void ScanAssembler::add_gnss(const GnssPosition& position) { gnss_.add(position.stamp, position); }

void ScanAssembler::add_odometry(Stamp stamp, const Pose& T_external_base) {
  odometry_[stamp] = T_external_base;
  if (odometry_.size() > kMostOdometry) odometry_.erase(odometry_.begin());
}

void ScanAssembler::add_scan(Scan scan) {
  if (newest_ && scan.stamp <= *newest_) {
    throw InputError("the stamp of a scan goes back by " +
                     std::to_string(to_seconds(*newest_ - scan.stamp)) +
                     " s; to map another drive start the nodes again");
  }
  newest_ = scan.stamp;
  waiting_.push_back(std::move(scan));
}

std::vector<AssembledScan> ScanAssembler::take_ready() {
  std::vector<AssembledScan> out;
  while (!waiting_.empty() && ready(waiting_.front().stamp)) emit_first(out);
  return out;
}

std::vector<AssembledScan> ScanAssembler::flush() {
  std::vector<AssembledScan> out;
  while (!waiting_.empty()) {
    inputs_.complete_for(waiting_.front().stamp, true);
    emit_first(out);
  }
  return out;
}

bool ScanAssembler::ready(Stamp stamp) {
  if (external_odometry_ && !odometry_ready(stamp)) return false;
  const bool is_lost = waiting_.size() > kLost;
  if (!inputs_.complete_for(stamp, is_lost)) return false;
  if (inputs_.has(stamp)) return is_lost || has_named_samples(stamp, inputs_.samples.at(stamp));
  const bool next_is_there = waiting_.size() > 1;
  const bool imu = imu_.complete_for(stamp, next_is_there);
  const bool velocity = velocity_.complete_for(stamp, next_is_there);
  const bool gnss = gnss_.complete_for(stamp, next_is_there);
  return imu && velocity && gnss;
}

/// The front end uses only the first pose of GNSS.
bool ScanAssembler::has_named_samples(Stamp stamp, const SyncedInputs& inputs) const {
  return (!inputs.imu || imu_.has(stamp)) && (!inputs.velocity || velocity_.has(stamp)) &&
         (!inputs.gnss || has_begun_ || gnss_.has(stamp));
}

bool ScanAssembler::odometry_ready(Stamp stamp) const {
  return waiting_.size() > kMostWaiting || odometry_.lower_bound(stamp) != odometry_.end();
}

void ScanAssembler::emit_first(std::vector<AssembledScan>& out) {
  const Stamp stamp = waiting_.front().stamp;
  AssembledScan assembled{std::move(waiting_.front()), {}};
  waiting_.pop_front();
  has_begun_ = true;
  SyncedInputs inputs = inputs_.take(stamp).value_or(SyncedInputs{});
  const auto imu = imu_.take(stamp);
  const auto velocity = velocity_.take(stamp);
  if ((inputs.imu && !imu) || (inputs.velocity && !velocity)) ++without_samples_;
  assembled.prior = front_end::prior_of(imu, velocity, std::move(inputs.uneven_turning),
                                        inputs.felt, inputs.fingerprint);
  if (const auto gnss = gnss_.take(stamp)) assembled.prior.T_odom_base_initial = gnss->T_enu_base();
  if (external_odometry_) {
    assembled.prior.T_external_base = odometry_at(stamp);
    if (!assembled.prior.T_external_base) {
      ++without_odometry_;
      return;
    }
  }
  out.push_back(std::move(assembled));
}

std::optional<Pose> ScanAssembler::odometry_at(Stamp stamp) const {
  const auto after = odometry_.lower_bound(stamp);
  if (after == odometry_.end()) return std::nullopt;
  if (after->first == stamp) return after->second;
  if (after == odometry_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  return pose_between({before->first, before->second}, {after->first, after->second}, stamp,
                      kLongestGap);
}

}  // namespace lidar_mapping::ros_border
