// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <mutex>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/common/lru_cache.hpp"

namespace lidar_mapping::session {

/// Clouds of key frames in a folder, one file such as 000123.pcd for each. A cache of bounded size
/// holds the clouds used last in memory. A file appears only when it is complete. Thread-safe.
class CloudStore : public ParallelCloudSource {
 public:
  /// Default limit of the cache: 128 MiB, which are about 8 million points. Chosen: reading a cloud
  /// again is cheap, and the graph of a drive of 20 km takes as much.
  static constexpr std::size_t kDefaultCacheBytes = std::size_t{128} << 20U;

  /// Uses `folder`, which is created with the first cloud. `cache_bytes` limits the cache.
  explicit CloudStore(std::filesystem::path folder, std::size_t cache_bytes = kDefaultCacheBytes);

  /// Writes a cloud as binary PCD file with x y z intensity, and caches it. Throws FileError.
  void put(KeyFrameIndex index, const PointCloudPtr& cloud);
  /// Makes the file of a key frame a hard link to the PCD file `existing`, so that its points take
  /// no space twice; a copy where the disk allows no link. Throws FileError.
  void link(KeyFrameIndex index, const std::filesystem::path& existing);
  /// The cloud of a key frame; null if its file is missing or damaged.
  PointCloudPtr cloud(KeyFrameIndex index) override;

  /// Path of the file of a key frame, whether it exists or not.
  std::filesystem::path file(KeyFrameIndex index) const;
  /// True if the file of the key frame exists.
  bool contains(KeyFrameIndex index) const;
  /// True if this same cloud object is in the cache; then it need not be written again.
  bool is_cached(KeyFrameIndex index, const PointCloudPtr& cloud) const;
  /// Memory of the points in the cache; for tests.
  std::size_t cached_bytes() const;
  /// Changes the limit of the cache and removes the oldest clouds above it.
  void set_cache_bytes(std::size_t bytes);

 private:
  PointCloudPtr cached(KeyFrameIndex index);
  void cache(KeyFrameIndex index, const PointCloudPtr& cloud);

  const std::filesystem::path folder_;
  mutable std::mutex mutex_;  ///< guards the cache
  LruCache<KeyFrameIndex, PointCloudPtr> cache_;
};

/// Reads x y z and intensity of a PCD file; the intensity is 0 if the file has none. Throws
/// FileError.
PointCloud read_pcd(const std::filesystem::path& path);
/// Writes a binary PCD file with x y z intensity. The file appears only when it is complete. Throws
/// FileError.
void write_pcd(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace lidar_mapping::session
