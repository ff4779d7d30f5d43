// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/session/cloud_store.hpp"

#include <system_error>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::session {

CloudStore::CloudStore(std::filesystem::path folder, std::size_t cache_bytes)
    : folder_(std::move(folder)), cache_(cache_bytes) {}

void CloudStore::put(KeyFrameIndex index, const PointCloudPtr& cloud) {
  write_pcd(file(index), *cloud);
  cache(index, cloud);
}

void CloudStore::link(KeyFrameIndex index, const std::filesystem::path& existing) {
  namespace fs = std::filesystem;
  const fs::path linked = file(index);
  std::error_code failure;
  fs::create_directories(folder_, failure);
  fs::remove(linked, failure);
  fs::create_hard_link(existing, linked, failure);
  if (!failure) return;
  fs::copy_file(existing, linked, failure);
  if (!failure) return;
  throw FileError("cannot copy " + existing.string() + " to " + linked.string() + ": " +
                  failure.message() + "; check the path and the free space");
}

PointCloudPtr CloudStore::cloud(KeyFrameIndex index) {
  if (PointCloudPtr known = cached(index)) return known;
  if (!contains(index)) return nullptr;
  try {
    auto loaded = std::make_shared<const PointCloud>(read_pcd(file(index)));
    cache(index, loaded);
    return loaded;
  } catch (const std::exception&) {
    return nullptr;
  }
}

std::filesystem::path CloudStore::file(KeyFrameIndex index) const {
  return folder_ / formatted("%06u.pcd", index);
}

bool CloudStore::contains(KeyFrameIndex index) const {
  return std::filesystem::is_regular_file(file(index));
}

bool CloudStore::is_cached(KeyFrameIndex index, const PointCloudPtr& cloud) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const PointCloudPtr* known = cache_.peek(index);
  return known != nullptr && *known == cloud;
}

std::size_t CloudStore::cached_bytes() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return cache_.weight();
}

PointCloudPtr CloudStore::cached(KeyFrameIndex index) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const PointCloudPtr* known = cache_.find(index);
  return known != nullptr ? *known : nullptr;
}

void CloudStore::cache(KeyFrameIndex index, const PointCloudPtr& cloud) {
  const std::lock_guard<std::mutex> lock(mutex_);
  cache_.insert(index, cloud, cloud->size() * sizeof(Point));
}

void CloudStore::set_cache_bytes(std::size_t bytes) {
  const std::lock_guard<std::mutex> lock(mutex_);
  cache_.set_capacity(bytes);
}

}  // namespace lidar_mapping::session
