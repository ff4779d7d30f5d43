// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/folder_input.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/folder_entries.hpp"
#include "lidar_mapping/common/number_words.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/pipeline/kitti_folder.hpp"
#include "lidar_mapping/session/cloud_store.hpp"

#include "folders/kitti_raw.hpp"

namespace lidar_mapping::pipeline {

namespace {

namespace fs = std::filesystem;

constexpr char kImuFrame[] = "imu_link";
constexpr double kDefaultPeriod = 0.1;  // s, if the folder has no times; chosen as of most LiDARs
constexpr Stamp kHalfTurn = from_seconds(0.05);  // from the stamp of a scan to its last point
// Chosen: a smaller number in a name is a counter.
constexpr Stamp kFirstPlausibleTime = from_seconds(1e6);

std::vector<fs::path> scans_in(const fs::path& folder, const std::vector<std::string>& endings) {
  if (!fs::is_directory(folder)) throw FileError("no folder " + folder.string());
  return sorted_paths_in(folder, [&](const fs::directory_entry& entry) {
    return contains(endings, entry.path().extension());
  });
}

PointCloud read_scan(const fs::path& path) {
  if (path.extension() == ".pcd") return session::read_pcd(path);
  if (path.extension() == ".txt") return read_text_scan(path);
  return {read_points(path), {}};
}

void check_count(const fs::path& file, std::size_t times, std::size_t scans) {
  if (times >= scans) return;
  throw FileError(file.string() + " has " + std::to_string(times) + " times for " +
                  std::to_string(scans) + " scans; copy it again");
}

/// Time in a name like 1317617735.250, to the nanosecond; 0 if the name is not a time.
Stamp stamp_in(const std::string& name) {
  if (name.find('.') == std::string::npos) return 0;
  try {
    const Stamp stamp = stamp_of_seconds(name);
    return stamp >= kFirstPlausibleTime ? stamp : 0;
  } catch (const InputError&) {
    return 0;
  }
}

/// Stamps from times.txt, from the names, or at the default rate.
std::vector<Stamp> stamps_of(const std::vector<fs::path>& scans, const FolderOptions& options) {
  const fs::path file = scans.front().parent_path() / "times.txt";
  std::vector<Stamp> stamps;
  const Stamp start = from_seconds(options.start);
  if (fs::exists(file)) {
    for (const Stamp stamp : read_times(file)) stamps.push_back(start + stamp);
    check_count(file, stamps.size(), scans.size());
    return stamps;
  }
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const Stamp stamp_of_name = stamp_in(scans[i].stem());
    stamps.push_back(stamp_of_name > 0
                         ? stamp_of_name
                         : start + from_seconds(kDefaultPeriod * static_cast<double>(i)));
  }
  return stamps;
}

/// Looks in the folder itself and in that of the day above it.
std::optional<Pose> find_imu_to_velo(const fs::path& folder) {
  const fs::path whole = fs::canonical(folder);
  for (const fs::path& directory : {whole, whole.parent_path()}) {
    if (const auto found = read_imu_to_velo(directory / "calib_imu_to_velo.txt")) return found;
  }
  return std::nullopt;
}

}  // namespace

FolderInput::FolderInput(const std::string& path, const FolderOptions& options) {
  frames_["base_link"] = Pose::Identity();
  frames_[kLidarFrame].translation.z() = options.sensor_height;
  if (fs::is_directory(fs::path(path) / "velodyne_points")) {
    read_raw(path);
  } else if (fs::is_directory(fs::path(path) / "velodyne")) {
    read_odometry(path, options);
  } else {
    read_scans(path, options);
  }
  std::stable_sort(inputs_.begin(), inputs_.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
}

void FolderInput::add_scan(Stamp stamp, std::function<PointCloud()> read) {
  const auto decode = [stamp, read = std::move(read)](const PointCloud&) {
    return preprocessing::RawScan{stamp, kLidarFrame, read(), false};
  };
  inputs_.emplace_back(stamp + kHalfTurn, RecordedScan{stamp, decode});
}

void FolderInput::add_pcd(Stamp stamp, const std::string& path, const FolderOptions& options) {
  const auto decode = [stamp, path, read = options.read_pcd](const PointCloud&) {
    preprocessing::RawScan scan = read(path, stamp);
    scan.frame_id = kLidarFrame;
    return scan;
  };
  inputs_.emplace_back(stamp + kHalfTurn, RecordedScan{stamp, decode});
}

void FolderInput::read_raw(const std::string& path) {
  const fs::path velodyne = fs::path(path) / "velodyne_points";
  const std::vector<fs::path> scans = scans_in(velodyne / "data", {".bin", ".txt"});
  if (scans.empty()) throw FileError("no *.bin or *.txt in " + (velodyne / "data").string());
  const std::vector<Stamp> stamps = read_kitti_dates(velodyne / "timestamps.txt");
  // In some recordings scans are missing; the names of the files are the indices of their dates.
  for (const fs::path& scan : scans) {
    const auto number = static_cast<std::size_t>(std::strtoull(scan.stem().c_str(), nullptr, 10));
    check_count(velodyne / "timestamps.txt", stamps.size(), std::max(number, number + 1));
    add_scan(stamps[number], [scan] { return read_scan(scan); });
  }
  description_ = "KITTI raw recording, " + std::to_string(scans.size()) + " scans";
  const fs::path oxts = fs::path(path) / "oxts";
  if (!fs::is_directory(oxts)) return;
  const std::optional<Pose> T_velo_imu = find_imu_to_velo(path);
  if (!T_velo_imu) {
    description_ += "; GNSS and IMU left out: calib_imu_to_velo.txt is neither there nor above";
    return;
  }
  frames_[kImuFrame] = frames_[kLidarFrame] * *T_velo_imu;
  for (const OxtsSample& sample : read_oxts(oxts)) {
    inputs_.emplace_back(sample.imu.stamp, FramedSample<ImuSample>{sample.imu, kImuFrame});
    inputs_.emplace_back(sample.imu.stamp,
                         FramedSample<VelocitySample>{sample.velocity, kImuFrame});
    inputs_.emplace_back(sample.imu.stamp, FramedSample<GnssFix>{sample.fix, kImuFrame});
  }
  description_ += ", GNSS, IMU and velocity";
}

void FolderInput::read_odometry(const std::string& path, const FolderOptions& options) {
  const auto folder = std::make_shared<const KittiFolder>(path);
  const Stamp start = from_seconds(options.start);
  for (std::size_t i = 0; i < folder->size(); ++i) {
    add_scan(start + folder->stamp(i), [folder, i] { return folder->scan(i).cloud; });
  }
  description_ = "KITTI odometry folder, " + std::to_string(folder->size()) + " scans";
}

void FolderInput::read_scans(const std::string& path, const FolderOptions& options) {
  const std::vector<fs::path> scans = scans_in(path, {".pcd", ".bin"});
  if (scans.empty()) {
    throw FileError("no scans in " + path +
                    ": neither velodyne_points/ nor velodyne/ nor *.pcd nor *.bin");
  }
  const std::vector<Stamp> stamps = stamps_of(scans, options);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (options.read_pcd && scans[i].extension() == ".pcd") {
      add_pcd(stamps[i], scans[i].string(), options);
    } else {
      add_scan(stamps[i], [scan = scans[i]] { return read_scan(scan); });
    }
  }
  description_ = "folder of " + std::to_string(scans.size()) + " scans";
}

std::optional<Input> FolderInput::next() {
  if (next_ == inputs_.size()) return std::nullopt;
  return inputs_[next_++].second;
}

void FolderInput::skip_to(Stamp stamp) {
  const auto first = std::lower_bound(inputs_.begin(), inputs_.end(), stamp,
                                      [](const auto& a, Stamp b) { return a.first < b; });
  next_ = static_cast<std::size_t>(first - inputs_.begin());
}

Stamp FolderInput::begin() const { return inputs_.front().first; }
Stamp FolderInput::end() const { return inputs_.back().first; }

std::optional<Pose> FolderInput::T_base(const std::string& frame_id) const {
  const auto found = frames_.find(frame_id);
  if (found == frames_.end()) return std::nullopt;
  return found->second;
}

}  // namespace lidar_mapping::pipeline
