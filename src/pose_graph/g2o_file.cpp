// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/g2o_file.hpp"

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <istream>
#include <map>
#include <set>

#include <Eigen/Cholesky>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/common/number_words.hpp"

#include "odometry_chain.hpp"

namespace lidar_mapping::pose_graph {

namespace {

// Chosen: differences of ids stay within their type, and no program counts that far.
constexpr std::int64_t kLargestId = 1'000'000'000'000'000'000;

/// Reads the words and numbers of one line.
class Line {
 public:
  Line(const std::string& text, const std::string& file, int number)
      : text_(text), file_(file), number_(number), rest_(text_.c_str()) {}

  std::string word() {
    while (std::isspace(static_cast<unsigned char>(*rest_)) != 0) ++rest_;
    const char* begin = rest_;
    while (*rest_ != '\0' && std::isspace(static_cast<unsigned char>(*rest_)) == 0) ++rest_;
    return {begin, rest_};
  }

  double number() {
    char* end = nullptr;
    const double value = std::strtod(rest_, &end);
    if (end == rest_ || !std::isfinite(value)) {
      fail("a finite number is missing; the line may be cut");
    }
    rest_ = end;
    return value;
  }

  /// A coordinate of a pose: m, rad, or an element of a quaternion.
  double coordinate() {
    const double value = number();
    if (std::abs(value) > kMaxCoordinate) fail("a pose is beyond a million kilometres");
    return value;
  }

  std::int64_t id() {
    char* end = nullptr;
    const std::int64_t value = std::strtoll(rest_, &end, 10);
    if (end == rest_) fail("the id of a vertex is missing; ids are whole numbers");
    if (value < -kLargestId || value > kLargestId) fail("the id of a vertex has too many digits");
    rest_ = end;
    return value;
  }

  [[noreturn]] void fail(const std::string& problem) const {
    throw FileError(file_ + ":" + std::to_string(number_) + ": " + problem);
  }

 private:
  const std::string& text_;
  const std::string& file_;
  int number_;
  const char* rest_;
};

/// x y yaw, or x y z qx qy qz qw.
Pose read_pose(Line& line, bool planar) {
  Pose pose;
  for (int i = 0; i < (planar ? 2 : 3); ++i) pose.translation[i] = line.coordinate();
  if (planar) {
    pose.rotation = exp_so3({0.0, 0.0, line.coordinate()});
    return pose;
  }
  for (int i = 0; i < 4; ++i) pose.rotation.coeffs()[i] = line.coordinate();
  if (pose.rotation.norm() < 1e-6) line.fail("the quaternion is zero");
  pose.rotation.normalize();
  return pose;
}

bool is_positive_definite(const Matrix6d& matrix) {
  return Eigen::LLT<Matrix6d>(matrix).info() == Eigen::Success;
}

/// Calls `visit` with the row and the column of each entry of the upper triangle of an information
/// matrix that a file has, in its order.
template <typename Visit>
void visit_information(bool planar, const Visit& visit) {
  const auto is_planar = [](int i) { return i < 2 || i == 5; };  // x, y, yaw
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      if (!planar || (is_planar(row) && is_planar(column))) visit(row, column);
    }
  }
}

Matrix6d read_information(Line& line, bool planar) {
  Matrix6d information = Matrix6d::Identity();
  visit_information(planar, [&](int row, int column) {
    information(row, column) = information(column, row) = line.number();
  });
  return information;
}

/// Reads a file line by line.
class Reader {
 public:
  explicit Reader(const std::string& name) : name_(name) {}

  void add_line(const std::string& text) {
    ++number_;
    Line line(text, name_, number_);
    const std::string tag = line.word();
    if (tag.empty() || tag[0] == '#') return;
    if (tag == "VERTEX_SE3:QUAT" || tag == "VERTEX_SE2") {
      add_vertex(line, tag == "VERTEX_SE2");
    } else if (tag == "EDGE_SE3:QUAT" || tag == "EDGE_SE2") {
      add_edge(line, tag == "EDGE_SE2");
    } else {
      ++unknown_[tag];
    }
  }

  G2oFile result() {
    if (file_.graph.edges.empty()) {
      throw FileError(name_ + " has no EDGE_SE3:QUAT or EDGE_SE2; nothing to optimise");
    }
    create_nodes();
    collect_notes();
    return std::move(file_);
  }

 private:
  void require_kind(const Line& line, bool planar) {
    if (!kind_known_) file_.graph.planar = planar;
    kind_known_ = true;
    if (file_.graph.planar != planar) line.fail("SE2 and SE3 lines are mixed; keep one kind");
  }

  void add_vertex(Line& line, bool planar) {
    require_kind(line, planar);
    const std::int64_t id = line.id();
    const Pose pose = read_pose(line, planar);
    if (!vertices_.emplace(id, pose).second) {
      line.fail("vertex " + std::to_string(id) + " is given twice; remove one line");
    }
  }

  void add_edge(Line& line, bool planar) {
    require_kind(line, planar);
    PoseEdge edge;
    edge.from = line.id();
    edge.to = line.id();
    if (edge.from == edge.to) line.fail("the edge joins a vertex with itself");
    edge.T_from_to = read_pose(line, planar);
    edge.information = read_information(line, planar);
    if (!is_positive_definite(edge.information)) repair(line, edge.information);
    file_.graph.edges.push_back(edge);
  }

  /// The usual cause is cross terms in wrong positions; both diagonal blocks are correct then.
  void repair(const Line& line, Matrix6d& information) {
    information.topRightCorner<3, 3>().setZero();
    information.bottomLeftCorner<3, 3>().setZero();
    if (!is_positive_definite(information)) {
      line.fail(
          "the information matrix is not positive definite, even without its "
          "translation-rotation block; the edge has no meaning");
    }
    ++repaired_;
  }

  void create_nodes() {
    std::set<std::int64_t> ids;
    for (const PoseEdge& edge : file_.graph.edges) ids.insert({edge.from, edge.to});
    for (const auto& [id, pose] : vertices_) ids.insert(id);
    std::vector<bool> initialized;
    for (const std::int64_t id : ids) {
      const auto found = vertices_.find(id);
      initialized.push_back(found != vertices_.end());
      file_.graph.nodes.push_back({id, initialized.back() ? found->second : Pose::Identity()});
    }
    missing_ = ids.size() - vertices_.size();
    if (missing_ > 0) initialize_along_edges(file_.graph, initialized);
  }

  void collect_notes() {
    if (missing_ > 0) {
      file_.notes.push_back(
          std::to_string(missing_) + " of " + std::to_string(file_.graph.nodes.size()) +
          " vertices have no line of their own; they were placed along the edges");
    }
    if (repaired_ > 0) {
      file_.notes.push_back(
          std::to_string(repaired_) + " of " + std::to_string(file_.graph.edges.size()) +
          " information matrices are not positive definite; their translation-rotation blocks were "
          "set to zero");
    }
    for (const auto& [tag, count] : unknown_) {
      file_.notes.push_back(std::to_string(count) + " lines '" + tag + "' were left out");
    }
  }

  std::string name_;
  int number_ = 0;
  G2oFile file_;
  bool kind_known_ = false;
  std::map<std::int64_t, Pose> vertices_;
  std::map<std::string, int> unknown_;
  std::size_t missing_ = 0;
  std::size_t repaired_ = 0;
};

void write_pose(std::ostream& out, const Pose& pose, bool planar) {
  for (int i = 0; i < (planar ? 2 : 3); ++i) out << ' ' << pose.translation[i];
  if (planar) {
    out << ' ' << yaw_of(pose.rotation);
    return;
  }
  for (int i = 0; i < 4; ++i) out << ' ' << pose.rotation.coeffs()[i];
}

}  // namespace

G2oFile read_g2o(std::istream& stream, const std::string& name) {
  Reader reader(name);
  std::string line;
  while (std::getline(stream, line)) reader.add_line(line);
  return reader.result();
}

G2oFile read_g2o(const std::string& path) {
  std::ifstream stream = open_for_reading(path);
  return read_g2o(stream, path);
}

void write_g2o(const PoseGraph& graph, std::ostream& out) {
  out << std::setprecision(17);
  for (const PoseNode& node : graph.nodes) {
    out << (graph.planar ? "VERTEX_SE2 " : "VERTEX_SE3:QUAT ") << node.id;
    write_pose(out, node.pose, graph.planar);
    out << '\n';
  }
  for (const PoseEdge& edge : graph.edges) {
    out << (graph.planar ? "EDGE_SE2 " : "EDGE_SE3:QUAT ") << edge.from << ' ' << edge.to;
    write_pose(out, edge.T_from_to, graph.planar);
    visit_information(graph.planar,
                      [&](int row, int column) { out << ' ' << edge.information(row, column); });
    out << '\n';
  }
}

void write_g2o(const PoseGraph& graph, const std::string& path) {
  write_atomically(path, [&](const std::filesystem::path& temporary) {
    std::ofstream stream(temporary);
    write_g2o(graph, stream);
    stream.close();
    if (!stream) throw FileError("cannot write " + path + "; check the folder and the free space");
  });
}

}  // namespace lidar_mapping::pose_graph
