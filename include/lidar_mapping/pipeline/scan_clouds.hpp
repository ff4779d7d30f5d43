// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/common/nameless_file.hpp"
#include "lidar_mapping/pipeline/input.hpp"
#include "lidar_mapping/pipeline/scan_track.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

namespace lidar_mapping::pipeline {

/// Clouds that are put aside in a file without a name, which is gone with the process; numbered in
/// the order in which they came.
class ScanClouds : public CloudSource {
 public:
  /// The file is in that folder. Throws FileError.
  explicit ScanClouds(const std::filesystem::path& directory) : file_(directory) {}

  /// Not while another thread asks. Throws FileError.
  void add(const PointCloud& cloud);
  std::size_t size() const { return sizes_.size(); }
  PointCloudPtr cloud(KeyFrameIndex index) override;
  std::vector<PointCloudPtr> clouds(const std::vector<KeyFrameIndex>& indices,
                                    int threads) override;

 private:
  NamelessFile file_;
  std::vector<std::uint64_t> begins_;  ///< points
  std::vector<std::size_t> sizes_;
};

/// Which scans are taken, and how many of their points.
struct ScanSelection {
  int every = 1;            ///< each so many-th scan
  double resolution = 0.0;  ///< m, one point per voxel of this edge; 0: all points
  int threads = 0;
};

/// Reads a recording once more, prepares its scans as `config` says and, with the motion that
/// `scans` know of, takes each to the instant of its stamp. Gives the poses of those that it has
/// added to `clouds`, by their number there. Throws FileError, and InputError if none of the scans
/// is in the recording.
KeyFramePoses add_scans(InputSource& recording, const std::vector<PlacedScan>& scans,
                        const preprocessing::PreprocessingConfig& config,
                        const ScanSelection& selection, ScanClouds& clouds);

}  // namespace lidar_mapping::pipeline
