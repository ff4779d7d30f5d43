// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <list>
#include <mutex>
#include <unordered_map>

#include "lidar_mapping/common/cloud_source.hpp"

namespace lidar_mapping::session {

/// Clouds of key frames as files 000123.pcd in a folder, with a cache of bounded size: the clouds
/// used last stay in memory. Files appear whole or not at all. Any thread may call it.
class CloudStore : public CloudSource {
 public:
  static constexpr std::size_t kDefaultCacheBytes = std::size_t{128} << 20U;

  /// The folder is made with the first cloud.
  explicit CloudStore(std::filesystem::path folder, std::size_t cache_bytes = kDefaultCacheBytes);

  /// Writes the cloud (x y z intensity; binary PCD). Throws FileError.
  void put(KeyFrameIndex index, const PointCloudPtr& cloud);
  /// Null if there is no such file or it is damaged.
  PointCloudPtr cloud(KeyFrameIndex index) override;
  std::vector<PointCloudPtr> clouds(const std::vector<KeyFrameIndex>& indices,
                                    int threads) override;

  std::filesystem::path file(KeyFrameIndex index) const;
  bool contains(KeyFrameIndex index) const;
  /// True if this very cloud was put or given out lately: it need not be written again.
  bool is_cached(KeyFrameIndex index, const PointCloudPtr& cloud) const;
  std::size_t cached_bytes() const;
  /// From now on.
  void set_cache_bytes(std::size_t bytes);

 private:
  struct Entry {
    KeyFrameIndex index;
    PointCloudPtr cloud;
  };
  PointCloudPtr cached(KeyFrameIndex index);
  void cache(KeyFrameIndex index, const PointCloudPtr& cloud);
  void evict_oldest();

  const std::filesystem::path folder_;
  mutable std::mutex mutex_;  ///< guards what follows
  std::size_t cache_bytes_;
  std::list<Entry> newest_first_;
  std::unordered_map<KeyFrameIndex, std::list<Entry>::iterator> entries_;
  std::size_t bytes_ = 0;
};

/// Reads a PCD file with fields x y z and, if there is one, intensity. Throws FileError.
PointCloud read_pcd(const std::filesystem::path& path);
/// Writes a binary PCD file with fields x y z intensity, atomically. Throws FileError.
void write_pcd(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace lidar_mapping::session
