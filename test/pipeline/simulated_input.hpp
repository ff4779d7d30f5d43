// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "lidar_mapping/pipeline/input.hpp"
#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::test {

/// A simulated drive as an input source, as if it had been recorded.
class SimulatedInput : public pipeline::InputSource {
 public:
  explicit SimulatedInput(const simulation::DriveOptions& options)
      : drive_(std::make_shared<simulation::Drive>(options)) {
    for (std::size_t i = 0; i < drive_->scan_count(); ++i) add_scan(i);
    for (const ImuSample& sample : drive_->imu()) add(sample, "imu");
    for (const VelocitySample& sample : drive_->velocity()) add(sample, "imu");
    for (const GnssFix& fix : drive_->gnss()) add(fix, "antenna");
    std::stable_sort(inputs_.begin(), inputs_.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
  }

  std::optional<pipeline::Input> next() override {
    if (next_ == inputs_.size()) return std::nullopt;
    return inputs_[next_++].second;
  }
  void skip_to(Stamp stamp) override {
    for (next_ = 0; next_ < inputs_.size() && inputs_[next_].first < stamp;) ++next_;
  }
  Stamp begin() const override { return inputs_.front().first; }
  Stamp end() const override { return inputs_.back().first; }
  std::optional<Pose> T_base(const std::string& frame_id) const override {
    const simulation::SensorMounting& mounting = drive_->mounting();
    if (frame_id == "lidar") return mounting.T_base_lidar;
    if (frame_id == "imu") return mounting.T_base_imu;
    return Pose{Eigen::Quaterniond::Identity(), mounting.p_base_antenna};
  }

  const simulation::Drive& drive() const { return *drive_; }

 private:
  void add_scan(std::size_t index) {
    const Stamp stamp = drive_->scan_stamp(index);
    const auto decode = [drive = drive_, index](const PointCloud&) {
      simulation::SimulatedScan scan = drive->scan(index);
      return preprocessing::RawScan{scan.stamp, "lidar", std::move(scan.cloud), false};
    };
    inputs_.emplace_back(stamp + from_seconds(0.1), pipeline::RecordedScan{stamp, decode});
  }
  template <typename Sample>
  void add(const Sample& sample, const char* frame) {
    inputs_.emplace_back(sample.stamp, pipeline::FramedSample<Sample>{sample, frame});
  }

  std::shared_ptr<const simulation::Drive> drive_;
  /// With the time of their delivery, in its order.
  std::vector<std::pair<Stamp, pipeline::Input>> inputs_;
  std::size_t next_ = 0;
};

}  // namespace lidar_mapping::test
