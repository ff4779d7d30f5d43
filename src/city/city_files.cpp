// SPDX-License-Identifier: BSD-3-Clause
#include "city_files.hpp"

#include <cstdlib>
#include <fstream>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

#include "json.hpp"

namespace lidar_mapping::city {

namespace {

namespace fs = std::filesystem;
using json::Json;

void write(const Json& value, const fs::path& path) {
  write_text_atomically(path, json::dumped(value, 1) + "\n");
}

/// Calls `parse` with the content of a file; what is wrong with it becomes an InputError that names
/// the file.
template <typename Parse>
auto parsed(const fs::path& path, const Parse& parse) {
  std::ifstream stream(path);
  if (!stream) throw FileError("cannot read " + path.string());
  try {
    return parse(Json::parse(stream));
  } catch (const std::exception& error) {  // of JSON, or an InputError of `parse`
    throw InputError(path.string() + " is damaged (" + error.what() +
                     "); delete it and run the job again");
  }
}

Json to_json(const Pose& pose) {
  const Eigen::Vector3d& p = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
}

Pose pose_from(const Json& values) {
  const auto v = values.get<std::array<double, 7>>();
  Pose pose;
  pose.translation = {v[0], v[1], v[2]};
  pose.rotation = Eigen::Quaterniond(v[6], v[3], v[4], v[5]);
  return pose;
}

Json to_json(const Covariance6& covariance) {
  return std::vector<double>(covariance.data(), covariance.data() + covariance.size());
}

Covariance6 covariance_from(const Json& values) {
  const auto v = values.get<std::array<double, 36>>();
  return Eigen::Map<const Covariance6>(v.data());
}

Json to_json(const Loop& loop) {
  return {{"from", loop.from},
          {"to", loop.to},
          {"stamp", loop.stamp},
          {"T_from_to", to_json(loop.T_from_to)},
          {"covariance", to_json(loop.covariance)},
          {"fitness", loop.fitness},
          {"overlap", loop.overlap},
          {"source", to_string(loop.source)}};
}

Loop loop_from(const Json& json) {
  Loop loop;
  json.at("from").get_to(loop.from);
  json.at("to").get_to(loop.to);
  json.at("stamp").get_to(loop.stamp);
  loop.T_from_to = pose_from(json.at("T_from_to"));
  loop.covariance = covariance_from(json.at("covariance"));
  json.at("fitness").get_to(loop.fitness);
  json.at("overlap").get_to(loop.overlap);
  loop.source = loop_source_from(json.at("source").get<std::string>());
  return loop;
}

Json to_json(const LoopVerdict& verdict) {
  return {{"from", verdict.from},
          {"to", verdict.to},
          {"source", to_string(verdict.source)},
          {"verdict", to_string(verdict.verdict)},
          {"reason", verdict.reason},
          {"distance", verdict.distance},
          {"fitness", verdict.fitness},
          {"overlap", verdict.overlap}};
}

LoopVerdict verdict_from_json(const Json& json) {
  LoopVerdict verdict;
  json.at("from").get_to(verdict.from);
  json.at("to").get_to(verdict.to);
  verdict.source = loop_source_from(json.at("source").get<std::string>());
  verdict.verdict = verdict_from(json.at("verdict").get<std::string>());
  json.at("reason").get_to(verdict.reason);
  json.at("distance").get_to(verdict.distance);
  json.at("fitness").get_to(verdict.fitness);
  json.at("overlap").get_to(verdict.overlap);
  return verdict;
}

/// Two hexadecimal digits for each byte.
std::string to_text(const AppearanceKey& key) {
  std::string text;
  for (const std::uint8_t byte : key) text += formatted("%02x", byte);
  return text;
}

AppearanceKey key_from(const std::string& text) {
  AppearanceKey key{};
  if (text.size() != 2 * key.size() ||
      text.find_first_not_of("0123456789abcdef") != std::string::npos) {
    throw InputError("an appearance has " + std::to_string(text.size()) + " digits instead of " +
                     std::to_string(2 * key.size()));
  }
  for (std::size_t i = 0; i < key.size(); ++i) {
    key[i] = static_cast<std::uint8_t>(std::strtoul(text.substr(2 * i, 2).c_str(), nullptr, 16));
  }
  return key;
}

Json to_json(const Eigen::AlignedBox3d& box) {
  return {box.min().x(), box.min().y(), box.min().z(), box.max().x(), box.max().y(), box.max().z()};
}

Json to_json(const Piece& piece) {
  Json places = Json::array();
  for (const AppearanceKey& key : piece.places) places.push_back(to_text(key));
  return {{"first", piece.first},
          {"last", piece.last},
          {"box", piece.box ? to_json(*piece.box) : Json()},
          {"places", places}};
}

Piece piece_from(const Json& json) {
  Piece piece;
  json.at("first").get_to(piece.first);
  json.at("last").get_to(piece.last);
  if (!json.at("box").is_null()) {
    const auto v = json.at("box").get<std::array<double, 6>>();
    piece.box.emplace(Eigen::Vector3d(v[0], v[1], v[2]), Eigen::Vector3d(v[3], v[4], v[5]));
  }
  for (const Json& key : json.at("places")) {
    piece.places.push_back(key_from(key.get<std::string>()));
  }
  return piece;
}

Json to_json(const std::vector<KeyFrameRange>& ranges) {
  Json result = Json::array();
  for (const KeyFrameRange& range : ranges) result.push_back({range.first, range.last});
  return result;
}

std::vector<KeyFrameRange> ranges_from(const Json& json) {
  std::vector<KeyFrameRange> ranges;
  for (const auto& [first, last] :
       json.get<std::vector<std::pair<KeyFrameIndex, KeyFrameIndex>>>()) {
    ranges.push_back({first, last});
  }
  return ranges;
}

Json to_json(const Chunk& chunk) {
  return {{"id", chunk.id},
          {"a", chunk.a},
          {"b", chunk.b},
          {"a_ranges", to_json(chunk.a_ranges)},
          {"b_ranges", to_json(chunk.b_ranges)},
          {"by_position", chunk.by_position},
          {"by_appearance", chunk.by_appearance}};
}

Json to_json(const JoinedDrive& drive) {
  return {
      {"name", drive.name},
      {"state", to_string(drive.state)},
      {"notices", drive.notices},
      {"has_gnss", drive.has_gnss},
      {"uses_gnss", drive.uses_gnss},
      {"first_key_frame", drive.key_frames.empty() ? Json() : Json(drive.key_frames.front().index)},
      {"key_frames", drive.key_frames.size()},
      {"key_frames_left_out", drive.left_out},
      {"loops_used", drive.loops.used},
      {"loops_refused", drive.loops.refused}};
}

}  // namespace

void write_pieces(const DrivePieces& drive, const fs::path& path) {
  Json pieces = Json::array();
  for (const Piece& piece : drive.pieces) pieces.push_back(to_json(piece));
  write({{"drive", drive.drive}, {"pieces", pieces}}, path);
}

DrivePieces read_pieces(const fs::path& path) {
  return parsed(path, [](const Json& json) {
    DrivePieces drive;
    json.at("drive").get_to(drive.drive);
    for (const Json& piece : json.at("pieces")) drive.pieces.push_back(piece_from(piece));
    return drive;
  });
}

void write_chunks(const std::vector<Chunk>& chunks, const fs::path& folder) {
  fs::create_directories(folder);
  for (const Chunk& chunk : chunks) write(to_json(chunk), folder / (chunk.id + ".json"));
}

Chunk read_chunk(const fs::path& path) {
  return parsed(path, [](const Json& json) {
    Chunk chunk;
    json.at("id").get_to(chunk.id);
    json.at("a").get_to(chunk.a);
    json.at("b").get_to(chunk.b);
    chunk.a_ranges = ranges_from(json.at("a_ranges"));
    chunk.b_ranges = ranges_from(json.at("b_ranges"));
    json.at("by_position").get_to(chunk.by_position);
    json.at("by_appearance").get_to(chunk.by_appearance);
    return chunk;
  });
}

void write_loops(const PairLoops& pair, const fs::path& path) {
  Json loops = Json::array(), verdicts = Json::array();
  for (const Loop& loop : pair.loops) loops.push_back(to_json(loop));
  for (const LoopVerdict& verdict : pair.verdicts) verdicts.push_back(to_json(verdict));
  write({{"a", pair.a},
         {"b", pair.b},
         {"used_gnss", pair.used_gnss},
         {"searched", pair.searched},
         {"loops", loops},
         {"verdicts", verdicts}},
        path);
}

PairLoops read_loops(const fs::path& path) {
  return parsed(path, [](const Json& json) {
    PairLoops pair;
    json.at("a").get_to(pair.a);
    json.at("b").get_to(pair.b);
    json.at("used_gnss").get_to(pair.used_gnss);
    json.at("searched").get_to(pair.searched);
    for (const Json& loop : json.at("loops")) pair.loops.push_back(loop_from(loop));
    for (const Json& verdict : json.at("verdicts")) {
      pair.verdicts.push_back(verdict_from_json(verdict));
    }
    return pair;
  });
}

void write_joined(const JoinedCity& city, const fs::path& path) {
  Json drives = Json::array();
  for (const JoinedDrive& drive : city.drives) drives.push_back(to_json(drive));
  Json datum;
  if (city.datum) {
    datum = {{"latitude_deg", city.datum->latitude_deg},
             {"longitude_deg", city.datum->longitude_deg},
             {"altitude_m", city.datum->altitude_m}};
  }
  write({{"datum", datum}, {"drives", drives}, {"loops_between_drives", city.loops.size()}}, path);
}

}  // namespace lidar_mapping::city
