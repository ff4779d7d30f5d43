#include "lidar_mapping/front_end/imu_track.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::front_end {
namespace {

/// Nobody asks for older samples: a map that was lost for seconds does not need them.
constexpr Stamp kHorizon = from_seconds(10.0);
constexpr double kLearningRate = 0.1;
/// A gap of so many periods is one; IMUs drop a sample now and then.
constexpr Stamp kLongestGap = 4;
/// Twice the same value to that share is no coincidence where the value moves with noise.
constexpr double kSameValue = 1e-9;
/// A sensor at rest may show the same value twice: limits lie far above it.
constexpr double kLeastRateLimit = 1.0;    // rad/s
constexpr double kLeastForceLimit = 15.0;  // m/s^2

bool is_before(const ImuSample& sample, Stamp stamp) { return sample.stamp < stamp; }

Eigen::Vector3d mixed(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double f) {
  return a + f * (b - a);
}

/// Whether one axis shows its largest value again.
bool stands_at_limit(const Eigen::Vector3d& value, double least, Eigen::Vector3d& largest,
                     Eigen::Vector3d& last) {
  bool stands = false;
  for (int axis = 0; axis < 3; ++axis) {
    const double size = std::abs(value[axis]);
    const bool is_same = std::abs(value[axis] - last[axis]) <= kSameValue * size;
    largest[axis] = std::max(largest[axis], size);
    stands = stands || (is_same && size >= least && size >= (1.0 - kSameValue) * largest[axis]);
  }
  last = value;
  return stands;
}

}  // namespace

void ImuTrack::mark_clipped(const ImuSample& sample) {
  const bool rate =
      stands_at_limit(sample.angular_velocity, kLeastRateLimit, rate_.largest, rate_.last);
  const bool force =
      stands_at_limit(sample.linear_acceleration, kLeastForceLimit, force_.largest, force_.last);
  // The second of two equal values shows that the first one was clipped, too.
  if (rate && !rate_clipped_.empty()) rate_clipped_.back() = true;
  if (force && !force_clipped_.empty()) force_clipped_.back() = true;
  rate_clipped_.push_back(rate);
  force_clipped_.push_back(force || !sample.has_linear_acceleration);
}

void ImuTrack::add(const ImuStretch& stretch) {
  p_base_imu_ = stretch.p_base_imu;
  for (ImuSample sample : stretch.samples) {
    sample.stamp -= delay_;
    if (!sample.has_angular_velocity) continue;
    if (!samples_.empty() && sample.stamp <= samples_.back().stamp) continue;
    if (!samples_.empty()) {
      const Stamp step = sample.stamp - samples_.back().stamp;
      if (period_ == 0) period_ = step;
      if (step < kLongestGap * period_) {
        period_ += static_cast<Stamp>(kLearningRate * static_cast<double>(step - period_));
      }
    }
    mark_clipped(sample);
    samples_.push_back(sample);
  }
  if (!samples_.empty()) forget_before(samples_.back().stamp - kHorizon);
}

void ImuTrack::forget_before(Stamp stamp) {
  while (samples_.size() > 1 && samples_[1].stamp <= stamp) {
    samples_.pop_front();
    rate_clipped_.pop_front();
    force_clipped_.pop_front();
  }
}

void ImuTrack::clear() { *this = ImuTrack(); }

bool ImuTrack::covers(Stamp begin, Stamp end) const {
  if (samples_.size() < 2 || samples_.front().stamp > begin + period_ ||
      samples_.back().stamp + period_ + std::max<Stamp>(0, delay_) < end) {
    return false;
  }
  auto sample = std::lower_bound(samples_.begin(), samples_.end(), begin, is_before);
  if (sample != samples_.begin()) --sample;
  for (; std::next(sample) != samples_.end() && sample->stamp < end; ++sample) {
    if (std::next(sample)->stamp - sample->stamp > kLongestGap * period_) return false;
  }
  return true;
}

bool ImuTrack::is_clipped(Stamp begin, Stamp end, Eigen::Vector3d ImuSample::*value) const {
  const auto& clipped = value == &ImuSample::angular_velocity ? rate_clipped_ : force_clipped_;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    if (clipped[i] && samples_[i].stamp >= begin && samples_[i].stamp <= end) return true;
  }
  return false;
}

ImuSample ImuTrack::at(Stamp stamp) const {
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), stamp, is_before);
  ImuSample result;
  if (after == samples_.begin() || after == samples_.end()) {
    result = after == samples_.end() ? samples_.back() : samples_.front();
    result.stamp = stamp;
    return result;
  }
  const ImuSample& a = *std::prev(after);
  const ImuSample& b = *after;
  const double f = static_cast<double>(stamp - a.stamp) / static_cast<double>(b.stamp - a.stamp);
  result.stamp = stamp;
  result.angular_velocity = mixed(a.angular_velocity, b.angular_velocity, f);
  result.linear_acceleration = mixed(a.linear_acceleration, b.linear_acceleration, f);
  result.has_linear_acceleration = a.has_linear_acceleration && b.has_linear_acceleration;
  return result;
}

std::vector<ImuSample> ImuTrack::between(Stamp begin, Stamp end) const {
  std::vector<ImuSample> result{at(begin)};
  for (auto s = std::lower_bound(samples_.begin(), samples_.end(), begin + 1, is_before);
       s != samples_.end() && s->stamp < end; ++s) {
    result.push_back(*s);
  }
  result.push_back(at(end));
  return result;
}

}  // namespace lidar_mapping::front_end
