#include <fstream>
#include <map>
#include <optional>
#include <sstream>

#include "lidar_mapping/back_end/g2o_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/pipeline/hdl_dump.hpp"

namespace lidar_mapping::pipeline {

namespace {

namespace fs = std::filesystem;
using back_end::PoseEdge;

constexpr double kGnssStddev_m = 1.0;  // the dump does not say how good positions are

/// What stands in NNNNNN/data.
struct DumpedFrame {
  std::int64_t id = -1;
  Stamp stamp = 0;
  Pose T_map_base;
  Pose T_odom_base;
  std::optional<Floor> floor;
  std::optional<Eigen::Vector3d> p_utm;
  std::optional<Eigen::Vector3d> acceleration;
  std::optional<Eigen::Quaterniond> orientation;
};

template <int Size>
Eigen::Matrix<double, Size, 1> take_vector(std::istream& stream) {
  Eigen::Matrix<double, Size, 1> vector;
  for (int i = 0; i < Size; ++i) stream >> vector[i];
  return vector;
}

Pose take_matrix(std::istream& stream) {
  Eigen::Matrix4d matrix;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) stream >> matrix(row, column);
  }
  return Pose::from_matrix(matrix);
}

Floor take_floor(std::istream& stream) {
  const Eigen::Vector4d plane = take_vector<4>(stream);
  Floor floor;
  floor.found = true;
  floor.normal = plane.head<3>();
  floor.offset = plane[3];
  return floor;
}

void take_field(const std::string& name, std::istream& stream, DumpedFrame& frame) {
  if (name == "stamp") {
    std::int64_t seconds = 0;
    std::int64_t nanoseconds = 0;
    stream >> seconds >> nanoseconds;
    frame.stamp = seconds * 1'000'000'000 + nanoseconds;
  } else if (name == "estimate") {
    frame.T_map_base = take_matrix(stream);
  } else if (name == "odom") {
    frame.T_odom_base = take_matrix(stream);
  } else if (name == "floor_coeffs") {
    frame.floor = take_floor(stream);
  } else if (name == "utm_coord") {
    frame.p_utm = take_vector<3>(stream);
  } else if (name == "acceleration") {
    frame.acceleration = take_vector<3>(stream);
  } else if (name == "orientation") {
    const Eigen::Vector4d q = take_vector<4>(stream);
    frame.orientation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
  } else if (name == "id") {
    stream >> frame.id;
  }
}

DumpedFrame read_frame(const fs::path& path) {
  std::ifstream file(path);
  DumpedFrame frame;
  for (std::string name; file >> name;) take_field(name, file, frame);
  const bool broken = file.bad() || (file.fail() && !file.eof());
  if (broken || frame.id < 0 || !is_finite(frame.T_odom_base) || !is_finite(frame.T_map_base)) {
    throw FileError(path.string() + " is missing or damaged; is this a dump of hdl_graph_slam?");
  }
  return frame;
}

std::string name_of(std::size_t number) {
  char name[32];
  std::snprintf(name, sizeof name, "%06zu", number);
  return name;
}

std::vector<DumpedFrame> read_frames(const fs::path& directory) {
  std::vector<DumpedFrame> frames;
  while (fs::is_directory(directory / name_of(frames.size()))) {
    frames.push_back(read_frame(directory / name_of(frames.size()) / "data"));
  }
  if (frames.empty()) {
    throw FileError("there are no key frames (000000/data) in " + directory.string());
  }
  return frames;
}

/// Poses and the edges between them; planes, priors and fixed vertices are another matter.
back_end::PoseGraph read_poses_and_edges(const fs::path& path) {
  std::ifstream file = open_for_reading(path);
  std::stringstream wanted;
  for (std::string line; std::getline(file, line);) {
    const std::string tag = line.substr(0, line.find(' '));
    if (tag == "VERTEX_SE3:QUAT" || tag == "EDGE_SE3:QUAT") wanted << line << '\n';
  }
  return back_end::read_g2o(wanted, path.string()).graph;
}

/// An edge by the positions of its key frames, the older one first.
struct Link {
  std::size_t from = 0;
  std::size_t to = 0;
  Pose T_from_to;
  Covariance6 covariance;
};

/// g2o's information is that of translation and half the rotation.
Covariance6 covariance_of(const Matrix6d& information) {
  Vector6d scale;
  scale << 1.0, 1.0, 1.0, 2.0, 2.0, 2.0;
  const Covariance6 covariance = scale.asDiagonal() * information.inverse() * scale.asDiagonal();
  return 0.5 * (covariance + covariance.transpose());
}

Link turned_round(const Link& link) {
  const Matrix6d A = adjoint(link.T_from_to);
  return {link.to, link.from, link.T_from_to.inverse(), A * link.covariance * A.transpose()};
}

std::vector<Link> links_of(const back_end::PoseGraph& graph,
                           const std::vector<DumpedFrame>& frames) {
  std::map<std::int64_t, std::size_t> position;
  for (std::size_t i = 0; i < frames.size(); ++i) position[frames[i].id] = i;
  std::vector<Link> links;
  for (const PoseEdge& edge : graph.edges) {
    const auto from = position.find(edge.from);
    const auto to = position.find(edge.to);
    if (from == position.end() || to == position.end() || from == to) continue;
    const Link link{from->second, to->second, edge.T_from_to, covariance_of(edge.information)};
    links.push_back(link.from < link.to ? link : turned_round(link));
  }
  return links;
}

class DumpReader {
 public:
  DumpReader(const fs::path& directory, session::Session& session)
      : directory_(directory), session_(session), frames_(read_frames(directory)) {
    for (const Link& link : links_of(read_poses_and_edges(directory / "graph.g2o"), frames_)) {
      const bool is_odometry = link.to == link.from + 1 && motions_.count(link.to) == 0;
      if (is_odometry) {
        motions_.emplace(link.to, link);
      } else {
        loops_.push_back(link);
      }
    }
  }

  HdlImport read() {
    for (std::size_t i = 0; i < frames_.size(); ++i) add_key_frame(i);
    for (const Link& link : loops_) add_loop(link);
    add_poses();
    return {frames_.size(), loops_.size(), segments_};
  }

 private:
  /// Odometry follows the edges, which people correct and which have more digits than the poses.
  void add_key_frame(std::size_t i) {
    const DumpedFrame& frame = frames_[i];
    KeyFrame key_frame;
    const auto motion = motions_.find(i);
    if (motion != motions_.end()) {
      T_odom_base_ = T_odom_base_ * motion->second.T_from_to;
      key_frame.motion_covariance = motion->second.covariance;
    } else {
      T_odom_base_ = frame.T_odom_base;
      ++segments_;
    }
    key_frame.index = static_cast<KeyFrameIndex>(i);
    key_frame.segment = static_cast<std::uint32_t>(segments_ - 1);
    key_frame.stamp = frame.stamp;
    key_frame.T_odom_base = T_odom_base_;
    key_frame.cloud = std::make_shared<const PointCloud>(
        session::read_pcd(directory_ / name_of(i) / "cloud.pcd"));
    session_.add_key_frame(key_frame);
    add_measurements(frame);
  }

  void add_measurements(const DumpedFrame& frame) {
    if (frame.floor) {
      Floor floor = *frame.floor;
      floor.stamp = frame.stamp;
      session_.add_floor(floor);
    }
    if (frame.p_utm) {
      GnssPosition position;
      position.stamp = frame.stamp;
      position.p_enu_antenna = *frame.p_utm;
      position.covariance = kGnssStddev_m * kGnssStddev_m * Eigen::Matrix3d::Identity();
      session_.add_gnss(position);
    }
    if (frame.acceleration || frame.orientation) {
      ImuSample sample;
      sample.stamp = frame.stamp;
      sample.linear_acceleration = frame.acceleration.value_or(Eigen::Vector3d::Zero());
      sample.orientation = frame.orientation;
      session_.add_imu(sample);
    }
  }

  void add_loop(const Link& link) {
    Loop loop;
    loop.from = static_cast<KeyFrameIndex>(link.from);
    loop.to = static_cast<KeyFrameIndex>(link.to);
    loop.stamp = frames_[link.to].stamp;
    loop.T_from_to = link.T_from_to;
    loop.covariance = link.covariance;
    loop.source = LoopSource::kManual;
    session_.add_loop(loop);
  }

  void add_poses() {
    KeyFramePoses poses;
    poses.revision = 1;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      poses.poses.push_back(
          {static_cast<KeyFrameIndex>(i), frames_[i].stamp, frames_[i].T_map_base});
    }
    session::RevisionRecord record;
    record.revision = poses.revision;
    record.key_frames = poses.poses.size();
    record.loops_used = loops_.size();
    session_.set_poses(poses, record);
  }

  const fs::path directory_;
  session::Session& session_;
  const std::vector<DumpedFrame> frames_;
  std::map<std::size_t, Link> motions_;  ///< by the newer end
  std::vector<Link> loops_;
  Pose T_odom_base_;
  std::size_t segments_ = 0;
};

}  // namespace

HdlImport read_hdl_dump(const fs::path& directory, session::Session& session) {
  return DumpReader(directory, session).read();
}

}  // namespace lidar_mapping::pipeline
