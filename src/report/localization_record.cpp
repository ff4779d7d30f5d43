// SPDX-License-Identifier: BSD-3-Clause
#include "localization_record.hpp"

#include <fstream>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/new_folder.hpp"
#include "lidar_mapping/common/text.hpp"

#include "digest.hpp"
#include "json.hpp"

namespace lidar_mapping::report {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFile = "localization.json";

/// The last part of a path, which may end with a slash.
std::string name_of(const fs::path& path) { return folder_path(path).filename().string(); }

/// To a tenth of a millimetre, so that the last bits of a calculation do not matter.
std::string text_of(const Pose& pose) {
  const Eigen::Vector3d& p = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  return formatted("%.4f %.4f %.4f %.6f %.6f %.6f %.6f\n", p.x(), p.y(), p.z(), q.x(), q.y(), q.z(),
                   q.w());
}

LocalizationRecord record_of(const json::Json& json) {
  LocalizationRecord record;
  record.recordings = json.at("recordings").get<std::vector<std::string>>();
  const json::Json& map = json.at("map");
  record.map.session = map.at("session").get<std::string>();
  const json::Json& count = map.at("key_frames");
  if (!count.is_number_unsigned()) throw InputError(json::dumped(count) + " is no whole number");
  record.map.key_frames = count.get<std::size_t>();
  record.map.digest = map.at("digest").get<std::string>();
  record.map.pose_digest = map.at("pose_digest").get<std::string>();
  return record;
}

}  // namespace

MapIdentity identity_of(const KeyFramePoses& map, const fs::path& session) {
  Digest key_frames;
  Digest poses;
  for (const KeyFramePose& pose : map.poses) {
    key_frames.add(std::to_string(pose.index) + " " + std::to_string(pose.stamp) + "\n");
    poses.add(text_of(pose.T_map_base));
  }
  // Behind `latest`, which is a link to the newest session.
  return {name_of(fs::weakly_canonical(session)), map.poses.size(), key_frames.text(),
          poses.text()};
}

std::string map_difference(const MapIdentity& localized_in, const MapIdentity& given) {
  if (localized_in.key_frames != given.key_frames || localized_in.digest != given.digest) {
    return formatted("it was localised in the map %s (%zu key frames), which is another one than ",
                     localized_in.session.c_str(), localized_in.key_frames) +
           formatted("%s (%zu key frames)", given.session.c_str(), given.key_frames);
  }
  if (localized_in.pose_digest != given.pose_digest) {
    return "the poses of the map " + given.session + " have changed since it was localised in it";
  }
  return "";
}

std::vector<std::string> names_of_recordings(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  for (const std::string& path : paths) names.push_back(name_of(path));
  return names;
}

LocalizationRecord read_localization_record(const fs::path& folder) {
  std::ifstream stream(folder / kFile);
  if (!stream) {
    throw FileError("there is no " + std::string(kFile) + " in " + folder.string() +
                    "; name the folder that localize_bag made by -o");
  }
  try {
    return record_of(json::Json::parse(stream));
  } catch (const std::exception& error) {  // the library's, or that of record_of()
    throw InputError((folder / kFile).string() + " is damaged: " + error.what() +
                     "; localize_bag writes it again");
  }
}

void write_localization_record(const fs::path& folder, const LocalizationRecord& record) {
  const json::Json json = {{"format", 1},
                           {"recordings", record.recordings},
                           {"map",
                            {{"session", record.map.session},
                             {"key_frames", record.map.key_frames},
                             {"digest", record.map.digest},
                             {"pose_digest", record.map.pose_digest}}}};
  write_text_atomically(folder / kFile, json::dumped(json, 2) + "\n");
}

}  // namespace lidar_mapping::report
