// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/g2o_file.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <istream>
#include <map>

#include <Eigen/Cholesky>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/common/number_words.hpp"

#include "files/information_entries.hpp"
#include "initialization/odometry_chain.hpp"

namespace lidar_mapping::pose_graph {

namespace {

// Chosen: differences of ids stay within their type, and no program counts that far.
constexpr std::int64_t kLargestId = 1'000'000'000'000'000'000;

/// Reads a number as strtod() does; `end` is where it ends, or `begin` if there is none. Most of
/// the time of a large file is that of its numbers, and newer standard libraries read them faster.
double parsed(const char* begin, [[maybe_unused]] const char* text_end, char** end) {
#ifdef __cpp_lib_to_chars
  const char* first = begin;
  while (first != text_end && std::isspace(static_cast<unsigned char>(*first)) != 0) ++first;
  double value = 0.0;
  const auto result = std::from_chars(first, text_end, value);
  if (result.ec == std::errc()) {
    *end = const_cast<char*>(result.ptr);
    return value;
  }
#endif
  return std::strtod(begin, end);  // also a plus sign, and numbers that are too small for a double
}

/// Appends the fewest digits from which the same bits are read again.
void append_number(std::string& line, double value) {
  std::array<char, 32> digits{};
  line += ' ';
#ifdef __cpp_lib_to_chars
  const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  line.append(digits.data(), result.ptr);
#else
  line.append(digits.data(), static_cast<std::size_t>(
                                 std::snprintf(digits.data(), digits.size(), "%.17g", value)));
#endif
}

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
    const double value = parsed(rest_, text_.c_str() + text_.size(), &end);
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
    sort_vertices();
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
    vertices_.push_back({{id, read_pose(line, planar)}, number_});
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

  void sort_vertices() {
    const auto by_id = [](const Vertex& a, const Vertex& b) { return a.node.id < b.node.id; };
    if (!std::is_sorted(vertices_.begin(), vertices_.end(), by_id)) {
      std::stable_sort(vertices_.begin(), vertices_.end(), by_id);
    }
    for (std::size_t i = 1; i < vertices_.size(); ++i) {
      if (vertices_[i].node.id != vertices_[i - 1].node.id) continue;
      throw FileError(name_ + ":" + std::to_string(vertices_[i].line) + ": vertex " +
                      std::to_string(vertices_[i].node.id) + " is given twice; remove one line");
    }
  }

  /// The ids that edges have but vertices do not, ascending.
  std::vector<std::int64_t> missing_ids() const {
    std::vector<std::int64_t> missing;
    const auto add = [&](std::int64_t id) {
      const auto found = std::lower_bound(
          vertices_.begin(), vertices_.end(), id,
          [](const Vertex& vertex, std::int64_t wanted) { return vertex.node.id < wanted; });
      if (found == vertices_.end() || found->node.id != id) missing.push_back(id);
    };
    for (const PoseEdge& edge : file_.graph.edges) {
      add(edge.from);
      add(edge.to);
    }
    std::sort(missing.begin(), missing.end());
    missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
    return missing;
  }

  void create_nodes() {
    const std::vector<std::int64_t> missing = missing_ids();
    missing_ = missing.size();
    std::vector<bool> initialized;
    file_.graph.nodes.reserve(vertices_.size() + missing.size());
    auto next_missing = missing.begin();
    const auto add_missing_before = [&](const Vertex* vertex) {
      while (next_missing != missing.end() && (!vertex || *next_missing < vertex->node.id)) {
        file_.graph.nodes.push_back({*next_missing++, Pose::Identity()});
        initialized.push_back(false);
      }
    };
    for (const Vertex& vertex : vertices_) {
      add_missing_before(&vertex);
      file_.graph.nodes.push_back(vertex.node);
      initialized.push_back(true);
    }
    add_missing_before(nullptr);
    vertices_ = {};
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
  /// A vertex and its line.
  struct Vertex {
    PoseNode node;
    int line = 0;
  };
  std::vector<Vertex> vertices_;
  std::map<std::string, int> unknown_;
  std::size_t missing_ = 0;
  std::size_t repaired_ = 0;
};

void append_pose(std::string& line, const Pose& pose, bool planar) {
  for (int i = 0; i < (planar ? 2 : 3); ++i) append_number(line, pose.translation[i]);
  if (planar) {
    append_number(line, yaw_of(pose.rotation));
    return;
  }
  for (int i = 0; i < 4; ++i) append_number(line, pose.rotation.coeffs()[i]);
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
  std::string line;
  for (const PoseNode& node : graph.nodes) {
    line = (graph.planar ? "VERTEX_SE2 " : "VERTEX_SE3:QUAT ") + std::to_string(node.id);
    append_pose(line, node.pose, graph.planar);
    out << line << '\n';
  }
  for (const PoseEdge& edge : graph.edges) {
    line = (graph.planar ? "EDGE_SE2 " : "EDGE_SE3:QUAT ") + std::to_string(edge.from) + ' ' +
           std::to_string(edge.to);
    append_pose(line, edge.T_from_to, graph.planar);
    visit_information(graph.planar, [&](int row, int column) {
      append_number(line, edge.information(row, column));
    });
    out << line << '\n';
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
