// SPDX-License-Identifier: BSD-3-Clause
#include "run_record.hpp"

#include <algorithm>
#include <ctime>
#include <fstream>
#include <limits>
#include <sstream>
#include <type_traits>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

#include "digest.hpp"
#include "json.hpp"

namespace lidar_mapping::report {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFile = "run.json";

/// Digest of both ends of a file, which is enough because the index of a bag is at its end.
std::string digest_of(const fs::path& file, std::uintmax_t bytes) {
  constexpr std::uintmax_t kEnd = 65'536;
  std::ifstream stream(file, std::ios::binary);
  Digest digest;
  std::string part(std::min(bytes, kEnd), '\0');
  for (const std::uintmax_t begin : {std::uintmax_t{0}, bytes - part.size()}) {
    stream.seekg(static_cast<std::streamoff>(begin));
    stream.read(part.data(), static_cast<std::streamsize>(part.size()));
    digest.add(part);
  }
  if (!stream) throw FileError("cannot read " + file.string());
  return digest.text();
}

RecordedFile folder_of_scans(const fs::path& path) {
  std::vector<std::string> lines;
  RecordedFile folder{fs::canonical(path).filename(), 0, ""};
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (!entry.is_regular_file()) continue;
    folder.bytes += entry.file_size();
    lines.push_back(fs::relative(entry.path(), path).string() + " " +
                    std::to_string(entry.file_size()) + "\n");
  }
  std::sort(lines.begin(), lines.end());
  Digest digest;
  for (const std::string& line : lines) digest.add(line);
  folder.digest = digest.text();
  return folder;
}

json::Json to_json(const RunRecord& record) {
  json::Json files = json::Json::array();
  for (const RecordedFile& file : record.files) {
    files.push_back({{"name", file.name}, {"bytes", file.bytes}, {"digest", file.digest}});
  }
  return {{"software", record.software},
          {"command", record.command},
          {"date", record.date},
          {"recording",
           {{"files", files},
            {"begin_ns", record.begin},
            {"end_ns", record.end},
            {"start_s", record.start},
            {"topics", record.topics},
            {"sensor_height_m", record.sensor_height},
            {"sensors", record.sensors}}},
          {"complete", record.is_complete}};
}

/// Reads a number strictly: the library would also convert true, 1e300 and -1.
template <typename Number = std::int64_t>
Number whole_number(const json::Json& json) {
  // Largest value of the type.
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<Number>::max());
  const bool is_small = json.is_number_unsigned() && json.get<std::uint64_t>() <= kMost;
  const bool is_negative = json.is_number_integer() && !json.is_number_unsigned();
  if (is_small || (is_negative && std::is_signed_v<Number>)) return json.get<Number>();
  throw InputError(json::dumped(json) + " is no whole number");
}

RunRecord record_of(const json::Json& json) {
  const json::Json& recording = json.at("recording");
  RunRecord record;
  record.software = json.at("software");
  record.command = json.at("command");
  record.date = json.at("date");
  for (const json::Json& file : recording.at("files")) {
    record.files.push_back(
        {file.at("name"), whole_number<std::uintmax_t>(file.at("bytes")), file.at("digest")});
  }
  record.begin = whole_number(recording.at("begin_ns"));
  record.end = whole_number(recording.at("end_ns"));
  record.start = recording.at("start_s");
  record.topics = recording.at("topics").get<std::map<std::string, std::string>>();
  record.sensor_height = recording.at("sensor_height_m");
  record.sensors = recording.at("sensors").get<std::vector<std::string>>();
  record.is_complete = json.at("complete");
  return record;
}

/// Sorts the files by content, because a user may name the parts of a drive in any order.
std::vector<RecordedFile> by_content(std::vector<RecordedFile> files) {
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return a.digest < b.digest; });
  return files;
}

bool is_same(const RecordedFile& a, const RecordedFile& b) {
  return a.bytes == b.bytes && a.digest == b.digest;
}

std::string names_of(const std::vector<RecordedFile>& files) {
  std::vector<std::string> names;
  for (const RecordedFile& file : files) {
    names.push_back(file.name + " (" + std::to_string(file.bytes) + " bytes)");
  }
  return joined(names);
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const std::size_t begin = line.find_first_not_of(' ');
    if (begin != std::string::npos && line[begin] != '#') lines.push_back(line.substr(begin));
  }
  return lines;
}

}  // namespace

RecordedFile recorded_file(const fs::path& path) try {
  if (fs::is_directory(path)) return folder_of_scans(path);
  const std::uintmax_t bytes = fs::file_size(path);
  return {path.filename(), bytes, digest_of(path, bytes)};
} catch (const fs::filesystem_error& error) {
  throw FileError(std::string("cannot read the recording: ") + error.what());
}

std::optional<RunRecord> read_run_record(const fs::path& session) {
  std::ifstream stream(session / kFile);
  if (!stream) return std::nullopt;
  try {
    return record_of(json::Json::parse(stream));
  } catch (const std::exception& error) {  // the library's, or that of whole_number()
    throw InputError((session / kFile).string() + " is damaged: " + error.what());
  }
}

void write_run_record(const fs::path& session, const RunRecord& record) {
  write_text_atomically(session / kFile, json::dumped(to_json(record), 2) + "\n");
}

std::string recording_difference(const RunRecord& session, const RunRecord& given) {
  const auto ours = by_content(session.files);
  const auto theirs = by_content(given.files);
  if (!std::equal(ours.begin(), ours.end(), theirs.begin(), theirs.end(), is_same)) {
    return "it was made from " + names_of(session.files) + ", not from " + names_of(given.files);
  }
  for (const auto& [sensor, topic] : session.topics) {
    const auto found = given.topics.find(sensor);
    if (found != given.topics.end() && found->second == topic) continue;
    const std::string other = found == given.topics.end() ? "" : found->second;
    return "it was made with " + (topic.empty() ? "no topic" : topic) + " as " + sensor +
           ", not with " + (other.empty() ? "none" : other);
  }
  if (session.begin != given.begin || session.end != given.end) {
    return "the stamps of its recording are others";
  }
  if (session.start != given.start) {
    return "it was made with --start " + std::to_string(session.start);
  }
  if (session.sensor_height != given.sensor_height) {
    return "it was made with --sensor-height " + std::to_string(session.sensor_height);
  }
  return "";
}

std::string parameter_difference(const std::map<std::string, std::string>& session,
                                 const std::map<std::string, std::string>& given) {
  for (const auto& [stage, text] : session) {
    const auto found = given.find(stage);
    if (found == given.end()) continue;
    const auto ours = lines_of(text);
    const auto theirs = lines_of(found->second);
    const auto [a, b] = std::mismatch(ours.begin(), ours.end(), theirs.begin(), theirs.end());
    if (a == ours.end() && b == theirs.end()) continue;
    const auto line = [](auto it, auto end) { return it == end ? std::string("nothing") : *it; };
    return stage + " had '" + line(a, ours.end()) + "', now '" + line(b, theirs.end()) + "'";
  }
  return "";
}

std::string utc(std::time_t seconds) {
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  char text[40];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", &parts);
  return text;
}

}  // namespace lidar_mapping::report
