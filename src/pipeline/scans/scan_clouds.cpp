// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/scan_clouds.hpp"

#include <memory>

#include "lidar_mapping/common/elevation_shift.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/sorted_values.hpp"
#include "lidar_mapping/common/voxel_filter.hpp"
#include "lidar_mapping/front_end/deskew.hpp"

#include "scans/scan_preparation.hpp"

namespace lidar_mapping::pipeline {

namespace {

// other sensors are delayed, and preprocessing has to initialise
constexpr Stamp kTimeMargin = from_seconds(20.0);

/// Receives preprocessed scans, and adds those that are selected.
class ScanCollector {
 public:
  ScanCollector(const std::vector<ScanPose>& scans, const ScanSelection& selection,
                ScanClouds& clouds)
      : scans_(scans), selection_(selection), clouds_(clouds) {}

  void add(preprocessing::SyncedScan&& synced) {
    const Stamp stamp = synced.scan.stamp;
    const auto found = first_not_before(scans_, stamp);
    if (found == scans_.end() || found->stamp != stamp) return;
    if (count_++ % selection_.every != 0) return;
    Vector6d acceleration = found->acceleration;
    // The gyro has made the rotation uniform (preprocessing::SyncedScan).
    if (synced.uneven_turning) acceleration.tail<3>().setZero();
    // Before deskewing, as the front end does with key frames.
    rotate_upwards(synced.scan.cloud, found->elevation_shift);
    const PointCloud deskewed_cloud =
        front_end::deskewed(transformed(synced.scan.cloud, synced.T_base_lidar), found->twist,
                            acceleration, selection_.threads);
    const auto number = static_cast<KeyFrameIndex>(clouds_.size());
    clouds_.add(voxel_filtered(deskewed_cloud, selection_.resolution));
    poses_.poses.push_back({number, stamp, found->T_map_base});
  }

  const KeyFramePoses& poses() const { return poses_; }

 private:
  const std::vector<ScanPose>& scans_;
  const ScanSelection selection_;
  ScanClouds& clouds_;
  int count_ = 0;
  KeyFramePoses poses_;
};

}  // namespace

void ScanClouds::add(const PointCloud& cloud) {
  const std::uint64_t begin = begins_.empty() ? 0 : begins_.back() + sizes_.back();
  file_.write(begin * sizeof(Point), cloud.points.data(), cloud.size() * sizeof(Point));
  begins_.push_back(begin);
  sizes_.push_back(cloud.size());
}

PointCloudPtr ScanClouds::cloud(KeyFrameIndex index) {
  if (index >= sizes_.size()) return nullptr;
  auto cloud = std::make_shared<PointCloud>();
  cloud->points.resize(sizes_[index]);
  file_.read(begins_[index] * sizeof(Point), cloud->points.data(), sizes_[index] * sizeof(Point));
  return cloud;
}

KeyFramePoses add_scans(InputSource& recording, const std::vector<ScanPose>& scans,
                        const preprocessing::PreprocessingConfig& config,
                        const ScanSelection& selection, ScanClouds& clouds) {
  ScanCollector collector(scans, selection, clouds);
  CloudPool pool;
  ScanPreparation preparation(
      config, [&](const std::string& frame) { return recording.T_base(frame); }, pool,
      [&](PreparedScan&& scan) { collector.add(std::move(scan.synced)); },
      [](const std::string& /*notice*/) {});  // was reported when the drive was mapped
  if (!scans.empty()) {
    const Stamp first = scans.front().stamp - kTimeMargin;
    const Stamp last = scans.back().stamp + kTimeMargin;
    recording.skip_to(first);
    while (auto datum = recording.next()) {
      const auto* scan = std::get_if<RecordedScan>(&*datum);
      if (scan != nullptr && (scan->stamp < first || scan->stamp > last)) continue;
      preparation.add(std::move(*datum));
    }
    preparation.flush();
  }
  if (collector.poses().poses.empty()) {
    throw InputError("none of the session's " + std::to_string(scans.size()) +
                     " scans is in the recording; name the one that it was made of");
  }
  return collector.poses();
}

}  // namespace lidar_mapping::pipeline
