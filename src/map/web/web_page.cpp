// SPDX-License-Identifier: BSD-3-Clause
#include "web/web_page.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include <Eigen/Geometry>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/dates.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"

#include "files/millimetre_frame.hpp"
#include "gis/change_files.hpp"
#include "json.hpp"
#include "web/web_assets.hpp"

namespace lidar_mapping::map {

namespace {

namespace fs = std::filesystem;
using json::Json;

// Bytes of points in overview.js. Chosen: 300,000 points, which a browser reads in some 0.2 s.
constexpr std::uintmax_t kOverviewBytes = 7'200'000;

double rounded(double metres) { return std::round(metres / kMillimetre) * kMillimetre; }

Json rounded(const Eigen::Vector3d& p) { return {rounded(p.x()), rounded(p.y()), rounded(p.z())}; }

/// A position in the coordinates of the tiles, which are those of the frame.
Json in_tiles(const MillimetreFrame& frame, const Eigen::Vector3d& p_map) {
  return rounded(frame.projected(p_map));
}

Json drives_of(const DriveMarks& marks, const MillimetreFrame& frame) {
  std::map<std::uint32_t, Json> drives;
  for (const PathPoint& point : marks.path) {
    Json& drive = drives[point.segment];
    drive["number"] = point.segment;
    drive["path"].push_back(in_tiles(frame, point.p_map));
  }
  Json list = Json::array();
  for (const auto& [number, drive] : drives) list.push_back(drive);
  return list;
}

Json loops_of(const DriveMarks& marks, const MillimetreFrame& frame) {
  std::map<KeyFrameIndex, Eigen::Vector3d> positions;
  for (const PathPoint& point : marks.path) positions[point.index] = point.p_map;
  Json list = Json::array();
  for (const LoopMark& loop : marks.loops) {
    list.push_back({{"from", in_tiles(frame, positions.at(loop.from))},
                    {"to", in_tiles(frame, positions.at(loop.to))},
                    {"verdict", to_string(loop.verdict)}});
  }
  return list;
}

Json doubts_of(const DriveMarks& marks, const MillimetreFrame& frame) {
  Json list = Json::array();
  for (const DoubtMark& doubt : marks.doubts) {
    Json path = Json::array();
    for (const Eigen::Vector3d& p_map : doubt.path_map) path.push_back(in_tiles(frame, p_map));
    const bool is_known = std::isfinite(doubt.expected_error);
    list.push_back({{"kind", doubt.kind},
                    {"length", rounded(doubt.length)},
                    {"error", is_known ? Json(rounded(doubt.expected_error)) : Json(nullptr)},
                    {"trusted", doubt.is_trusted},
                    {"path", path}});
  }
  return list;
}

Json changes_of(const WebPage& page, const MillimetreFrame& frame) {
  Json list = Json::array();
  for (const moving_objects::Change& change : page.changes) {
    const Eigen::AlignedBox3d box(change.low, change.high);
    Json corners = Json::array();
    // By bits, as Eigen numbers them: 1, 2 and 4 are the upper ends along x, y and z.
    for (int number = 0; number < 8; ++number) {
      const auto corner = static_cast<Eigen::AlignedBox3d::CornerType>(number);
      corners.push_back(in_tiles(frame, box.corner(corner)));
    }
    const auto [after, before] = interval_of(change, page.visits);
    list.push_back({{"number", list.size() + 1},
                    {"kind", moving_objects::to_string(change.kind)},
                    {"after", iso_date(after)},
                    {"before", iso_date(before)},
                    {"size", rounded(Eigen::Vector3d(box.sizes()))},
                    {"corners", corners}});
  }
  return list;
}

/// A script that hands values to the page: scripts are all that a page opened as a file may read.
std::string script(const char* name, const Json& value) {
  return std::string("window.lidarMap = window.lidarMap || {};\nlidarMap.") + name + " = " +
         json::dumped(value) + ";\n";
}

std::string marks_script(const WebPage& page) {
  const MillimetreFrame frame(page.datum);
  Json marks = {{"title", page.title},
                {"epsg", frame.epsg()},
                {"resolution", page.resolution},
                {"drives", drives_of(page.marks, frame)},
                {"loops", loops_of(page.marks, frame)},
                {"doubts", doubts_of(page.marks, frame)},
                {"changes", changes_of(page, frame)}};
  return script("marks", marks);
}

std::string content_of(const fs::path& path) {
  std::ifstream file = open_for_reading(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string base64(const std::string& bytes) {
  static const char* const kLetters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(bytes.size() / 3 * 4 + 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8U | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? kLetters[group >> (18U - 6U * k) & 63U] : '=';
    }
  }
  return text;
}

/// The nodes of the tiles from the coarsest on.
std::vector<fs::path> nodes_by_depth(const fs::path& tiles) {
  std::vector<std::pair<int, fs::path>> nodes;
  for (const auto& entry : fs::directory_iterator(tiles / "ept-data")) {
    nodes.emplace_back(std::stoi(entry.path().stem().string()), entry.path());
  }
  std::sort(nodes.begin(), nodes.end());
  std::vector<fs::path> paths;
  for (const auto& [depth, path] : nodes) paths.push_back(path);
  return paths;
}

/// The metadata and the nodes that fit; a node never comes without its ancestors, since a level
/// that does not fit ends the list.
std::string overview_script(const fs::path& tiles) {
  Json nodes = Json::object();
  std::uintmax_t bytes = 0;
  for (const fs::path& path : nodes_by_depth(tiles)) {
    bytes += fs::file_size(path);
    if (!nodes.empty() && bytes > kOverviewBytes) break;
    nodes[path.stem().string()] = base64(content_of(path));
  }
  return script("overview",
                {{"ept", Json::parse(content_of(tiles / "ept.json"))}, {"nodes", nodes}});
}

}  // namespace

fs::path find_three(const std::vector<fs::path>& places) {
  for (const fs::path& place : places) {
    if (fs::exists(place)) return place;
  }
  throw InputError("the page in the browser needs three.js, which is not in " +
                   places.front().string() +
                   "; install the package libjs-three, or leave out the format web");
}

const std::vector<fs::path>& three_places() {
  static const std::vector<fs::path> places = {"/usr/share/javascript/three/build/three.min.js",
                                               "/usr/share/javascript/three/three.min.js",
                                               "/usr/share/nodejs/three/build/three.min.js"};
  return places;
}

std::string web_obstacle() {
  try {
    find_three(three_places());
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

void add_web_page(const WebPage& page, const fs::path& tiles) {
  const fs::path viewer = tiles / "viewer";
  write_text_atomically(viewer / "three.min.js", content_of(find_three(three_places())));
  write_text_atomically(viewer / "marks.js", marks_script(page));
  write_text_atomically(viewer / "overview.js", overview_script(tiles));
  for (const WebAsset& asset : web_assets()) write_text_atomically(tiles / asset.name, asset.text);
}

}  // namespace lidar_mapping::map
