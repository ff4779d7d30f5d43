// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <iomanip>
#include <map>
#include <optional>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/new_folder.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/unknown_height.hpp"
#include "lidar_mapping/common/utm.hpp"
#include "lidar_mapping/pipeline/hdl_dump.hpp"
#include "lidar_mapping/pipeline/session_part.hpp"
#include "lidar_mapping/pose_graph/g2o_file.hpp"

namespace lidar_mapping::pipeline {

namespace {

namespace fs = std::filesystem;

// Of the edge from the anchor. Chosen: it has no residual as long as nothing else in the graph is
// absolute, whatever its weight is.
constexpr double kAnchorStddev_m = 0.1;
constexpr double kAnchorStddev_rad = 0.05;

/// Writes a file by `write`. Throws FileError with its name.
template <typename Write>
void write_file(const fs::path& path, const Write& write) {
  std::ofstream file(path);
  file << std::setprecision(17);
  write(file);
  file.close();
  if (!file) {
    throw FileError("cannot write " + path.string() + "; check the free space and the permissions");
  }
}

class DumpWriter {
 public:
  DumpWriter(const session::Session& session, const pose_graph::PoseGraph& graph, bool in_enu,
             const fs::path& directory)
      : session_(session),
        graph_(graph),
        in_enu_(in_enu),
        directory_(directory),
        datum_(session.datum()),
        gnss_(by_stamp(session.gnss())),
        imu_(by_stamp(session.imu())),
        floors_(by_stamp(session.floors())) {
    if (datum_) utm_.emplace(*datum_);
    for (const pose_graph::PoseNode& node : graph.nodes) estimates_[node.id] = node.pose;
  }

  void write() {
    fs::create_directories(directory_);
    write_graph();
    double travelled = 0.0;
    std::optional<KeyFrame> before;
    std::size_t number = 0;
    for (const KeyFrame& key_frame : session_.key_frames()) {
      const auto estimate = estimates_.find(key_frame.index);
      if (estimate == estimates_.end()) continue;
      if (before && before->segment == key_frame.segment) {
        travelled += (key_frame.T_odom_base.translation - before->T_odom_base.translation).norm();
      }
      write_key_frame(number++, key_frame, estimate->second, travelled);
      before = key_frame;
    }
    if (datum_) write_datum();
    write_file(directory_ / "poses_in_enu",
               [&](std::ostream& file) { file << (in_enu_ ? 1 : 0) << "\n"; });
    if (const auto origin = session_.sensor_origin()) {
      write_file(directory_ / "sensor_origin",
                 [&](std::ostream& file) { file << origin->transpose() << "\n"; });
    }
  }

 private:
  /// Writes the graph with a fixed vertex at the first key frame, which anchors it.
  void write_graph() const {
    pose_graph::PoseGraph anchored = graph_;
    const std::int64_t anchor = graph_.nodes.back().id + 1;
    anchored.nodes.push_back({anchor, graph_.nodes.front().pose});
    Vector6d weight;
    weight << Eigen::Vector3d::Constant(1.0 / (kAnchorStddev_m * kAnchorStddev_m)),
        Eigen::Vector3d::Constant(4.0 / (kAnchorStddev_rad * kAnchorStddev_rad));
    anchored.edges.push_back(
        {anchor, graph_.nodes.front().id, Pose::Identity(), weight.asDiagonal()});
    write_file(directory_ / "graph.g2o", [&](std::ostream& file) {
      pose_graph::write_g2o(anchored, file);
      file << "FIX " << anchor << "\n";
    });
    write_file(directory_ / "special_nodes.csv", [&](std::ostream& file) {
      file << "anchor_node " << anchor << "\nanchor_edge -1\nfloor_node -1\n";
    });
  }

  void write_key_frame(std::size_t number, const KeyFrame& key_frame, const Pose& T_map_base,
                       double travelled) const {
    const fs::path folder = directory_ / formatted("%06zu", number);
    fs::create_directory(folder);
    write_file(folder / "data", [&](std::ostream& data) {
      data << "stamp " << key_frame.stamp / kNanosecondsPerSecond << " "
           << key_frame.stamp % kNanosecondsPerSecond << "\nestimate\n"
           << T_map_base.matrix() << "\nodom\n"
           << key_frame.T_odom_base.matrix() << "\naccum_distance " << travelled << "\n";
      write_measurements(key_frame.stamp, T_map_base.rotation, data);
      data << "id " << key_frame.index << "\n";
    });
    const PointCloudPtr cloud = session_.clouds().cloud(key_frame.index);
    session::write_pcd(folder / "cloud.pcd", cloud ? *cloud : PointCloud());
  }

  void write_measurements(Stamp stamp, const Eigen::Quaterniond& R_map_base,
                          std::ostream& data) const {
    if (const auto floor = floors_.find(stamp); floor != floors_.end() && floor->second.found) {
      data << "floor_coeffs " << floor->second.normal.transpose() << " " << floor->second.offset
           << "\n";
    }
    if (const auto gnss = gnss_.find(stamp); gnss != gnss_.end()) {
      write_position(gnss->second, R_map_base, data);
    }
    const auto imu = imu_.find(stamp);
    if (imu == imu_.end()) return;
    data << "acceleration " << imu->second.linear_acceleration.transpose() << "\n";
    if (!imu->second.orientation) return;
    const Eigen::Quaterniond& q = *imu->second.orientation;
    data << "orientation " << q.w() << " " << q.x() << " " << q.y() << " " << q.z() << "\n";
  }

  /// Without a heading, only the height of the antenna is known to be subtracted.
  Eigen::Vector3d base_position(const GnssPosition& position,
                                const Eigen::Quaterniond& R_map_base) const {
    if (position.R_enu_base) return position.p_enu_base(*position.R_enu_base);
    if (in_enu_) return position.p_enu_base(R_map_base);
    return position.p_enu_antenna - Eigen::Vector3d(0.0, 0.0, position.p_base_antenna.z());
  }

  /// The position of base_link, because the format has no lever arm. A position without height has
  /// a field that only this package reads, and that others skip: in utm_coord they would take the
  /// height of the datum for a measured one, and interactive_slam does not get past a "nan".
  void write_position(const GnssPosition& position, const Eigen::Quaterniond& R_map_base,
                      std::ostream& data) const {
    const Eigen::Vector3d p_utm = in_utm(base_position(position, R_map_base));
    if (has_height(position.covariance)) {
      data << "utm_coord " << p_utm.transpose() << "\n";
    } else {
      data << "utm_horizontal " << p_utm.head<2>().transpose() << "\n";
    }
  }

  /// Position in UTM relative to the datum, as hdl_graph_slam stores it; unchanged without a datum.
  Eigen::Vector3d in_utm(const Eigen::Vector3d& p_enu) const {
    return utm_ ? utm_->from_enu(p_enu) - utm_->origin() : p_enu;
  }

  /// Writes zero_utm, and the datum in a file of its own, because zero_utm does not contain the UTM
  /// zone.
  void write_datum() const {
    write_file(directory_ / "zero_utm", [&](std::ostream& file) {
      file << std::fixed << std::setprecision(6) << utm_->origin().x() << " " << utm_->origin().y()
           << " " << utm_->origin().z() << "\n";
    });
    write_file(directory_ / "datum", [&](std::ostream& file) {
      file << datum_->latitude_deg << " " << datum_->longitude_deg << " " << datum_->altitude_m
           << "\n";
    });
  }

  const session::Session& session_;
  const pose_graph::PoseGraph& graph_;
  const bool in_enu_;
  const fs::path directory_;
  const std::optional<GeodeticDatum> datum_;
  std::optional<UtmFrame> utm_;  ///< UTM zone of the datum.
  const std::map<Stamp, GnssPosition> gnss_;
  const std::map<Stamp, ImuSample> imu_;
  const std::map<Stamp, Floor> floors_;
  std::map<std::int64_t, Pose> estimates_;
};

}  // namespace

void write_hdl_dump(const session::Session& session, const pose_graph::PoseGraph& graph,
                    bool in_enu, const fs::path& directory) {
  if (graph.nodes.empty()) throw InputError("the session has no key frames; nothing to dump");
  const fs::path target = folder_path(directory);
  if (fs::exists(target)) {
    throw FileError(target.string() + " is there already; name another directory");
  }
  const fs::path temporary = hidden_beside(target, ".part");
  try {
    fs::remove_all(temporary);
    DumpWriter(session, graph, in_enu, temporary).write();
    fs::rename(temporary, target);
  } catch (const std::exception& error) {
    std::error_code ignored;
    fs::remove_all(temporary, ignored);
    throw FileError("cannot write the dump " + target.string() + ": " + error.what());
  }
}

}  // namespace lidar_mapping::pipeline
