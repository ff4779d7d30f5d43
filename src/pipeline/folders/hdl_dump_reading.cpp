// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <type_traits>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/geodetic.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/common/number_words.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/unknown_height.hpp"
#include "lidar_mapping/common/utm.hpp"
#include "lidar_mapping/pipeline/hdl_dump.hpp"
#include "lidar_mapping/pose_graph/g2o_file.hpp"

namespace lidar_mapping::pipeline {

namespace {

namespace fs = std::filesystem;
using pose_graph::PoseEdge;

// m. Chosen as of receivers without corrections: the dump does not contain the accuracy.
constexpr double kGnssStddev_m = 1.0;

/// Contents of NNNNNN/data.
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

/// Reads a file word by word and knows the line for error messages.
class WordReader {
 public:
  explicit WordReader(const fs::path& path) : path_(path), file_(open_for_reading(path)) {}

  /// The next word; empty at the end.
  std::string next() {
    std::string word;
    while (!(line_ >> word)) {
      std::string text;
      if (!std::getline(file_, text)) return "";
      ++number_;
      line_ = std::istringstream(text);
    }
    return word;
  }

  double number() {
    return checked([this] { return coordinate(next()); });
  }

  template <int Size>
  Eigen::Matrix<double, Size, 1> vector() {
    Eigen::Matrix<double, Size, 1> vector;
    for (int i = 0; i < Size; ++i) vector[i] = number();
    return vector;
  }

  /// The height may be "nan", as hdl_graph_slam writes one that it does not know.
  Eigen::Vector3d position() {
    const Eigen::Vector2d p = vector<2>();
    const std::string height = next();
    const bool is_unknown = height == "nan" || height == "-nan";
    return {p.x(), p.y(), is_unknown ? std::nan("") : checked([&] { return coordinate(height); })};
  }

  /// As this package writes a position without height.
  Eigen::Vector3d position_without_height() {
    const Eigen::Vector2d p = vector<2>();
    return {p.x(), p.y(), std::nan("")};
  }

  Pose pose() {
    Eigen::Matrix4d matrix;
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) matrix(row, column) = number();
    }
    return checked([&] { return rigid_pose(matrix); });
  }

  std::int64_t whole_number(double max) {
    const double value = checked([this] { return finite_number(next()); });
    if (value < 0.0 || value > max || value != std::floor(value)) fail("it is no whole number");
    return static_cast<std::int64_t>(value);
  }

  [[noreturn]] void fail(const std::string& problem) const {
    throw FileError(path_.string() + ":" + std::to_string(number_) + ": " + problem +
                    "; is this a dump of hdl_graph_slam?");
  }

 private:
  template <typename Read>
  std::invoke_result_t<Read> checked(const Read& read) const {
    try {
      return read();
    } catch (const InputError& error) {
      fail(error.what());
    }
  }

  fs::path path_;
  std::ifstream file_;
  std::istringstream line_;
  int number_ = 0;
};

Floor read_floor(WordReader& words) {
  const Eigen::Vector4d plane = words.vector<4>();
  Floor floor;
  floor.found = true;
  floor.normal = plane.head<3>();
  floor.offset = plane[3];
  if (std::abs(floor.normal.norm() - 1.0) > 0.1)
    words.fail("the floor's normal has no unit length");
  return floor;
}

Eigen::Quaterniond read_orientation(WordReader& words) {
  const Eigen::Vector4d q = words.vector<4>();
  if (std::abs(q.norm() - 1.0) > 0.5) words.fail("the quaternion is not of unit length");
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
}

Stamp read_stamp(WordReader& words) {
  const std::int64_t seconds = words.whole_number(kMaxTime);
  return seconds * kNanosecondsPerSecond +
         words.whole_number(static_cast<double>(kNanosecondsPerSecond - 1));
}

void read_field(const std::string& name, WordReader& words, DumpedFrame& frame) {
  if (name == "stamp") {
    frame.stamp = read_stamp(words);
  } else if (name == "estimate") {
    frame.T_map_base = words.pose();
  } else if (name == "odom") {
    frame.T_odom_base = words.pose();
  } else if (name == "floor_coeffs") {
    frame.floor = read_floor(words);
  } else if (name == "utm_coord") {
    frame.p_utm = words.position();
  } else if (name == "utm_horizontal") {
    frame.p_utm = words.position_without_height();
  } else if (name == "acceleration") {
    frame.acceleration = words.vector<3>();
  } else if (name == "orientation") {
    frame.orientation = read_orientation(words);
  } else if (name == "id") {
    constexpr double kLargest = 9e15;  // below 2^53, so that a double holds it by its format
    frame.id = words.whole_number(kLargest);
  } else if (name == "accum_distance") {
    words.number();
  } else {
    words.fail("'" + name.substr(0, 40) + "' is no field of a key frame");
  }
}

DumpedFrame read_frame(const fs::path& path) {
  WordReader words(path);
  DumpedFrame frame;
  std::set<std::string> found;
  for (std::string name = words.next(); !name.empty(); name = words.next()) {
    read_field(name, words, frame);
    found.insert(name);
  }
  for (const char* name : {"stamp", "estimate", "odom", "id"}) {
    if (found.count(name) == 0) words.fail(std::string("the field '") + name + "' is missing");
  }
  return frame;
}

std::string name_of(std::size_t number) { return formatted("%06zu", number); }

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

/// Reads the datum from a dump of this package. hdl_graph_slam does not store the UTM zone, so the
/// positions of its own dumps stay as they are.
std::optional<GeodeticDatum> read_datum(const fs::path& path) {
  if (!fs::exists(path)) return std::nullopt;
  WordReader words(path);
  GeodeticDatum datum;
  for (double* value : {&datum.latitude_deg, &datum.longitude_deg, &datum.altitude_m}) {
    *value = words.number();
  }
  if (!is_place(datum))
    words.fail("latitude and longitude (degrees) and altitude (m) are no place");
  return datum;
}

/// Whether the poses of the dump lie in the East-North-Up frame of its datum. hdl_graph_slam does
/// not say so: its map begins where the vehicle did.
bool read_in_enu(const fs::path& path) {
  return fs::exists(path) && WordReader(path).whole_number(1.0) == 1;
}

/// Reads poses and the edges between them; planes, priors and fixed vertices are skipped.
pose_graph::PoseGraph read_poses_and_edges(const fs::path& path) {
  std::ifstream file = open_for_reading(path);
  std::stringstream selected;
  for (std::string line; std::getline(file, line);) {
    const std::string tag = line.substr(0, line.find(' '));
    if (tag == "VERTEX_SE3:QUAT" || tag == "EDGE_SE3:QUAT") selected << line << '\n';
  }
  return pose_graph::read_g2o(selected, path.string()).graph;
}

/// An edge between key frames, given by their positions in the dump, the older one first.
struct KeyFrameEdge {
  std::size_t from = 0;
  std::size_t to = 0;
  Pose T_from_to;
  Covariance6 covariance;
};

/// Covariance of an edge. g2o's information is that of translation and half the rotation.
Covariance6 covariance_of(const Matrix6d& information) {
  Vector6d scale;
  scale << 1.0, 1.0, 1.0, 2.0, 2.0, 2.0;
  const Covariance6 covariance = scale.asDiagonal() * information.inverse() * scale.asDiagonal();
  return 0.5 * (covariance + covariance.transpose());
}

KeyFrameEdge inverted(const KeyFrameEdge& edge) {
  const Matrix6d A = adjoint(edge.T_from_to);
  return {edge.to, edge.from, edge.T_from_to.inverse(), A * edge.covariance * A.transpose()};
}

std::vector<KeyFrameEdge> edges_of(const pose_graph::PoseGraph& graph,
                                   const std::vector<DumpedFrame>& frames) {
  std::map<std::int64_t, std::size_t> position;
  for (std::size_t i = 0; i < frames.size(); ++i) position[frames[i].id] = i;
  std::vector<KeyFrameEdge> key_frame_edges;
  for (const PoseEdge& edge : graph.edges) {
    const auto from = position.find(edge.from);
    const auto to = position.find(edge.to);
    if (from == position.end() || to == position.end() || from == to) continue;
    const KeyFrameEdge forward{from->second, to->second, edge.T_from_to,
                               covariance_of(edge.information)};
    key_frame_edges.push_back(forward.from < forward.to ? forward : inverted(forward));
  }
  return key_frame_edges;
}

class DumpReader {
 public:
  DumpReader(const fs::path& directory, session::Session& session)
      : directory_(directory),
        session_(session),
        frames_(read_frames(directory)),
        datum_(read_datum(directory / "datum")) {
    if (datum_) utm_.emplace(*datum_);
    for (const KeyFrameEdge& edge :
         edges_of(read_poses_and_edges(directory / "graph.g2o"), frames_)) {
      const bool is_odometry = edge.to == edge.from + 1;
      if (!is_odometry || !motions_.emplace(edge.to, edge).second) loops_.push_back(edge);
    }
  }

  HdlImport read() {
    if (datum_) session_.set_datum(*datum_);
    if (fs::exists(directory_ / "sensor_origin")) {
      session_.set_sensor_origin(WordReader(directory_ / "sensor_origin").vector<3>());
    }
    for (std::size_t i = 0; i < frames_.size(); ++i) add_key_frame(i);
    for (const KeyFrameEdge& edge : loops_) add_loop(edge);
    add_poses();
    return {frames_.size(), loops_.size(), segments_};
  }

 private:
  /// Adds a key frame. Its odometry follows from the edges, which people may have corrected and
  /// which have more digits than the poses.
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
      const bool is_level = std::isnan(frame.p_utm->z());
      position.p_enu_antenna =
          in_enu({frame.p_utm->x(), frame.p_utm->y(), is_level ? 0.0 : frame.p_utm->z()});
      position.covariance = kGnssStddev_m * kGnssStddev_m * Eigen::Matrix3d::Identity();
      if (is_level) position.covariance(2, 2) = kUnknownHeightStddev * kUnknownHeightStddev;
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

  Eigen::Vector3d in_enu(const Eigen::Vector3d& p_utm) const {
    try {
      return utm_ ? utm_->to_enu(utm_->origin() + p_utm) : p_utm;
    } catch (const InputError& error) {
      throw FileError(directory_.string() + ": utm_coord: " + error.what());
    }
  }

  void add_loop(const KeyFrameEdge& edge) {
    Loop loop;
    loop.from = static_cast<KeyFrameIndex>(edge.from);
    loop.to = static_cast<KeyFrameIndex>(edge.to);
    loop.stamp = frames_[edge.to].stamp;
    loop.T_from_to = edge.T_from_to;
    loop.covariance = edge.covariance;
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
    session_.set_poses(poses, record, read_in_enu(directory_ / "poses_in_enu"));
  }

  const fs::path directory_;
  session::Session& session_;
  const std::vector<DumpedFrame> frames_;
  const std::optional<GeodeticDatum> datum_;
  std::optional<UtmFrame> utm_;                  ///< UTM zone of the datum.
  std::map<std::size_t, KeyFrameEdge> motions_;  ///< By the position of the newer key frame.
  std::vector<KeyFrameEdge> loops_;
  Pose T_odom_base_;
  std::size_t segments_ = 0;
};

}  // namespace

HdlImport read_hdl_dump(const fs::path& directory, session::Session& session) try {
  return DumpReader(directory, session).read();
} catch (const InputError& error) {  // of numbers that the session refuses
  throw FileError(directory.string() + ": " + error.what());
}

}  // namespace lidar_mapping::pipeline
