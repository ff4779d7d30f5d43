#include "lidar_mapping/ros/scan_assembler.hpp"

#include <iterator>
#include <string>
#include <utility>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// An outside odometry that lags more than so many scans is not waited for.
constexpr std::size_t kMostWaiting = 50;
/// No pose is made up over a longer gap of the outside odometry.
constexpr Stamp kLongestGap = from_seconds(0.5);
/// Samples without a scan are forgotten beyond this number.
constexpr std::size_t kMostSamples = 200;
constexpr std::size_t kMostOdometry = 5000;

/// Pose of base_link in East-North-Up, where position and heading are both known.
std::optional<Pose> pose_from(const std::optional<GnssPosition>& gnss) {
  if (!gnss || !gnss->R_enu_base) return std::nullopt;
  const Eigen::Quaterniond& R_enu_base = *gnss->R_enu_base;
  return Pose{R_enu_base, gnss->p_enu_antenna - R_enu_base * gnss->p_base_antenna};
}

}  // namespace

template <typename Sample>
void ScanAssembler::Stream<Sample>::add(Stamp stamp, const Sample& sample) {
  expected = true;
  samples[stamp] = sample;
  if (samples.size() > kMostSamples) samples.erase(samples.begin());
}

template <typename Sample>
bool ScanAssembler::Stream<Sample>::complete_for(Stamp stamp, bool last_chance) {
  if (samples.count(stamp) > 0 || !expected) return true;
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

void ScanAssembler::add_imu(const ImuSample& sample_base) {
  imu_.add(sample_base.stamp, sample_base);
}

void ScanAssembler::add_imu(Stamp stamp, const ImuStretch& stretch) {
  imu_stretches_.add(stamp, stretch);
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
  while (!waiting_.empty() && ready(waiting_.front(), waiting_.size() > 1)) emit_first(out);
  return out;
}

std::vector<AssembledScan> ScanAssembler::flush() {
  std::vector<AssembledScan> out;
  while (!waiting_.empty()) emit_first(out);
  return out;
}

bool ScanAssembler::ready(const Scan& scan, bool next_is_there) {
  if (external_odometry_ && !odometry_ready(scan.stamp)) return false;
  const bool imu = imu_.complete_for(scan.stamp, next_is_there);
  const bool stretch = imu_stretches_.complete_for(scan.stamp, next_is_there);
  const bool velocity = velocity_.complete_for(scan.stamp, next_is_there);
  const bool gnss = gnss_.complete_for(scan.stamp, next_is_there);
  return imu && stretch && velocity && gnss;
}

bool ScanAssembler::odometry_ready(Stamp stamp) const {
  return waiting_.size() > kMostWaiting || odometry_.lower_bound(stamp) != odometry_.end();
}

/// With the samples of scans that never came: the way to this one leads through them.
std::optional<ImuStretch> ScanAssembler::take_stretch(Stamp stamp) {
  std::optional<ImuStretch> whole;
  auto& stretches = imu_stretches_.samples;
  const auto end = stretches.upper_bound(stamp);
  for (auto it = stretches.begin(); it != end; ++it) {
    std::vector<ImuSample> samples = whole ? std::move(whole->samples) : std::vector<ImuSample>{};
    samples.insert(samples.end(), it->second.samples.begin(), it->second.samples.end());
    whole = std::move(it->second);
    whole->samples = std::move(samples);
    if (it->first != stamp) whole->uniform_rate.reset();
  }
  stretches.erase(stretches.begin(), end);
  return whole;
}

void ScanAssembler::emit_first(std::vector<AssembledScan>& out) {
  const Stamp stamp = waiting_.front().stamp;
  AssembledScan assembled{std::move(waiting_.front()), {}};
  waiting_.pop_front();
  const auto imu = imu_.take(stamp);
  if (imu && imu->has_angular_velocity) assembled.prior.angular_velocity = imu->angular_velocity;
  assembled.prior.imu = take_stretch(stamp);
  if (const auto velocity = velocity_.take(stamp)) {
    assembled.prior.linear_velocity = velocity->linear;
  }
  assembled.prior.T_odom_base_initial = pose_from(gnss_.take(stamp));
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
  const Stamp gap = after->first - before->first;
  if (gap > kLongestGap) return std::nullopt;
  return interpolate(before->second, after->second,
                     to_seconds(stamp - before->first) / to_seconds(gap));
}

}  // namespace lidar_mapping::ros_border
