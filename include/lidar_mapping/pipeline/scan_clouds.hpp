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

/// Clouds that are stored in an unnamed temporary file, which disappears with the process. They are
/// numbered in the order in which they were added.
class ScanClouds : public ParallelCloudSource {
 public:
  /// Creates the file in `directory`. Throws FileError.
  explicit ScanClouds(const std::filesystem::path& directory) : file_(directory) {}

  /// Appends a cloud. Must not be called while another thread reads. Throws FileError.
  void add(const PointCloud& cloud);
  /// Number of clouds.
  std::size_t size() const { return sizes_.size(); }
  /// The cloud of this number; null if there is none. Throws FileError.
  PointCloudPtr cloud(KeyFrameIndex index) override;

 private:
  NamelessFile file_;
  std::vector<std::uint64_t> begins_;  ///< Position of each cloud in the file, in points.
  std::vector<std::size_t> sizes_;     ///< Number of points of each cloud.
};

/// Which scans are added, and how many of their points.
struct ScanSelection {
  int every = 1;            ///< Adds every n-th scan.
  double resolution = 0.0;  ///< Edge of the voxels of which each keeps one point, m; 0: all points.
  int threads = 0;          ///< Upper limit of threads; 0: all cores.
};

/// Reads a recording again, preprocesses its scans according to `config`, deskews each to its stamp
/// with the motion given in `scans`, and adds them to `clouds`. Returns the poses of the added
/// scans, with their numbers in `clouds` as indices. Throws FileError, and InputError if none of
/// the scans is in the recording.
KeyFramePoses add_scans(InputSource& recording, const std::vector<ScanPose>& scans,
                        const preprocessing::PreprocessingConfig& config,
                        const ScanSelection& selection, ScanClouds& clouds);

}  // namespace lidar_mapping::pipeline
