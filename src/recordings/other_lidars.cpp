// SPDX-License-Identifier: BSD-3-Clause
#include "other_lidars.hpp"

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::recordings {

const preprocessing::RawScan& OtherCloud::decoded(const ros_border::CloudReader& reader) {
  std::call_once(once_, [&] {
    try {
      scan_ = reader.read(recorded_).scan;
    } catch (const InputError&) {
      scan_.cloud = {};  // the check of the recording reports them
    }
    scan_.stamp = stamp_;
    recorded_ = {};
  });
  return scan_;
}

void OtherLidars::add_lidar(const std::string& topic, const Pose& T_main_other) {
  lidars_[topic].T_main_other = T_main_other;
}

void OtherLidars::add(const std::string& topic, const ros_border::RecordedCloud& cloud,
                      Stamp stamp) {
  Lidar& lidar = lidars_.at(topic);
  lidar.clouds.push_back(std::make_shared<OtherCloud>(cloud, stamp, lidar.T_main_other));
}

OtherClouds OtherLidars::around(Stamp scan) {
  OtherClouds around;
  for (auto& [topic, lidar] : lidars_) {
    auto& clouds = lidar.clouds;
    while (!clouds.empty() && clouds.front()->stamp() < scan - reach_) clouds.pop_front();
    bool is_missed = true;
    for (const auto& cloud : clouds) {
      if (cloud->stamp() > scan + reach_) continue;
      around.push_back(cloud);
      is_missed = false;
    }
    if (is_missed) ++missed_[topic];
  }
  return around;
}

}  // namespace lidar_mapping::recordings
